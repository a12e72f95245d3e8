//! Brings meshes into the form that the renderer needs: removes triangles without area and unused vertices, makes normals
//! and tangents unit vectors, fills in missing normals, and clamps vertex colours to [0, 1]. Notices tell the user about
//! most of these changes. There is no notice about small corrections of normals, about tangents or about unused vertices.

use super::notices::{Tally, label};
use super::{Material, Mesh};
use glam::{DVec3, Vec3, Vec4};

/// The difference of a normal's squared length from 1 above which the normal is normalised. With smaller differences, which
/// rounding to f32 can cause, the normal stays unchanged, so that a second repair changes nothing.
const UNIT_TOLERANCE: f64 = 1e-6;

/// The difference of a normal's squared length from 1 above which the user gets a notice that the normal was normalised.
/// Smaller differences are no fault of a file: they can arise where it stores normals in signed bytes, which rounds them.
const NOTICED_TOLERANCE: f64 = 2e-2;

impl Mesh {
    /// Removes triangles without area and unused vertices, makes normals and tangents unit vectors, fills in missing
    /// normals, and clamps vertex colours to [0, 1]. All indices must be in range and all numbers finite. `index` is the
    /// mesh's index in the scene, for the notices about the changes, which are added to `tally`.
    pub(super) fn repair(&mut self, index: usize, tally: &mut Tally) {
        let name = self.name.clone();
        let location = || label("mesh", index, &name);
        let flat = self.drop_degenerate_triangles();
        tally.add_many("triangles without area are removed", flat, location);
        if !self.normals.is_empty() {
            let odd = self.normalize_normals();
            tally.add_many(
                "normals that were not of unit length are made so",
                odd,
                location,
            );
            let missing = self.fill_missing_normals();
            tally.add_many(
                "vertices without a usable normal take the geometric one",
                missing,
                location,
            );
        }
        self.normalize_tangents();
        let odd = self.clamp_colors();
        tally.add_many("vertex colours outside [0, 1] are clamped", odd, location);
        self.drop_unused_vertices();
    }

    /// Repairs a mesh and makes its tangents, before it is deformed. Returns, for each vertex, its index before the repair.
    /// `index` is the index of the mesh in the scene, for notices. A part may have the index behind the last of `materials`: that
    /// of the default material.
    pub(crate) fn prepare_to_deform(
        &mut self,
        index: usize,
        materials: &[Material],
        tally: &mut Tally,
    ) -> Vec<u32> {
        self.sources = (0..self.positions.len() as u32).collect();
        self.repair(index, tally);
        let count = materials.len();
        match self
            .parts
            .iter()
            .any(|part| part.material as usize == count)
        {
            false => self.make_tangents(materials),
            // The default material, which the reader adds at the end.
            true => self.make_tangents(&[materials, &[Material::default()]].concat()),
        }
        std::mem::take(&mut self.sources)
    }

    /// Clamps the channels of vertex colours to [0, 1]. Returns the number of vertices whose colour changed, for a notice.
    fn clamp_colors(&mut self) -> usize {
        let mut odd = 0;
        for color in &mut self.colors {
            let clamped = color.clamp(Vec4::ZERO, Vec4::ONE);
            odd += usize::from(clamped != *color);
            *color = clamped;
        }
        odd
    }

    /// The cross product of two edges of a triangle, in object space. It points along the triangle's geometric normal, and
    /// its length is twice the triangle's area, so it is 0 for a triangle without area, which repairs remove. `triangle`
    /// contains the indices of the three vertices.
    pub(super) fn area_vector(&self, triangle: [u32; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|i| self.positions[i as usize].as_dvec3());
        (b - a).cross(c - a)
    }

    fn drop_degenerate_triangles(&mut self) -> usize {
        let before = self.triangles.len();
        let mut kept = 0;
        let mut parts = std::mem::take(&mut self.parts);
        for part in &mut parts {
            let first = part.first_triangle as usize;
            part.first_triangle = kept as u32;
            for i in first..first + part.triangle_count as usize {
                if self.area_vector(self.triangles[i]) != DVec3::ZERO {
                    self.triangles[kept] = self.triangles[i];
                    kept += 1;
                }
            }
            part.triangle_count = kept as u32 - part.first_triangle;
        }
        parts.retain(|part| part.triangle_count > 0);
        self.parts = parts;
        self.triangles.truncate(kept);
        before - kept
    }

    /// Makes all normals unit vectors, except those of zero length. Returns the number of normals whose squared length
    /// differed from 1 by more than [`NOTICED_TOLERANCE`], for a notice.
    fn normalize_normals(&mut self) -> usize {
        let mut odd = 0;
        for normal in &mut self.normals {
            let n = normal.as_dvec3();
            let off = (n.length_squared() - 1.0).abs();
            if off > UNIT_TOLERANCE && n != DVec3::ZERO {
                *normal = n.normalize().as_vec3();
                odd += usize::from(off > NOTICED_TOLERANCE);
            }
        }
        odd
    }

    /// Makes tangents unit vectors, and sets w, the sign of the bitangent, to −1 or 1. A tangent shorter than 0.001 has no
    /// usable direction and becomes 0; [`Mesh::make_tangents`] later computes a new one if the material has a normal map.
    fn normalize_tangents(&mut self) {
        for tangent in &mut self.tangents {
            // In f32 the square of a length above 1e19 overflows.
            let direction = tangent.truncate().as_dvec3();
            let length = direction.length();
            if length < 1e-3 {
                *tangent = Vec4::ZERO;
            } else if (length - 1.0).abs() > 1e-6 || tangent.w.abs() != 1.0 {
                let sign = if tangent.w < 0.0 { -1.0 } else { 1.0 };
                *tangent = (direction / length).as_vec3().extend(sign);
            }
        }
    }

    /// Sets normals of zero length, which count as missing, to the geometric normal of their triangle. A vertex with a
    /// missing normal is duplicated if its triangles have different geometric normals. If all normals of the mesh are
    /// missing, `normals` becomes empty instead, so that the mesh is shaded with geometric normals. Returns the number of
    /// missing normals, for a notice.
    pub(crate) fn fill_missing_normals(&mut self) -> usize {
        let is_missing: Vec<bool> = self.normals.iter().map(|&n| n == Vec3::ZERO).collect();
        let missing = is_missing.iter().filter(|&&m| m).count();
        if missing == is_missing.len() {
            self.normals.clear();
        }
        if missing == 0 || self.normals.is_empty() {
            return missing;
        }
        for i in 0..self.triangles.len() {
            let triangle = self.triangles[i];
            let normal = self.area_vector(triangle).normalize_or_zero().as_vec3();
            for (corner, vertex) in triangle.into_iter().enumerate() {
                let vertex = vertex as usize;
                if !is_missing[vertex] || self.normals[vertex] == normal {
                    continue;
                }
                if self.normals[vertex] == Vec3::ZERO {
                    self.normals[vertex] = normal;
                    continue;
                }
                let Some(copy) = self.duplicate_vertex(vertex as u32) else {
                    continue; // no index is left for a copy, so the neighbour's normal is used
                };
                self.normals[copy as usize] = normal;
                self.triangles[i][corner] = copy;
            }
        }
        missing
    }

    /// Appends a copy of the vertex with the index `vertex`, with all its attributes, so that two triangles that share the
    /// vertex can have different normals or tangents there. Returns the index of the copy; `None`, without a copy, if the
    /// index would exceed 32 bits.
    pub(super) fn duplicate_vertex(&mut self, vertex: u32) -> Option<u32> {
        let (vertex, copy) = (vertex as usize, u32::try_from(self.positions.len()).ok()?);
        self.positions.push(self.positions[vertex]);
        if !self.normals.is_empty() {
            self.normals.push(self.normals[vertex]);
        }
        for values in [&mut self.colors, &mut self.tangents] {
            if !values.is_empty() {
                values.push(values[vertex]);
            }
        }
        for uvs in self.uvs.iter_mut().filter(|uvs| !uvs.is_empty()) {
            uvs.push(uvs[vertex]);
        }
        if !self.sources.is_empty() {
            self.sources.push(self.sources[vertex]);
        }
        Some(copy)
    }

    pub(super) fn drop_unused_vertices(&mut self) {
        let mut moved = vec![u32::MAX; self.positions.len()];
        for &vertex in self.triangles.as_flattened() {
            moved[vertex as usize] = 0;
        }
        if !moved.contains(&u32::MAX) {
            return;
        }
        let mut kept = 0;
        for (vertex, index) in moved.iter_mut().enumerate() {
            if *index == u32::MAX {
                continue;
            }
            *index = kept as u32;
            self.positions[kept] = self.positions[vertex];
            if !self.normals.is_empty() {
                self.normals[kept] = self.normals[vertex];
            }
            for values in [&mut self.colors, &mut self.tangents] {
                if !values.is_empty() {
                    values[kept] = values[vertex];
                }
            }
            for uvs in self.uvs.iter_mut().filter(|uvs| !uvs.is_empty()) {
                uvs[kept] = uvs[vertex];
            }
            if !self.sources.is_empty() {
                self.sources[kept] = self.sources[vertex];
            }
            kept += 1;
        }
        self.positions.truncate(kept);
        self.normals.truncate(kept);
        self.colors.truncate(kept);
        self.tangents.truncate(kept);
        self.uvs.iter_mut().for_each(|uvs| uvs.truncate(kept));
        self.sources.truncate(kept);
        for vertex in self.triangles.as_flattened_mut() {
            *vertex = moved[*vertex as usize];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Part;
    use super::*;

    fn part(first_triangle: u32, triangle_count: u32, material: u32) -> Part {
        Part {
            first_triangle,
            triangle_count,
            material,
        }
    }

    /// A mesh of two triangles that meet at an edge. One faces +Z, the other one +X.
    fn roof() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            parts: vec![part(0, 2, 0)],
            ..Mesh::default()
        }
    }

    fn repair(mesh: &mut Mesh) -> Vec<String> {
        let mut tally = Tally::default();
        mesh.repair(4, &mut tally);
        tally.into_lines().collect()
    }

    #[test]
    fn triangles_without_area_go_and_parts_follow() {
        let mut mesh = roof();
        mesh.positions.push(Vec3::new(2.0, 0.0, 0.0));
        mesh.triangles = vec![[0, 1, 4], [0, 1, 2], [1, 1, 2], [0, 2, 3], [3, 3, 3]];
        mesh.parts = vec![part(0, 2, 0), part(2, 1, 1), part(3, 2, 2)];
        assert_eq!(
            repair(&mut mesh),
            ["triangles without area are removed: 3 times, first mesh 4"]
        );
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.parts, [part(0, 1, 0), part(1, 1, 2)]);
        assert_eq!(mesh.positions.len(), 4, "the unused vertex went");
        assert!(repair(&mut mesh).is_empty());
    }

    #[test]
    fn the_smallest_triangle_has_an_area() {
        let tiny = f32::from_bits(1);
        let mut mesh = roof();
        for p in &mut mesh.positions {
            *p *= tiny;
        }
        assert!(repair(&mut mesh).is_empty());
        assert_eq!(mesh.triangles.len(), 2);
    }

    #[test]
    fn tangents_become_unit_whatever_their_length() {
        let mut mesh = roof();
        let long = Vec3::new(3e38, -3e38, 0.0);
        mesh.tangents = vec![
            long.extend(0.5),
            (Vec3::X * 2e19).extend(-1e-30),
            (Vec3::Y * 1e-30).extend(1.0),
            Vec3::Z.extend(-1.0),
        ];
        let diagonal = std::f32::consts::FRAC_1_SQRT_2;
        let expected = [
            Vec4::new(diagonal, -diagonal, 0.0, 1.0),
            Vec4::new(1.0, 0.0, 0.0, -1.0),
            Vec4::ZERO,
            Vec4::new(0.0, 0.0, 1.0, -1.0),
        ];
        for _ in 0..2 {
            repair(&mut mesh);
            assert_eq!(mesh.tangents, expected);
        }
    }

    #[test]
    fn normals_become_unit() {
        let mut mesh = roof();
        mesh.normals = vec![Vec3::Z * 1e-30, Vec3::Z * 3.0, Vec3::Z * 1.0001, Vec3::X];
        assert_eq!(repair(&mut mesh).len(), 1);
        assert_eq!(mesh.normals, [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::X]);
    }

    #[test]
    fn missing_normals_are_the_planes_own() {
        let mut mesh = roof();
        mesh.normals = vec![Vec3::ZERO, Vec3::Z, Vec3::ZERO, Vec3::Y];
        assert_eq!(
            repair(&mut mesh),
            ["vertices without a usable normal take the geometric one: 2 times, first mesh 4"]
        );
        assert_eq!(mesh.positions.len(), 6);
        let shown: Vec<[Vec3; 3]> = mesh
            .triangles
            .iter()
            .map(|t| t.map(|i| mesh.normals[i as usize]))
            .collect();
        assert_eq!(shown, [[Vec3::Z; 3], [Vec3::X, Vec3::X, Vec3::Y]]);
        assert!(repair(&mut mesh).is_empty());
    }

    #[test]
    fn without_any_usable_normal_a_mesh_is_flat() {
        let mut mesh = roof();
        mesh.normals = vec![Vec3::ZERO; 4];
        repair(&mut mesh);
        assert!(mesh.normals.is_empty());
        assert_eq!(mesh.positions.len(), 4);
    }
}

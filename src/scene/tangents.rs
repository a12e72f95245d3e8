//! Computes the tangents that normal maps and anisotropic lobes need, for triangles to which the file gives none. The method is MikkTSpace, which
//! glTF requires.

use super::{Material, Mesh};
use bevy_mikktspace::{Geometry, TangentSpace};
use glam::{Vec2, Vec3, Vec4};

impl Mesh {
    /// Computes tangents for each triangle whose material needs them but that has no tangent at one or more of its corners. A vertex
    /// whose triangles need different tangents is duplicated. If no part of the mesh needs tangents, all of them are
    /// removed instead. The caller ensures that the mesh is valid and has no triangles without area.
    pub(crate) fn make_tangents(&mut self, materials: &[Material]) {
        let mapped = self.parts.iter().filter_map(|part| {
            let set = materials[part.material as usize].tangent_set()?;
            let first = part.first_triangle as usize;
            Some((first..first + part.triangle_count as usize, set as usize))
        });
        let mapped: Vec<_> = mapped.collect();
        if mapped.is_empty() {
            self.tangents.clear();
            return;
        }
        self.tangents.resize(self.positions.len(), Vec4::ZERO);
        for set in 0..self.uvs.len() {
            let faces = mapped.iter().filter(|(_, own)| *own == set);
            let faces = faces.flat_map(|(triangles, _)| triangles.clone());
            let lacks = |face: &usize| {
                let [a, b, c] = self.triangles[*face].map(|i| self.tangents[i as usize]);
                [a, b, c].contains(&Vec4::ZERO)
            };
            let faces: Vec<usize> = faces.filter(lacks).collect();
            if !faces.is_empty() {
                self.fill_tangents(&faces, set);
            }
        }
    }

    fn fill_tangents(&mut self, faces: &[usize], set: usize) {
        let mut made = Made {
            mesh: self,
            faces,
            set,
            tangents: vec![[Vec4::ZERO; 3]; faces.len()],
        };
        // The crate's error has no values.
        if bevy_mikktspace::generate_tangents(&mut made).is_err() {
            return;
        }
        let tangents = std::mem::take(&mut made.tangents);
        for (face, tangents) in faces.iter().zip(tangents) {
            for (corner, tangent) in tangents.into_iter().enumerate() {
                let vertex = self.triangles[*face][corner];
                let own = &mut self.tangents[vertex as usize];
                if *own == Vec4::ZERO {
                    *own = tangent;
                } else if *own != tangent
                    && let Some(copy) = self.duplicate_vertex(vertex)
                {
                    self.tangents[copy as usize] = tangent;
                    self.triangles[*face][corner] = copy;
                }
            }
        }
        // All triangles of a vertex may have taken copies of it.
        self.drop_unused_vertices();
    }
}

/// The data that the MikkTSpace crate reads and writes to compute tangents. `faces` are the indices of the triangles in
/// `mesh` that get tangents, and `set` is the set of texture coordinates that is read. The crate writes the tangents of the
/// three corners of each triangle to `tangents`, in the order of `faces`.
struct Made<'a> {
    mesh: &'a Mesh,
    faces: &'a [usize],
    set: usize,
    tangents: Vec<[Vec4; 3]>,
}

impl Made<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[self.faces[face]][corner] as usize
    }
}

impl Geometry for Made<'_> {
    fn num_faces(&self) -> usize {
        self.faces.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let normal = self.mesh.normals.get(self.vertex(face, corner)).copied();
        let flat = || self.mesh.area_vector(self.mesh.triangles[self.faces[face]]);
        normal
            .unwrap_or_else(|| flat().normalize().as_vec3())
            .to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // In glTF v points down, and the green of a normal map up.
        // Without texture coordinates all are the same.
        let uvs = self.mesh.uvs[self.set].get(self.vertex(face, corner));
        let Vec2 { x, y } = uvs.copied().unwrap_or_default();
        [x, 1.0 - y]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let made = space.map(|space| Vec4::from_array(space.tangent_encoded()));
        let usable =
            made.filter(|tangent| tangent.is_finite() && tangent.truncate().length_squared() > 0.5);
        // Where all texture coordinates are the same there is no direction, and any will do.
        let any = || {
            let normal = Vec3::from_array(self.normal(face, corner));
            normal.any_orthonormal_vector().extend(1.0)
        };
        self.tangents[face][corner] = usable.unwrap_or_else(any);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Part, Texture};
    use super::*;

    /// A square of two triangles in the plane of x and y; the second triangle has a mirrored texture.
    fn square() -> Mesh {
        let uv = |x: f32, y: f32| Vec2::new(x, 1.0 - y);
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            uvs: [
                vec![uv(0.0, 0.0), uv(1.0, 0.0), uv(1.0, 1.0), uv(2.0, 0.0)],
                vec![],
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            parts: vec![Part {
                first_triangle: 0,
                triangle_count: 2,
                material: 0,
            }],
            ..Mesh::default()
        }
    }

    fn mapped() -> Vec<Material> {
        vec![Material {
            normal_texture: Some(Texture::plain(0)),
            ..Material::default()
        }]
    }

    #[test]
    fn tangents_follow_the_texture_and_mirrored_ones_are_told_apart() {
        let mut mesh = square();
        mesh.make_tangents(&mapped());
        let corner = |mesh: &Mesh, face: usize, corner: usize| {
            mesh.tangents[mesh.triangles[face][corner] as usize]
        };
        // Along x, and y is up in the image: right-handed.
        for i in 0..3 {
            assert!((corner(&mesh, 0, i) - Vec4::new(1.0, 0.0, 0.0, 1.0)).length() < 1e-5);
            assert_eq!(corner(&mesh, 1, i).w, -1.0);
        }
        // Two corners are shared by both.
        assert_eq!(mesh.positions.len(), 6);
        assert_eq!(mesh.uvs[0].len(), 6);
        let before = mesh.tangents.clone();
        mesh.make_tangents(&mapped());
        assert_eq!(before, mesh.tangents);
    }

    #[test]
    fn vertices_whose_tangents_are_all_replaced_go() {
        let mut mesh = square();
        mesh.triangles.truncate(1);
        mesh.parts[0].triangle_count = 1;
        mesh.tangents = vec![Vec4::new(0.6, 0.8, 0.0, 1.0); 4];
        mesh.tangents[2] = Vec4::ZERO;
        mesh.make_tangents(&mapped());
        assert_eq!(mesh.positions.len(), 3);
        let before = mesh.tangents.clone();
        assert!(before.iter().all(|tangent| *tangent == before[0]));
        mesh.make_tangents(&mapped());
        assert_eq!(before, mesh.tangents);
    }

    #[test]
    fn a_texture_without_area_gets_some_tangent() {
        let mut mesh = square();
        mesh.uvs[0].fill(Vec2::ONE);
        mesh.make_tangents(&mapped());
        for tangent in &mesh.tangents {
            assert!((tangent.truncate().length() - 1.0).abs() < 1e-5 && tangent.z.abs() < 1e-5);
        }
    }

    #[test]
    fn without_a_normal_map_there_are_none() {
        let mut mesh = square();
        mesh.tangents = vec![Vec4::X; 4];
        mesh.make_tangents(&[Material::default()]);
        assert!(mesh.tangents.is_empty());
    }
}

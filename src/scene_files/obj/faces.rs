//! Adds the faces of an OBJ file to the current mesh: finds the elements that their corners name, and cuts polygons into
//! triangles.

use super::Reader;
use super::building::{Corner, MISSING};
use super::lines::Line;
use super::smoothing::SMOOTH;
use crate::Result;
use crate::scene::Bounds;
use crate::scene::notices::quoted;
use crate::scene_files::polygon::triangulate;
use glam::DVec3;

/// The memory that a corner of a face takes until the face is cut into triangles, in bytes. Before each face the reader
/// checks that this much is free for each corner; if it is not, loading ends with an error. The text of a corner has at least
/// two bytes, such as `1` and a space.
pub const CORNER_BYTES: u64 = 96;

/// An index of a corner of a face, as the file states it.
#[derive(Clone, Copy)]
pub enum Index<'a> {
    Missing,
    /// Counts from 1 or, if it is negative, backwards from the last element that was read so far.
    Number(i64),
    /// The word is not a whole number.
    Wrong(&'a str),
}

impl<'a> Index<'a> {
    /// The index of a plain face: 0 where the face states none.
    pub fn stated(number: i32) -> Self {
        match number {
            0 => Self::Missing,
            _ => Self::Number(number.into()),
        }
    }

    /// The indices of position, texture coordinates and normal in the word of a corner, such as `1/2/3`.
    pub fn of_corner(word: &'a str) -> [Self; 3] {
        let mut words = word.split('/');
        [(); 3].map(|()| match words.next().unwrap_or_default() {
            "" => Self::Missing,
            word => word.parse().map_or(Self::Wrong(word), Self::Number),
        })
    }
}

impl Reader<'_> {
    /// Adds a face to the current mesh. For each corner, `corners` has the indices of position, texture coordinates and
    /// normal, as the statement `line` states them. Fails if an index is wrong, or if the mesh has too many vertices.
    pub(super) fn face<'l>(
        &mut self,
        line: &Line,
        corners: impl Iterator<Item = [Index<'l>; 3]>,
    ) -> Result<()> {
        let material = match self.material {
            Some(material) => material,
            None => self.grey(),
        };
        let textured = self.maps[material as usize].all().next().is_some();
        self.corners.clear();
        self.points.clear();
        // By the mesh's own vertices, or where all vertices of a file come first, by all of them.
        if self.mesh.mesh.triangles.is_empty() && self.centered < self.positions.len() {
            self.center = center_of(&self.positions[self.centered..]);
            self.centered = self.positions.len();
        }
        for [position, coordinates, normal] in corners {
            let position = index(line, "vertex", position, self.positions.len())?;
            let or_missing = |kind: &str, stated: Index<'_>, count: usize| match stated {
                Index::Missing => Ok(MISSING),
                _ => index(line, kind, stated, count),
            };
            let normal = match or_missing("normal", normal, self.attributes.normals.len())? {
                MISSING => self.smoothing.normal_at(position),
                SMOOTH.. => return Err(line.wrong("it has a normal beyond 31 bits")),
                normal => normal,
            };
            let all = &self.attributes.coordinates;
            let mut coordinates = match textured {
                true => or_missing("texture coordinate", coordinates, all.len())?,
                false => MISSING,
            };
            if textured && coordinates == MISSING {
                let what = "texture coordinates are missing, 0 is used";
                self.ignored.tally.add(what, || line.location());
            }
            let at = all.get(coordinates as usize);
            if at.is_some_and(|at| !at.is_finite()) {
                let what = "texture coordinates are not finite, 0 is used";
                self.ignored.tally.add(what, || line.location());
                coordinates = MISSING;
            }
            let position_here = self.positions[position as usize] - self.center;
            self.points.push(position_here.as_vec3());
            self.corners.push(Corner {
                position,
                normal,
                coordinates,
            });
        }
        if self.corners.len() < 3 {
            let what = "faces of fewer than three corners are skipped";
            self.ignored.tally.add(what, || line.location());
            return Ok(());
        }
        let Self {
            corners,
            points,
            attributes,
            mesh,
            ..
        } = self;
        let vertices = mesh.mesh.positions.len() + corners.len();
        if vertices.max(mesh.mesh.triangles.len() + corners.len()) >= u32::MAX as usize {
            return Err(line.wrong("the object has more than 2³² vertices; split it"));
        }
        mesh.has_stated_normals |= corners.iter().any(|corner| corner.normal < SMOOTH);
        self.smoothing.add_face(corners, points);
        mesh.has_coordinates |= textured;
        triangulate(points, |triangle| {
            let triangle = triangle.map(|i| mesh.vertex(corners[i], points[i], attributes));
            mesh.push(triangle, material);
        });
        Ok(())
    }
}

/// Converts an index of OBJ to an index from 0, of `count` elements that were read so far. Fails if it is missing, not a
/// whole number or out of range; `kind` is the name of the elements in the error, such as `normal`.
fn index(line: &Line, kind: &str, stated: Index<'_>, count: usize) -> Result<u32> {
    let wrong = |word| Err(line.wrong(&format!("{} is not a {kind} index", quoted(word))));
    let number = match stated {
        Index::Number(number) => number,
        Index::Missing => return wrong(""),
        Index::Wrong(word) => return wrong(word),
    };
    let index = match number {
        1.. => number - 1,
        _ => number.saturating_add(count as i64),
    };
    if number == 0 || !(0..count as i64).contains(&index) {
        return Err(line.wrong(&format!(
            "{kind} {number} is out of range, there are {count} so far"
        )));
    }
    u32::try_from(index)
        .ok()
        .filter(|&index| index != MISSING)
        .ok_or_else(|| line.wrong(&format!("{kind} {number} is beyond 32 bits")))
}

/// The origin for a mesh with these positions, in the coordinates of the file. It is the centre of their bounding box if the
/// mesh is small and far away: if the absolute value of a coordinate of the centre is above 256 times the longest side of
/// the box. f32 positions relative to the centre are then precise enough. Otherwise the origin is 0.
fn center_of(positions: &[DVec3]) -> DVec3 {
    const FAR: f64 = 256.0;
    let bounds = Bounds::of(positions.iter().copied());
    let is_far = |b: &Bounds| b.center().abs().max_element() > FAR * b.size().max_element();
    bounds
        .filter(is_far)
        .map_or(DVec3::ZERO, |bounds| bounds.center())
}

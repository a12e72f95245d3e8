//! Groups of emissive triangles that are connected by common corners, as the triangles of one finely modelled emitter are.
//! The light BVH keeps a group in one leaf, unless the group is large compared with the scene, or its area is small compared
//! with the box around it. The renderer counts a group as one emitter where a setting, such as `candidates=auto`, depends on
//! the number of emitters.

use crate::scene::lights::EmitterTriangle;
use std::collections::HashMap;

/// For each triangle, the index in `triangles` of the first triangle of its group; triangles with equal results form one
/// group. Two triangles of an instance are in one group if they have a corner at the same position, or if other triangles of
/// the instance connect them in this way. The triangles of each instance must be consecutive.
pub fn connected(triangles: &[EmitterTriangle]) -> Vec<u32> {
    let mut firsts: Vec<u32> = (0..triangles.len() as u32).collect();
    let mut corners = HashMap::new();
    for (index, triangle) in (0..).zip(triangles) {
        if index > 0 && triangles[index as usize - 1].instance != triangle.instance {
            corners.clear();
        }
        for corner in triangle.corners {
            // Adding 0 makes the two zeros equal.
            let position = corner.to_array().map(|x| (x + 0.0).to_bits());
            let other = *corners.entry(position).or_insert(index);
            let (a, b) = (first(&mut firsts, index), first(&mut firsts, other));
            firsts[a.max(b) as usize] = a.min(b);
        }
    }
    (0..triangles.len() as u32)
        .map(|index| first(&mut firsts, index))
        .collect()
}

/// The index of the first triangle of the group that contains the triangle `index`; a group is triangles that are connected
/// by common corners. In `firsts`, each triangle refers to an earlier one of its group, or to itself if it is the first
/// (union-find). The search shortens these chains of references, so that later searches are faster.
fn first(firsts: &mut [u32], mut index: u32) -> u32 {
    while firsts[index as usize] != index {
        firsts[index as usize] = firsts[firsts[index as usize] as usize];
        index = firsts[index as usize];
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural;
    use crate::scene::lights::emitter_triangles;

    /// Generates the scene `scene` with one parameter set to `value`. Returns the number of groups of connected emissive
    /// triangles, and the number of emissive triangles.
    fn sets(scene: &str, parameter: &str, value: &str) -> (usize, usize) {
        let scene = procedural::generate(scene, &[(parameter.into(), value.into())]).unwrap();
        let triangles = emitter_triangles(&scene, &scene.emitter_materials());
        let mut firsts = connected(&triangles);
        assert!(firsts.iter().zip(0..).all(|(first, index)| *first <= index));
        firsts.sort_unstable();
        firsts.dedup();
        (firsts.len(), triangles.len())
    }

    #[test]
    fn an_emitter_of_many_triangles_is_one_group() {
        let (others, _) = sets("colourful-mess", "lamps", "0");
        let (all, triangles) = sets("colourful-mess", "lamps", "28");
        assert_eq!(all - others, 28);
        assert!(triangles > 100 * 28);
    }

    #[test]
    fn the_parts_of_a_divided_emitter_stay_one_group() {
        let (groups, triangles) = sets("night-city", "tessellation", "1");
        assert_eq!(
            sets("night-city", "tessellation", "3"),
            (groups, 9 * triangles)
        );
    }
}

//! Clusters of lights, which are the leaves of the light BVH: lights that are close to each other are treated as one light,
//! so that a search of the tree visits few nodes.
//!
//! Lights *fill their box* if the sum of their areas is a large fraction of the squared diagonal of the box around them. The
//! triangles of an emitter that are connected by common corners form one unit if they fill their box, however finely the
//! emitter is modelled. Otherwise each of the triangles is a separate unit. A binary tree is built over the units, which
//! joins the nearest boxes first. A search starts at the root of this tree. It makes a cluster of each node whose lights
//! fill their box, and otherwise continues with the node's children; a single unit always becomes a cluster. So an emitter
//! is one cluster, even if it consists of several parts, unless it is large compared with the scene. The windows of a house,
//! with wall between them, stay separate. No length is compared with a constant, so a scene has equal clusters at any scale.

use super::NearLight;
use crate::device_scene::compute_bvh::binary_tree;
use crate::shader_interface::NONE;
use glam::Vec3;
use std::collections::{BTreeMap, HashMap};

/// The minimum of the summed areas of a cluster's lights, as a fraction of the squared diagonal of the box around these
/// lights. Lights with a smaller sum, such as windows with wall between them, become several clusters. The fraction is 0.5
/// for a square, 0.25 for a rectangle whose sides have the ratio 3.7, and 1.05 for a sphere. A higher minimum makes more and
/// smaller clusters.
const FILLED: f64 = 0.25;
/// The maximum diagonal of the box around a cluster with several lights, as a fraction of the diagonal of the box around all
/// lights. It divides emitters that fill the scene, such as a floor that glows, into many clusters.
const LARGEST: f32 = 1.0 / 16.0;

/// A set of lights that always stay in the same cluster: a group of connected triangles, a single light, or lights with
/// equal boxes. `lights` has their indices in the list that [`clusters`] gets. `low` and `high` are the corners of the box
/// around all these lights, in the device's world space. `area` is the sum of their areas, in the square of the device's
/// unit of length.
struct Unit {
    lights: Vec<u32>,
    low: Vec3,
    high: Vec3,
    area: f64,
}

impl Unit {
    fn of(lights: &[NearLight], members: Vec<u32>) -> Self {
        let all = members.iter().map(|index| &lights[*index as usize]);
        let (mut low, mut high, mut area) = (Vec3::INFINITY, Vec3::NEG_INFINITY, 0.0);
        for light in all {
            (low, high, area) = (low.min(light.low), high.max(light.high), area + light.area);
        }
        Self {
            lights: members,
            low,
            high,
            area,
        }
    }
}

/// Partitions lights into clusters. Each cluster is a list of indices into `lights`, and each light is in exactly one
/// cluster. Triangles with equal `group` are connected by common corners, and stay in one cluster if they fill the box
/// around them and are small compared with the scene. The result is empty if there are no lights.
pub fn clusters(lights: &[NearLight]) -> Vec<Vec<u32>> {
    let mut clusters = Vec::new();
    if lights.is_empty() {
        return clusters;
    }
    let everything = Unit::of(lights, (0..lights.len() as u32).collect());
    let largest = LARGEST * (everything.high - everything.low).length();
    let is_cluster = |low: Vec3, high: Vec3, area: f64| {
        let size = (high - low).length();
        // Points that coincide are one light too.
        size == 0.0 || (size <= largest && area >= FILLED * f64::from(size).powi(2))
    };

    let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (index, light) in (0..).zip(lights) {
        groups.entry(light.group).or_default().push(index);
    }
    let mut units = Vec::new();
    for members in groups.into_values() {
        let unit = Unit::of(lights, members);
        if is_cluster(unit.low, unit.high, unit.area) {
            units.push(unit);
        } else {
            let each = unit.lights.into_iter();
            units.extend(each.map(|light| Unit::of(lights, vec![light])));
        }
    }
    let units = joined_where_they_coincide(units);

    let boxes: Vec<(Vec3, Vec3)> = units.iter().map(|unit| (unit.low, unit.high)).collect();
    let tree = binary_tree(&boxes);
    // The sum of the areas of the lights in each node.
    let mut areas = vec![0.0; tree.len()];
    for (index, node) in tree.iter().enumerate().rev() {
        areas[index] = match node.primitive {
            NONE => areas[index + 1] + areas[tree[index + 1].next as usize],
            unit => units[unit as usize].area,
        };
    }
    let mut index = 0;
    while let Some(node) = tree.get(index) {
        if node.primitive == NONE && !is_cluster(node.low, node.high, areas[index]) {
            index += 1;
            continue;
        }
        let next = node.next as usize;
        let leaves = tree[index..next].iter().map(|node| node.primitive);
        let members = leaves.filter(|unit| *unit != NONE);
        clusters.push(
            members
                .flat_map(|unit| units[unit as usize].lights.iter().copied())
                .collect(),
        );
        index = next;
    }
    clusters
}

/// Joins all units with equal boxes into one unit. Otherwise each of them would be a leaf of the light BVH, and a search of
/// the tree for one point would visit all of these leaves.
fn joined_where_they_coincide(units: Vec<Unit>) -> Vec<Unit> {
    let mut joined: Vec<Unit> = Vec::new();
    let mut indices = HashMap::new();
    for unit in units {
        let bits = [unit.low, unit.high].map(|corner| corner.to_array().map(f32::to_bits));
        let index = *indices.entry(bits).or_insert(joined.len());
        match joined.get_mut(index) {
            Some(same) => {
                same.lights.extend(unit.lights);
                same.area += unit.area;
            }
            None => joined.push(unit),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square emitter with edges of length `size` and the corner `at`, divided into `side` × `side` cells of two
    /// triangles. All its triangles have the group number `group`, as if they were connected.
    fn square(at: Vec3, size: f32, side: usize, group: u32) -> Vec<NearLight> {
        let step = size / side as f32;
        let mut lights = Vec::new();
        for cell in 0..side * side {
            let corner = at + Vec3::new((cell % side) as f32, (cell / side) as f32, 0.0) * step;
            for _ in 0..2 {
                lights.push(NearLight {
                    index: 0,
                    group,
                    low: corner,
                    high: corner + Vec3::new(step, step, 0.0),
                    normal: Vec3::Z,
                    power: 1.0,
                    area: 0.5 * f64::from(step * step),
                });
            }
        }
        lights
    }

    /// Makes clusters of the lights of 100 square windows with `side` × `side` cells each; `scale` multiplies all lengths.
    /// Returns the largest number of clusters that one window is divided into, and true if some cluster has lights of two
    /// windows.
    fn windows(side: usize, scale: f32) -> (usize, bool) {
        let mut lights = Vec::new();
        for window in 0..100 {
            let at = Vec3::new((window % 10) as f32 * 2.5, (window / 10) as f32 * 3.0, 0.0);
            lights.extend(square(at * scale, 1.5 * scale, side, window));
        }
        let clusters = clusters(&lights);
        assert_eq!(clusters.iter().map(Vec::len).sum::<usize>(), lights.len());
        let each = 2 * side * side;
        let (mut pieces, mut mixed) = (vec![0; 100], false);
        for members in clusters {
            let window = members[0] as usize / each;
            mixed |= members
                .iter()
                .any(|member| *member as usize / each != window);
            pieces[window] += 1;
        }
        (pieces.into_iter().max().unwrap(), mixed)
    }

    #[test]
    fn a_window_is_one_cluster_at_any_scale() {
        for side in [1, 4, 16] {
            for scale in [1.0, 1e-6, 1e9] {
                let (pieces, mixed) = windows(side, scale);
                assert_eq!((pieces, mixed), (1, false), "{side}, {scale}");
            }
        }
    }

    #[test]
    fn what_fills_the_scene_is_many_clusters() {
        let clusters = clusters(&square(Vec3::ZERO, 100.0, 256, 0));
        assert!(clusters.len() > 200, "{}", clusters.len());
        assert!(clusters.iter().map(Vec::len).max().unwrap() < 1000);
    }

    #[test]
    fn emitters_that_coincide_are_one_light() {
        let emitters = (0..500_000).flat_map(|group| square(Vec3::ZERO, 1.0, 1, group));
        assert_eq!(clusters(&emitters.collect::<Vec<_>>()).len(), 1);
    }

    #[test]
    fn points_that_coincide_are_one_light() {
        let mut lights = square(Vec3::ZERO, 1.0, 1, 0);
        for light in &mut lights {
            (light.high, light.area) = (light.low, 0.0);
        }
        let far = NearLight {
            low: Vec3::ONE,
            high: Vec3::ONE,
            ..lights[0]
        };
        lights = [vec![lights[0]; 1000], vec![far]].concat();
        let mut counts: Vec<usize> = clusters(&lights).iter().map(Vec::len).collect();
        counts.sort_unstable();
        assert_eq!(counts, [1, 1000]);
        assert_eq!(clusters(&[]).len(), 0);
    }
}

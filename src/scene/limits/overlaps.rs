//! Detection of emissive triangles that overlap in one plane. A ray finds only one of them, while light samples count both,
//! so pictures that show their light are wrong.

use super::super::lights::LightTriangle;
use super::super::notices::label;
use super::super::{Bounds, Scene};
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};

/// The length of the sides of the cells into which the unit normals of emissive triangles are sorted; it has
/// no unit. Two planes count as parallel if their normals are in the same cell. The difference of the two
/// normals is then below this length in each component.
const PARALLEL: f64 = 1e-5;

/// The length of the cells into which the distances of parallel planes from the origin are sorted, as a fraction of the
/// largest absolute coordinate of all emissive triangles. Parallel planes whose distances are in the same cell count as the
/// same plane. Rounding to f32 moves planes by about a tenth of a cell.
const SAME_PLANE: f64 = 1e-6;

/// The offsets of four grids, as fractions of a cell. Each grid sorts the planes of the emissive triangles into cells, by
/// normal and by distance from the origin ([`PARALLEL`], [`SAME_PLANE`]), and triangles in the same cell are compared with
/// each other. Rounding can put two equal planes into different cells of one grid, but they nearly always share a cell of
/// another grid.
const SHIFTS: [f64; 4] = [0.1, 0.35, 0.6, 0.85];

/// The number of overlapping pairs of triangles at which the search ends; the message then says that there may be more.
/// Without a maximum, n copies of a triangle would give about n² / 2 pairs.
const MOST: usize = 1000;

/// The limit above which the area that two triangles share counts as an overlap, as a fraction of the smaller
/// triangle's area. Neighbours with a common edge can share a smaller area, because their corners are
/// rounded.
const LEAST_OVERLAP: f64 = 1e-3;

/// The message for the user that counts the overlapping pairs among the emissive triangles `lights`, and names one pair, so
/// that the user can move one of the two instances. `None` if no triangles overlap.
pub(super) fn text(scene: &Scene, lights: &[LightTriangle]) -> Option<String> {
    let overlaps = overlapping(lights);
    let (first, second) = *overlaps.first()?;
    let name = |light: usize| {
        let instance = lights[light].instance as usize;
        label("instance", instance, &scene.instances[instance].name)
    };
    let more = if overlaps.len() == MOST {
        "or more "
    } else {
        ""
    };
    Some(format!(
        "overlap: {} {more}pairs of emissive triangles overlap in one plane, for example of {} and {}; a ray finds either, so their light is wrong; move one of them",
        overlaps.len(),
        name(first),
        name(second)
    ))
}

/// The pairs of triangles that overlap, as indices into `lights` with the smaller index first; [`MOST`] pairs at most.
fn overlapping(lights: &[LightTriangle]) -> BTreeSet<(usize, usize)> {
    let corners = lights.iter().flat_map(|light| light.corners);
    let size = corners
        .map(|corner| corner.abs().max_element())
        .fold(0.0, f64::max);
    // Boxes are enlarged by the distance at which two planes still count as the same.
    let boxes = lights.iter().map(|light| {
        let [a, b, c] = light.corners;
        Bounds {
            min: a.min(b).min(c) - SAME_PLANE * size,
            max: a.max(b).max(c) + SAME_PLANE * size,
        }
    });
    let boxes: Vec<Bounds> = boxes.collect();
    let plane = |light: &LightTriangle, shift: f64| {
        let normal = towards_one_side(light.normal) / PARALLEL;
        let offset = normal.dot(light.corners[0]) * (PARALLEL / SAME_PLANE / size);
        [normal.x, normal.y, normal.z, offset].map(|value| (value + shift).floor() as i64)
    };
    let mut found = BTreeSet::new();
    for (earlier, shift) in SHIFTS.into_iter().enumerate() {
        let mut planes: BTreeMap<[i64; 4], Vec<usize>> = BTreeMap::new();
        for (index, light) in lights.iter().enumerate().filter(|(_, l)| l.area > 0.0) {
            planes.entry(plane(light, shift)).or_default().push(index);
        }
        // Each pair is compared only in the first grid in which its planes share a cell.
        let met = |one: &LightTriangle, other: &LightTriangle| {
            (SHIFTS[..earlier].iter()).any(|shift| plane(one, *shift) == plane(other, *shift))
        };
        for (mut members, axis) in planes
            .into_values()
            .flat_map(|members| strips(members, &boxes))
        {
            let low = |member: &Member| boxes[member.light].min[axis];
            members.sort_by(|a, b| low(a).total_cmp(&low(b)));
            for (index, member) in members.iter().enumerate() {
                let own = boxes[member.light];
                for other in &members[index + 1..] {
                    if low(other) >= own.max[axis] {
                        break;
                    }
                    let box_of_other = &boxes[other.light];
                    let may_touch = (member.begins || other.begins)
                        && own.min.cmple(box_of_other.max).all()
                        && box_of_other.min.cmple(own.max).all();
                    let (one, two) = (&lights[member.light], &lights[other.light]);
                    if may_touch && !met(one, two) && overlap(one, two) {
                        let pair = [member.light, other.light];
                        found.insert((pair[0].min(pair[1]), pair[0].max(pair[1])));
                    }
                    if found.len() == MOST {
                        return found;
                    }
                }
            }
        }
    }
    found
}

/// An emissive triangle in one of the strips into which [`strips`] divides the triangles of a plane. A triangle that reaches
/// into several strips has one `Member` in each of them.
struct Member {
    light: usize,
    /// True if this strip is the first of the strips that contain the triangle. Two triangles are compared only in a strip
    /// in which `begins` is true for at least one of them. This is the first strip that they share, so no pair is compared
    /// twice.
    begins: bool,
}

/// Divides the emissive triangles of one plane into parallel strips. Only triangles of one strip are compared with each
/// other, which saves time for an emitter of many triangles. `members` are indices into `boxes`, the bounding boxes of all
/// emissive triangles. Returns each strip with the axis (0 is x) along its length, which is the axis along which the
/// triangles extend farthest.
fn strips(members: Vec<usize>, boxes: &[Bounds]) -> impl Iterator<Item = (Vec<Member>, usize)> {
    let around = Bounds::around(members.iter().map(|light| boxes[*light]));
    let size = around.map_or(DVec3::ONE, |bounds| bounds.size());
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| size[*b].total_cmp(&size[*a]));
    let [along, across, _] = axes;
    let low = around.map_or(0.0, |bounds| bounds.min[across]);
    let number = members.len() as f64;
    let mean = members
        .iter()
        .map(|light| boxes[*light].size()[across])
        .sum::<f64>()
        / number;
    // So a light is in fewer than three strips in the mean, and there are few in each.
    let count = (size[across] / mean).min(number.sqrt()).max(1.0).floor();
    let strip_at = |at: f64| ((at - low) / size[across] * count).clamp(0.0, count - 1.0) as usize;
    let mut divided: Vec<Vec<Member>> = (0..count as usize).map(|_| Vec::new()).collect();
    for light in members {
        let first = strip_at(boxes[light].min[across]);
        let last = strip_at(boxes[light].max[across]);
        for (index, strip) in divided[first..=last].iter_mut().enumerate() {
            let begins = index == 0;
            strip.push(Member { light, begins });
        }
    }
    divided.into_iter().map(move |strip| (strip, along))
}

/// The given unit normal or its opposite, chosen so that both normals of a plane give the same result. Triangles of one
/// plane are thus compared even if they face opposite sides.
fn towards_one_side(normal: DVec3) -> DVec3 {
    let first = normal.to_array().into_iter().find(|x| x.abs() > 0.1);
    normal * first.unwrap_or(1.0).signum()
}

/// True if two triangles overlap: the area that they share exceeds the fraction [`LEAST_OVERLAP`] of the smaller triangle's
/// area. The caller ensures that both triangles lie in the same plane; this is not tested.
fn overlap(one: &LightTriangle, other: &LightTriangle) -> bool {
    let origin = one.corners[0];
    let u = (one.corners[1] - origin).normalize_or_zero();
    let v = one.normal.cross(u);
    let flat = |light: &LightTriangle| {
        light
            .corners
            .map(|corner| DVec2::new((corner - origin).dot(u), (corner - origin).dot(v)))
    };
    let clip = counter_clockwise(flat(other));
    let mut left = counter_clockwise(flat(one)).to_vec();
    // Sutherland and Hodgman, 1974: what lies to the left of each edge is kept.
    for edge in 0..3 {
        let (from, to) = (clip[edge], clip[(edge + 1) % 3]);
        let side = |p: DVec2| (to - from).perp_dot(p - from);
        let mut kept = Vec::with_capacity(left.len() + 1);
        for (index, &p) in left.iter().enumerate() {
            let next = left[(index + 1) % left.len()];
            let (here, there) = (side(p), side(next));
            if here >= 0.0 {
                kept.push(p);
            }
            if (here >= 0.0) != (there >= 0.0) {
                kept.push(p + (next - p) * (here / (here - there)));
            }
        }
        left = kept;
    }
    let next = left.iter().cycle().skip(1);
    let twice: f64 = left.iter().zip(next).map(|(p, q)| p.perp_dot(*q)).sum();
    0.5 * twice > LEAST_OVERLAP * one.area.min(other.area)
}

fn counter_clockwise([a, b, c]: [DVec2; 3]) -> [DVec2; 3] {
    if (b - a).perp_dot(c - a) < 0.0 {
        [a, c, b]
    } else {
        [a, b, c]
    }
}

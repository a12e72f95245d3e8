//! Finds lights that are so close to a surface that the rounding of positions to f32 changes the light on the surface.
//! Reports tell the user about them.

use super::super::lights::{EmitterName, LightTriangle};
use super::super::notices::label;
use super::super::{Bounds, Mesh, PunctualShape, Scene};
use glam::DVec3;
use std::collections::BTreeMap;
use std::fmt;

/// The distance from a light to a surface, divided by the distance from the light to the camera, below which the scene is
/// reported as near a limit. The light on that surface may then be wrong by more than 0.5 %.
const COARSE_LIGHT: f64 = 2.5e-5;

/// The distance from a light to a surface, divided by the distance from the light to the camera, below which the scene is
/// reported as past a limit. The light on that surface may then be wrong by more than 5 %.
const SMALLEST_HEIGHT: f64 = 2e-6;

/// The largest ratio of an emitter's size (the diagonal of its bounding box) to its distance from a surface at which the
/// emitter can be reported as too close. Larger emitters are not reported, because only a small part of such an emitter is
/// so close to any one point of the surface.
const SMALL: f64 = 20.0;

/// A light that is too close to a surface: positions in f32 are then too coarse to light the surface exactly. Of all such
/// lights, only the closest one is reported.
#[derive(Clone, Debug)]
pub(super) struct CloseLight {
    /// The distance from the light to the surface, divided by the distance from the light to the camera. The smaller this
    /// ratio, the more the rounding of positions to f32 changes the light on the surface.
    pub height: f64,
    name: String,
}

impl CloseLight {
    /// True if the light on the surface may be wrong by more than 5 %, so that a limit counts as passed. If false, the light
    /// may be wrong by more than 0.5 %, and the scene only counts as near the limit.
    pub fn is_wrong(&self) -> bool {
        self.height < SMALLEST_HEIGHT
    }
}

impl fmt::Display for CloseLight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { height, name } = self;
        let (limit, error) = match self.is_wrong() {
            true => (SMALLEST_HEIGHT, "5 %"),
            false => (COARSE_LIGHT, "0.5 %"),
        };
        write!(
            f,
            "{name} is close to a surface: its height is {height:.1e} times its distance from the camera; below {limit:e} its light there can be wrong by more than {error}"
        )
    }
}

/// A light that may be too close to a surface: a point, a spot, or an emitter (all triangles of one instance with one
/// emissive material). An emitter that is too large for a report is not a candidate (see [`SMALL`]).
struct Candidate {
    at: DVec3,
    /// The distance, in scene units, below which a surface is too close to the light: [`COARSE_LIGHT`] ×
    /// `away`. Rounding then makes the light on the surface wrong.
    reach: f64,
    /// The distance from the light to the camera, in scene units. The light's [`CloseLight::height`] above a surface is the
    /// distance from the light to the surface, divided by `away`.
    away: f64,
    /// The diagonal of the emitter's bounding box in scene units; 0 for a punctual light. The light is reported as too close
    /// to a surface only if this size is at most [`SMALL`] times the distance from the light to the surface.
    size: f64,
    /// The unit direction, in world space, in which a spot shines, or the normal of a flat emitter with one emitting side.
    /// Surfaces behind such a light are never reported as too close, since it does not light them. `None` if the light has
    /// no single direction; it can then be too close to surfaces on all sides.
    front: Option<DVec3>,
    /// The instance and material of an emitter. Triangles with this instance and material are not counted as surfaces close
    /// to the emitter, since they are the emitter itself. `None` for a punctual light, which has no triangles.
    own: Option<EmitterName>,
    name: String,
}

/// Finds the light that is closest to a surface that it lights, for a report to the user. The closest light
/// is the one with the smallest [`CloseLight::height`]. `eye` is the position of the camera in world space;
/// `lights` are the scene's emissive triangles. Emitters that are too large for a report (see [`SMALL`]) are
/// left out. `None` if all heights are at least [`COARSE_LIGHT`].
pub(super) fn closest(scene: &Scene, lights: &[LightTriangle], eye: DVec3) -> Option<CloseLight> {
    let lists = lists(candidates(scene, lights, eye));
    if lists.is_empty() {
        return None;
    }
    let boxes: Vec<Option<Bounds>> = scene.meshes.iter().map(Mesh::bounds).collect();
    let mut closest: Option<CloseLight> = None;
    for (index, instance) in (0..).zip(&scene.instances) {
        let mesh = &scene.meshes[instance.mesh as usize];
        let to_world = |corner: &u32| {
            let position = mesh.positions[*corner as usize].as_dvec3();
            instance.object_to_world.transform_point3(position)
        };
        let bounds = boxes[instance.mesh as usize];
        let bounds = bounds.map(|b| b.placed(&instance.object_to_world));
        if bounds.is_none_or(|bounds| lists.iter().all(|list| list.near(&bounds).next().is_none()))
        {
            continue;
        }
        for part in &mesh.parts {
            for triangle in part.range() {
                let corners = mesh.triangles[triangle as usize].each_ref().map(to_world);
                let Some(bounds) = Bounds::of(corners.into_iter()) else {
                    continue;
                };
                for light in lists.iter().flat_map(|list| list.near(&bounds)) {
                    if light.own == Some((Some(index), part.material)) {
                        continue;
                    }
                    let off = closest_point(light.at, corners) - light.at;
                    let distance = off.length();
                    let height = distance / light.away;
                    let is_lit = light.front.is_none_or(|front| front.dot(off) > 0.0);
                    let is_small = light.size <= SMALL * distance;
                    let is_closest = closest.as_ref().is_none_or(|known| height < known.height);
                    if is_lit && is_small && height < COARSE_LIGHT && is_closest {
                        closest = Some(CloseLight {
                            height,
                            name: light.name.clone(),
                        });
                    }
                }
            }
        }
    }
    closest
}

/// Lights that may be too close to a surface, sorted by their position along `axis`, so that a binary search finds those
/// near a triangle. The search uses `reach`, the largest reach of the list (see [`Candidate::reach`]). Within a list,
/// reaches therefore differ by less than a factor of two: one long reach among many short ones would make the search return
/// too many lights.
struct List {
    axis: usize,
    reach: f64,
    candidates: Vec<Candidate>,
}

impl List {
    /// The lights of this [`List`] that may be too close to a surface in the box `bounds`. Along every axis, the distance
    /// between such a light and the box is at most the light's reach. [`closest`] then compares only these lights with the
    /// surface.
    fn near(&self, bounds: &Bounds) -> impl Iterator<Item = &Candidate> {
        let (low, high) = (bounds.min[self.axis], bounds.max[self.axis]);
        let first = (self.candidates).partition_point(|c| c.at[self.axis] < low - self.reach);
        let within = self.candidates[first..].iter();
        let within = within.take_while(move |c| c.at[self.axis] <= high + self.reach);
        let bounds = *bounds;
        within.filter(move |candidate| {
            let off = candidate.at - candidate.at.clamp(bounds.min, bounds.max);
            off.abs().max_element() <= candidate.reach
        })
    }
}

fn lists(candidates: Vec<Candidate>) -> Vec<List> {
    let mut by_reach: BTreeMap<i32, Vec<Candidate>> = BTreeMap::new();
    for candidate in candidates {
        let power_of_two = candidate.reach.log2().floor() as i32;
        by_reach.entry(power_of_two).or_default().push(candidate);
    }
    let lists = by_reach.into_values().map(|mut candidates| {
        let around = Bounds::of(candidates.iter().map(|c| c.at));
        // The axis along which the lights lie farthest apart.
        let axis = around.map_or(0, |bounds| bounds.size().max_position());
        candidates.sort_by(|a, b| a.at[axis].total_cmp(&b.at[axis]));
        let reach = candidates.iter().map(|c| c.reach).fold(0.0, f64::max);
        List {
            axis,
            reach,
            candidates,
        }
    });
    lists.collect()
}

/// The lights that may be too close to a surface: points and spots with an intensity above 0, and emitters whose size is at
/// most [`SMALL`] × [`COARSE_LIGHT`] × their distance from `eye`, the position of the camera in world space. `lights` are
/// the scene's emissive triangles.
fn candidates(scene: &Scene, lights: &[LightTriangle], eye: DVec3) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for (index, light) in scene.punctual_lights.iter().enumerate() {
        let at = light.position();
        let away = at.distance(eye);
        let is_lit = light.intensity.max_element() > 0.0;
        if light.is_distant() || !is_lit || away == 0.0 {
            continue;
        }
        candidates.push(Candidate {
            at,
            reach: COARSE_LIGHT * away,
            away,
            size: 0.0,
            front: matches!(light.shape, PunctualShape::Spot { .. }).then(|| light.direction()),
            own: None,
            name: label("light", index, &light.name),
        });
    }
    // For each emitter, its bounds, and its normal if all its triangles have the same normal.
    let mut emitters: BTreeMap<EmitterName, (Bounds, Option<DVec3>)> = BTreeMap::new();
    for light in lights {
        let Some(own) = Bounds::of(light.corners.into_iter()) else {
            continue;
        };
        let sides = scene.materials[light.material as usize].double_sided;
        let front = (!sides).then_some(light.normal);
        let emitter = emitters.entry(light.emitter()).or_insert((own, front));
        *emitter = (
            Bounds {
                min: emitter.0.min.min(own.min),
                max: emitter.0.max.max(own.max),
            },
            emitter.1.filter(|normal| normal.dot(light.normal) > 0.999),
        );
    }
    for (own, (bounds, front)) in emitters {
        let (at, size) = (bounds.center(), bounds.size().length());
        let away = at.distance(eye);
        let reach = COARSE_LIGHT * away;
        if size > SMALL * reach || away == 0.0 {
            continue;
        }
        candidates.push(Candidate {
            at,
            reach,
            away,
            size,
            front,
            own: Some(own),
            name: scene.emitter_label(&own),
        });
    }
    candidates
}

/// The point of the triangle with the corners `a`, `b`, `c` that is closest to the point `p` (Ericson,
/// Real-Time Collision Detection, 2005, section 5.1.5). The distance from a light to a surface is measured to
/// it.
fn closest_point(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = (b - a).cross(c - a);
    let inside = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) >= 0.0;
    if normal != DVec3::ZERO && inside(a, b) && inside(b, c) && inside(c, a) {
        return p - normal * ((p - a).dot(normal) / normal.length_squared());
    }
    let on_edge = |from: DVec3, to: DVec3| {
        let edge = to - from;
        let along = (p - from).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE);
        from + edge * along.clamp(0.0, 1.0)
    };
    let points = [on_edge(a, b), on_edge(b, c), on_edge(c, a)].into_iter();
    let nearer = |x: &DVec3, y: &DVec3| x.distance_squared(p).total_cmp(&y.distance_squared(p));
    points.min_by(nearer).unwrap_or(a)
}

//! The list of emitters, and the light that reaches a surface point directly from one of them.

use super::geometry::{Frame, Triangle};
use super::material::Surface;
use super::random::Draws;
use super::{LUMINANCE, Tracer};
use glam::DVec3;

pub struct Light {
    triangle: usize,
    /// Sum of the selection probabilities of all lights up to this one, which is included; the last light has 1.
    cumulative: f64,
}

/// The emissive triangles, with selection probabilities in proportion to area × luminance. It also writes the resulting
/// density of light samples per area, `light_pdf_area`, to each surface.
pub fn list(triangles: &[Triangle], surfaces: &mut [Surface]) -> Vec<Light> {
    let mut lights = Vec::new();
    let mut total = 0.0;
    for (index, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.corners;
        let area = 0.5 * (b - a).cross(c - a).length();
        let weight = area * surfaces[triangle.material].emission.dot(LUMINANCE);
        if weight > 0.0 {
            total += weight;
            lights.push(Light {
                triangle: index,
                cumulative: total,
            });
        }
    }
    for light in &mut lights {
        light.cumulative /= total;
    }
    if total > 0.0 {
        for surface in surfaces {
            surface.light_pdf_area = surface.emission.dot(LUMINANCE) / total;
        }
    }
    lights
}

impl Tracer {
    /// The radiance that a point reflects towards `outgoing` from one sampled point on the emitters, with its MIS weight
    /// (balance heuristic) against BSDF sampling. `index` is the triangle of the reflecting point; 0 if the emitter is
    /// hidden.
    pub(super) fn sampled_light(
        &self,
        index: usize,
        position: DVec3,
        frame: &Frame,
        outgoing: DVec3,
        random: &mut Draws,
    ) -> DVec3 {
        let pick = random.unit();
        let picked = self.lights.partition_point(|l| l.cumulative <= pick);
        let light = &self.triangles[self.lights[picked.min(self.lights.len() - 1)].triangle];
        // Fold the square onto the triangle.
        let (mut u, mut v) = (random.unit(), random.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let [a, b, c] = light.corners;
        let toward = a + (b - a) * u + (c - a) * v - position;
        let distance = toward.length();
        if distance <= self.t_min {
            return DVec3::ZERO;
        }
        let direction = toward / distance;
        let facing = -light.normal.dot(direction);
        let emitter = &self.surfaces[light.material];
        if !emitter.emits(facing) || direction.dot(frame.geometric) <= 0.0 {
            return DVec3::ZERO;
        }
        let incoming = frame.to_local(direction);
        let surface = &self.surfaces[self.triangles[index].material];
        let f = surface.evaluate(outgoing, incoming);
        if f == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let end = distance - self.t_min;
        let blocked = self.crossing(position, direction, self.t_min, end, index, true);
        if blocked.is_some() {
            return DVec3::ZERO;
        }
        let pdf_light = emitter.light_pdf_area * distance * distance / facing.abs();
        let pdf_surface = surface.pdf_solid_angle(outgoing, incoming);
        f * emitter.emission * (incoming.z / (pdf_light + pdf_surface))
    }
}

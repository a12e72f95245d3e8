//! One path from the camera through the scene, with next-event estimation and multiple importance sampling.

use super::geometry::Frame;
use super::random::Draws;
use super::{Options, Tracer};
use glam::DVec3;

impl Tracer {
    /// The radiance (RGB) that one random path finds along a ray from the camera.
    pub(super) fn path(
        &self,
        mut origin: DVec3,
        mut direction: DVec3,
        options: &Options,
        random: &mut Draws,
    ) -> DVec3 {
        let mut radiance = DVec3::ZERO;
        let mut throughput = DVec3::ONE;
        // How the ray was sampled; none where lights could not have been sampled instead.
        let mut pdf_solid_angle = None;
        let mut skip = usize::MAX;
        let mut t_min = 0.0;
        for scatterings in 0..=options.bounces {
            let found = self.crossing(origin, direction, t_min, f64::INFINITY, skip, false);
            let Some((index, t, u, v)) = found else {
                break;
            };
            let triangle = &self.triangles[index];
            let surface = &self.surfaces[triangle.material];
            let facing = -triangle.normal.dot(direction);
            if surface.emits(facing) {
                let weight = pdf_solid_angle.map_or(1.0, |pdf: f64| {
                    pdf / (pdf + surface.light_pdf_area * t * t / facing.abs())
                });
                radiance += throughput * surface.emission * weight;
            }
            if scatterings == options.bounces {
                break;
            }
            let [a, b, c] = triangle.corners;
            let position = a * (1.0 - u - v) + b * u + c * v;
            let geometric = triangle.normal * if facing < 0.0 { -1.0 } else { 1.0 };
            let mut shading = triangle.shading_normal(geometric, u, v);
            // A normal that looks away from the eye is bent until its cosine is a hundredth.
            let facing = -shading.dot(direction);
            if facing < 0.01 {
                shading = (shading - (0.01 - facing) * direction).normalize();
            }
            if surface.has_specular_lobe() {
                shading = reflecting_outwards(shading, geometric, direction);
            }
            let frame = Frame::new(shading, geometric);
            let outgoing = frame.to_local(-direction);
            if outgoing.z <= 0.0 {
                break;
            }

            if options.nee && !self.lights.is_empty() {
                let arrives = self.sampled_light(index, position, &frame, outgoing, random);
                radiance += throughput * arrives;
            }

            let Some(sample) = surface.sample(outgoing, random) else {
                break;
            };
            direction = frame.to_world(sample.direction);
            if direction.dot(geometric) <= 0.0 {
                break;
            }
            throughput *= sample.weight;
            pdf_solid_angle = sample.pdf_solid_angle.filter(|_| options.nee);
            origin = position;
            skip = index;
            t_min = self.t_min;
        }
        radiance
    }
}

/// The shading normal, turned towards the geometric normal until the reflection of `direction` leaves the surface at an
/// angle whose sine is at least 0.01, or at least the sine of the viewer's angle if that is smaller. By bisection, since the
/// angle grows as the normal turns.
pub fn reflecting_outwards(shading: DVec3, geometric: DVec3, direction: DVec3) -> DVec3 {
    let height = |normal: DVec3| (direction - 2.0 * direction.dot(normal) * normal).dot(geometric);
    let least = (-geometric.dot(direction)).min(0.01);
    if height(shading) >= least {
        return shading;
    }
    let turned = |part: f64| (shading * (1.0 - part) + geometric * part).normalize();
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if height(turned(middle)) < least {
            low = middle;
        } else {
            high = middle;
        }
    }
    turned(high)
}

//! Test that direct and indirect light, rendered separately, add up to all light.

use super::{picture, preset};
use headwater::procedural;
use headwater::render::View;
use headwater::render::settings::{DirectMode, IndirectMode, Integrator};
use headwater::shader_interface::Tracer;

/// The maximum relative difference. It is small, because both sides have the same random numbers and differ by rounding
/// only.
const TOLERANCE: f64 = 1e-4;

#[test]
fn direct_and_indirect_light_alone_add_up_to_all() {
    let settings = [("finish", "metal"), ("roughness", "0")]
        .map(|(key, value)| (key.to_owned(), value.to_owned()));
    let cornell = procedural::generate("cornell", &settings).unwrap();
    let view = |bounces| View {
        camera: cornell.cameras[0].clone(),
        width: 24,
        height: 24,
        seed: 1,
        bounces,
        jitter: false,
    };
    for name in ["path-tracing", "accurate"] {
        let all = preset(name);
        let mut indirect = all.clone();
        indirect.direct.mode = DirectMode::Off;
        let mut direct = all.clone();
        let mut bounces = 4;
        match all.integrator {
            Integrator::PathTracing => bounces = 1,
            Integrator::Restir => direct.indirect.mode = IndirectMode::Off,
        }
        let pictures = [(&all, 4), (&indirect, 4), (&direct, bounces), (&all, 0)].map(
            |(settings, bounces)| {
                picture(&cornell, &view(bounces), settings, Tracer::ComputeBvh, 3).unwrap()
            },
        );
        let [all, indirect, direct, emitted] = pictures;
        let mut light = [0.0; 2];
        for pixel in 0..all.len() {
            for channel in 0..3 {
                let [all, indirect, direct, emitted] =
                    [&all, &indirect, &direct, &emitted].map(|picture| picture[pixel][channel]);
                let off = all - (indirect + direct - emitted);
                assert!(
                    off.abs() <= TOLERANCE * all.max(1.0),
                    "{name}: pixel {pixel} is off by {off}"
                );
                light[0] += direct - emitted;
                light[1] += indirect - emitted;
            }
        }
        assert!(light.iter().all(|sum| *sum > 1.0), "{name}: {light:?}");
    }
}

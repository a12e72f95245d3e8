//! Tests of unlit surfaces: the camera sees their colours, and all other rays see black.

use crate::{ALBEDO, TECHNIQUES, floor, from_above, image, picture, preset, punctual, support};
use glam::{DVec3, Vec2, Vec3, Vec4};
use headwater::scene::{Material, PunctualShape, Scene, Texture};

/// A card above the floor, with a texture and vertex colours. The light is so bright that the device's unit of radiance is
/// not 1.
fn scene(material: &Material) -> Scene {
    let mut scene = floor();
    let card = support::quad(Vec3::new(-0.3, 1.0, 0.3), Vec3::X * 0.6, Vec3::NEG_Z * 0.6);
    let card = support::add(&mut scene, material, &card);
    card.uvs[0] = vec![Vec2::splat(0.5); 6];
    card.colors = vec![Vec4::new(1.0, 0.5, 0.25, 1.0); 6];
    scene.images = vec![image(|_| [255, 255, 188, 255])];
    let mut light = punctual(
        PunctualShape::Directional,
        DVec3::ZERO,
        DVec3::new(0.3, -1.0, 0.2),
    );
    light.intensity *= 1000.0;
    scene.punctual_lights = vec![light];
    scene.validate().unwrap();
    scene
}

mod thorough {
    use super::*;

    /// The card must show its colour to the camera; the rest of the picture must be the same as with a black card.
    #[test]
    fn the_camera_sees_what_is_unlit_and_light_does_not() {
        let unlit = scene(&Material {
            base_color_texture: Some(Texture::plain(0)),
            ..Material::unlit("card", Vec3::new(0.5, 1.0, 1.0))
        });
        let black = scene(&Material::lambert("card", Vec3::ZERO));
        // sRGB 188 is half as bright as white.
        let blue = ((188.0 / 255.0 + 0.055) / 1.055_f64).powf(2.4) * 0.25;
        let expected = DVec3::new(0.5, 0.5, blue);
        for (technique, tracer, _) in TECHNIQUES {
            let view = from_above(3, 3);
            let seen = |scene| picture(scene, &view, &preset(technique), tracer, 2);
            let (Some(with), Some(without)) = (seen(&unlit), seen(&black)) else {
                continue;
            };
            let mut card = 0;
            for (found, black) in with.iter().zip(&without) {
                if *black == [0.0; 3] && *found != [0.0; 3] {
                    let off = (DVec3::from_array(*found) - expected).abs().max_element();
                    assert!(off < 1e-5, "{technique} {tracer:?}: {found:?} {expected}");
                    card += 1;
                } else {
                    assert_eq!(found, black, "{technique} {tracer:?}");
                }
            }
            // It covers .4 of the picture's width, and has a shadow.
            assert!((140..220).contains(&card), "{technique} {tracer:?}: {card}");
            let lit = without.iter().filter(|p| p[2] > 0.1 * ALBEDO).count();
            assert!(lit > 400, "{technique} {tracer:?}: {lit}");
        }
    }
}

//! Cameras of exported files.

use crate::scene::camera::{DEFAULT_ASPECT, Projection};
use crate::scene::{Camera, Scene};
use serde_json::{Value, json};

/// The glTF object of `camera`. glTF requires planes beyond which other programs show nothing; Headwater ignores them. They
/// enclose what an orthographic camera sees of `scene` in its state without motion. A lens is left out, because glTF has none.
pub(super) fn camera(camera: &Camera, scene: &Scene) -> Value {
    match camera.projection {
        Projection::Perspective { vertical_fov, .. } => {
            let mut perspective = json!({ "yfov": vertical_fov, "znear": 0.01 });
            if let Some(aspect) = camera.aspect_ratio {
                perspective["aspectRatio"] = json!(aspect);
            }
            json!({ "type": "perspective", "perspective": perspective })
        }
        Projection::Orthographic { height } => {
            let ymag = 0.5 * height;
            let xmag = camera.aspect_ratio.unwrap_or(DEFAULT_ASPECT) * ymag;
            let eye = camera.camera_to_world.translation;
            let far = scene.bounds().map_or(1.0, |bounds| {
                eye.distance(0.5 * (bounds.min + bounds.max)) + bounds.size().length()
            });
            let orthographic = json!({ "xmag": xmag, "ymag": ymag, "znear": 0.0, "zfar": far });
            json!({ "type": "orthographic", "orthographic": orthographic })
        }
    }
}

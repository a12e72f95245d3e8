//! The independent truth: a plain path tracer on the CPU in f64.
//!
//! It shares with the renderer only the scene's description. The surface model is written from
//! glTF 2.0, appendix B, the tree, the sampling and the random numbers are its own, and no roulette
//! is played; where both agree, neither has it wrong by accident.

mod geometry;
mod light;
mod material;
mod path;
mod picture;
mod random;
mod tree;

use geometry::Triangle;
use glam::DVec3;
use headwater::scene::Scene;
use light::Light;
pub use material::Surface;
pub use path::reflecting_outwards;
pub use picture::{Image, Options, camera_ray};
use tree::Node;

/// The weights of linear Rec. 709.
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// The closest crossing of a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// In lengths of the direction.
    pub t: f64,
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the triangles of the instance's mesh.
    pub triangle: u32,
    /// Barycentric weight of the second corner.
    pub u: f64,
    /// Barycentric weight of the third corner.
    pub v: f64,
}

/// A scene in world space, ready to be traced.
pub struct Tracer {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
    surfaces: Vec<Surface>,
    lights: Vec<Light>,
    /// Rays that leave a surface meet nothing nearer.
    t_min: f64,
}

impl Tracer {
    /// Carries `scene` to world space and builds the tree over it.
    pub fn new(scene: &Scene) -> Self {
        let mut triangles = geometry::triangles_of(scene);
        let nodes = tree::build(&mut triangles);
        let scale = nodes.first().map_or(0.0, |n| (n.high - n.low).length());
        let mut surfaces: Vec<_> = scene.materials.iter().map(Surface::new).collect();
        let lights = light::list(&triangles, &mut surfaces);
        Self {
            triangles,
            nodes,
            surfaces,
            lights,
            t_min: 1e-9 * scale,
        }
    }

    /// The closest crossing with 0 < t < `t_max`. The direction need not be of unit length.
    pub fn closest(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
        let (index, t, u, v) = self.crossing(origin, direction, 0.0, t_max, usize::MAX, false)?;
        let triangle = &self.triangles[index];
        Some(Hit {
            t,
            instance: triangle.instance,
            triangle: triangle.triangle,
            u,
            v,
        })
    }
}

//! The brute-force tracer: a plain path tracer on the CPU in f64, the independent truth for the renderer.
//!
//! It shares with the renderer only the scene's description. Its surface model is written from glTF 2.0, appendix B. Its
//! tree, its sampling and its random numbers are separate code, and it has no Russian roulette. An error that is in only one
//! of the two renderers shows as a difference between their pictures.

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

/// The weights of red, green and blue in the luminance of linear Rec. 709.
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// The closest intersection of a ray with the triangles of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter of the hit, in lengths of the ray's direction.
    pub t: f64,
    /// Index of the hit instance in the scene.
    pub instance: u32,
    /// Index of the hit triangle in the instance's mesh.
    pub triangle: u32,
    /// Barycentric weight of the second corner at the hit.
    pub u: f64,
    /// Barycentric weight of the third corner at the hit.
    pub v: f64,
}

/// A scene in world space with a tree over its triangles, ready to be traced.
pub struct Tracer {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
    surfaces: Vec<Surface>,
    lights: Vec<Light>,
    /// Minimum distance, in scene units, of hits of rays that leave a surface, so that rounding makes no hit at their
    /// origin.
    t_min: f64,
}

impl Tracer {
    /// Transforms the triangles of `scene` to world space, and builds the tree and the list of emitters.
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

    /// The closest hit with 0 < t < `t_max`; `None` if there is none. The direction may have any length except 0.
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

//! Implicit bodies as signed distance functions in metres: the value at a point is negative inside a body, and outside it is
//! the distance to its surface, in some functions approximately.

use glam::Vec3;

/// The signed distance to the union of two bodies with the distances `a` and `b`. The transition is smooth where the
/// distances differ by less than `k` metres.
pub fn join(a: f32, b: f32, k: f32) -> f32 {
    let h = (1.0 - (a - b).abs() / k).max(0.0);
    a.min(b) - h * h * k / 4.0
}

/// The signed distance to the intersection of two bodies with the distances `a` and `b`. Its edge is rounded by `k` metres.
pub fn common(a: f32, b: f32, k: f32) -> f32 {
    -join(-a, -b, k)
}

/// The signed distance to the body at distance `a` without the body at distance `b`. The edge is rounded by `k` metres.
pub fn carve(a: f32, b: f32, k: f32) -> f32 {
    common(a, -b, k)
}

/// The approximate signed distance from `p` to an axis-aligned ellipsoid, by its centre and its radii in metres.
pub fn ellipsoid(p: Vec3, middle: Vec3, radii: Vec3) -> f32 {
    let q = (p - middle) / radii;
    let (size, slope) = (q.length(), (q / radii).length());
    size * (size - 1.0) / slope.max(1e-6)
}

/// The signed distance from `p` to a sphere, by its centre and its radius in metres.
pub fn ball(p: Vec3, middle: Vec3, radius: f32) -> f32 {
    (p - middle).length() - radius
}

/// The approximate signed distance from `p` to a capsule from `a` to `b`, whose ends have the radii `ra` and `rb` in metres.
pub fn limb(p: Vec3, (a, ra): (Vec3, f32), (b, rb): (Vec3, f32)) -> f32 {
    let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    (p - a.lerp(b, along)).length() - (ra + (rb - ra) * along)
}

/// The signed distance from `p` to a box by its centre and half its size, with edges of this radius, in metres.
pub fn cushion(p: Vec3, middle: Vec3, half: Vec3, radius: f32) -> f32 {
    let q = (p - middle).abs() - (half - radius);
    q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - radius
}

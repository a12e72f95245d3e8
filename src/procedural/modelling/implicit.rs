//! Implicit bodies as signed distance functions, some of them approximate: negative inside, the
//! distance outside. Lengths are in metres.

use glam::Vec3;

/// The union of two bodies, blended smoothly where their distances differ by less than `k`.
pub fn join(a: f32, b: f32, k: f32) -> f32 {
    let h = (1.0 - (a - b).abs() / k).max(0.0);
    a.min(b) - h * h * k / 4.0
}

/// The intersection of two bodies, its edge rounded by `k`.
pub fn common(a: f32, b: f32, k: f32) -> f32 {
    -join(-a, -b, k)
}

/// The first body without the second, its edge rounded by `k`.
pub fn carve(a: f32, b: f32, k: f32) -> f32 {
    common(a, -b, k)
}

/// The approximate distance to an ellipsoid.
pub fn ellipsoid(p: Vec3, middle: Vec3, radii: Vec3) -> f32 {
    let q = (p - middle) / radii;
    let (size, slope) = (q.length(), (q / radii).length());
    size * (size - 1.0) / slope.max(1e-6)
}

/// The distance to a sphere.
pub fn ball(p: Vec3, middle: Vec3, radius: f32) -> f32 {
    (p - middle).length() - radius
}

/// The approximate distance to a capsule from a to b with the radii `ra` and `rb` at its ends.
pub fn limb(p: Vec3, (a, ra): (Vec3, f32), (b, rb): (Vec3, f32)) -> f32 {
    let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    (p - a.lerp(b, along)).length() - (ra + (rb - ra) * along)
}

/// The distance to a box with rounded edges.
pub fn cushion(p: Vec3, middle: Vec3, half: Vec3, radius: f32) -> f32 {
    let q = (p - middle).abs() - (half - radius);
    q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - radius
}

//! Implicit bodies as signed distance functions in metres, which [`surface`](super::dual_contouring::surface) converts into
//! triangles. The value at a point is negative inside the body; outside, it is the distance to the surface of the body, in
//! some functions approximately.

use glam::Vec3;

/// The signed distance to the union of two bodies, from the signed distances `a` and `b` to each. Where the two differ by
/// less than `k` metres, the union is blended smoothly.
pub fn join(a: f32, b: f32, k: f32) -> f32 {
    let h = (1.0 - (a - b).abs() / k).max(0.0);
    a.min(b) - h * h * k / 4.0
}

/// The signed distance to the intersection of two bodies, from the signed distances `a` and `b` to each. The edge where
/// their surfaces meet is rounded by `k` metres.
pub fn common(a: f32, b: f32, k: f32) -> f32 {
    -join(-a, -b, k)
}

/// The signed distance to the difference of two bodies: the body with the signed distance `a`, from which the
/// body with the signed distance `b` is cut out. The edge of the cut is rounded by `k` metres.
pub fn carve(a: f32, b: f32, k: f32) -> f32 {
    common(a, -b, k)
}

/// The approximate signed distance in metres from the point `p` to an axis-aligned ellipsoid. `middle` is its
/// centre, and `radii` has its radii along x, y and z, in metres.
pub fn ellipsoid(p: Vec3, middle: Vec3, radii: Vec3) -> f32 {
    let q = (p - middle) / radii;
    let (size, slope) = (q.length(), (q / radii).length());
    size * (size - 1.0) / slope.max(1e-6)
}

/// The signed distance in metres from the point `p` to a sphere with the centre `middle` and the radius
/// `radius`, both in metres. It is negative inside the sphere.
pub fn ball(p: Vec3, middle: Vec3, radius: f32) -> f32 {
    (p - middle).length() - radius
}

/// The approximate signed distance in metres from the point `p` to a capsule from the point `a` to the point
/// `b`. Its round ends have the radii `ra` and `rb` in metres, and its thickness changes evenly between them.
pub fn limb(p: Vec3, (a, ra): (Vec3, f32), (b, rb): (Vec3, f32)) -> f32 {
    let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    (p - a.lerp(b, along)).length() - (ra + (rb - ra) * along)
}

/// The signed distance in metres from the point `p` to an axis-aligned box with the centre `middle` and
/// rounded edges. The components of `half` are half the lengths of the box along x, y and z, and `radius` is
/// the radius of the edges, all in metres.
pub fn cushion(p: Vec3, middle: Vec3, half: Vec3, radius: f32) -> f32 {
    let q = (p - middle).abs() - (half - radius);
    q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - radius
}

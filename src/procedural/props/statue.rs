//! A classical bust on a round foot, as one shape of about 3,000 triangles with smooth normals. The scenes
//! `atrium`, `garage` and `statue-room` show it in different materials and sizes.

use crate::base::random::Random;
use crate::procedural::modelling::dual_contouring::{Detail, surface, ticks};
use crate::procedural::modelling::implicit::{ball, carve, common, ellipsoid, join, limb};
use crate::procedural::modelling::{Profile, Shape};
use glam::{Mat3, Vec3, vec3};

/// The height above the ground, in metres, of the lower end of the bust's stem: the centre of its round end,
/// which enters the foot of the bust.
const FOOT: f32 = 0.135;
/// The height of the middle of the head above the ground, in metres. The body is modelled with the middle of
/// the head at the origin, and then raised by this height.
const HEAD: f32 = 0.545;

/// The random properties of a bust, which make each bust different. The signed distance function and the pose
/// of the bust are computed from them.
struct Sitter {
    /// The rotation of the head around the vertical axis, in radians. It turns the face to a side; 0 looks
    /// ahead.
    turn: f32,
    /// The tilt of the head towards a shoulder, in radians; 0 is upright.
    tilt: f32,
    /// The number of locks of hair around the head. It is a whole number, stored as a float because it is a factor in the
    /// formula of the hair.
    locks: f32,
    /// A random factor on the length of the nose, from 0.9 to 1.15.
    nose: f32,
    /// A random factor on the width of the jaw, from 0.94 to 1.06.
    jaw: f32,
    /// The distance from one fold of the cloth on the chest to the next, in metres. A larger distance gives
    /// fewer folds.
    fold: f32,
}

impl Sitter {
    fn new(random: &mut Random) -> Self {
        let side = random.pick(&[-1.0, 1.0]);
        Self {
            turn: side * random.between(0.2, 0.5),
            tilt: -side * random.between(0.02, 0.1),
            locks: random.between(12.0, 15.0).floor(),
            nose: random.between(0.9, 1.15),
            jaw: random.between(0.94, 1.06),
            fold: random.between(0.04, 0.05),
        }
    }

    /// The signed distance in metres from the point `m` to the face without hair. The origin is the middle of the head. The
    /// caller mirrors the point to the side +x, so that the face is symmetric.
    fn face(&self, m: Vec3) -> f32 {
        let mut d = ellipsoid(m, vec3(0.0, 0.035, -0.012), vec3(0.074, 0.09, 0.094));
        let jaw = vec3(0.06 * self.jaw, 0.088, 0.07);
        d = join(d, ellipsoid(m, vec3(0.0, -0.03, 0.022), jaw), 0.04);
        d = join(d, ball(m, vec3(0.038, -0.02, 0.062), 0.018), 0.03);
        let corner = (vec3(0.042 * self.jaw, -0.06, 0.012), 0.02);
        let chin = (vec3(0.006, -0.102, 0.071), 0.02);
        d = join(d, limb(m, corner, chin), 0.03);
        let brow = (vec3(0.008, 0.025, 0.089), 0.008);
        d = join(d, limb(m, brow, (vec3(0.05, 0.022, 0.066), 0.008)), 0.02);
        let socket = (vec3(0.024, 0.003, 0.1), 0.013);
        let socket = limb(m, socket, (vec3(0.043, 0.003, 0.089), 0.011));
        d = carve(d, socket, 0.012);
        let eye = ellipsoid(m, vec3(0.0315, 0.001, 0.074), vec3(0.018, 0.0095, 0.013));
        d = join(d, eye, 0.003);
        let tip = vec3(0.0, 0.02 - 0.052 * self.nose, 0.09 + 0.022 * self.nose);
        let ridge = limb(m, (vec3(0.0, 0.022, 0.089), 0.006), (tip, 0.0085));
        d = join(d, ridge, 0.014);
        let wing = ball(m, tip + vec3(0.0095, -0.003, -0.012), 0.007);
        d = join(d, wing, 0.009);
        let upper = (vec3(0.004, -0.0645, 0.0875), 0.0055);
        let upper = limb(m, upper, (vec3(0.021, -0.068, 0.079), 0.003));
        d = join(d, upper, 0.006);
        let lower = (vec3(0.0, -0.0765, 0.0865), 0.007);
        let lower = limb(m, lower, (vec3(0.015, -0.073, 0.081), 0.0035));
        d = join(d, lower, 0.006);
        d
    }

    /// The signed distance in metres from the point `p` to the hair. The origin is the middle of the head. The hair is drawn
    /// back in locks from the brow to a knot, and held by a ribbon.
    fn hair(&self, p: Vec3) -> f32 {
        let ripple = |angle: f32| 0.005 * (angle * self.locks).cos();
        let cap = ellipsoid(p, vec3(0.0, 0.045, -0.024), vec3(0.087, 0.091, 0.1));
        let locks = cap - ripple(p.x.atan2(p.y + 0.005));
        let brow = ellipsoid(p, vec3(0.0, -0.035, 0.115), vec3(0.073, 0.105, 0.09));
        let nape = (p - vec3(0.0, -0.055, -0.06)).dot(vec3(0.0, -0.94, 0.34));
        let mut d = common(carve(locks, brow, 0.02), nape, 0.03);
        let plane = (p - vec3(0.0, 0.09, 0.03)).dot(vec3(0.0, 0.64, -0.77));
        d = join(d, cap.hypot(plane) - 0.0075, 0.004);
        let knot = p - vec3(0.0, 0.02, -0.132);
        let twist = 0.003 * (6.0 * knot.x.atan2(knot.y) + 120.0 * knot.length()).cos();
        join(d, knot.length() - 0.042 - twist, 0.02)
    }

    /// The signed distance in metres from the point `p` to the torso: neck, shoulders and chest, down to the stem that
    /// stands on the foot of the bust. The origin is the middle of the head. `m` is `p` mirrored to the side +x. All parts
    /// but the cloth are computed from `m`, so that they are symmetric.
    fn torso(&self, p: Vec3, m: Vec3) -> f32 {
        let mut d = ellipsoid(m, vec3(0.0, -0.33, -0.012), vec3(0.165, 0.16, 0.092));
        let shoulder = ellipsoid(m, vec3(0.16, -0.27, -0.025), vec3(0.062, 0.075, 0.062));
        d = join(d, shoulder, 0.06);
        let nape = (vec3(0.02, -0.13, -0.045), 0.035);
        d = join(d, limb(m, nape, (vec3(0.14, -0.225, -0.035), 0.035)), 0.05);
        d = join(d, ball(m, vec3(0.07, -0.34, 0.03), 0.06), 0.05);
        // Cloth hangs in round folds from shoulder to shoulder.
        let hang = vec3(p.x - 0.02, 0.95 * (p.y + 0.13), 0.5 * (p.z - 0.03)).length();
        let folds = (hang * std::f32::consts::TAU / self.fold).sin();
        let cloth = d - 0.009 - 0.005 * folds;
        let cloth = carve(cloth, hang - 0.118, 0.012);
        let collar = (vec3(0.016, -0.212, 0.024), 0.009);
        d = join(d, limb(m, collar, (vec3(0.13, -0.212, 0.0), 0.008)), 0.025);
        d = join(d, cloth, 0.006);
        let outline = ellipsoid(m, vec3(0.0, -0.2, -0.01), vec3(0.205, 0.205, 0.16));
        d = common(d, outline, 0.015);
        let stem = (vec3(0.0, -0.36, -0.01), 0.06);
        let stem = limb(m, stem, (vec3(0.0, FOOT - HEAD, -0.01), 0.036));
        join(d, stem, 0.04)
    }

    fn body(&self, p: Vec3) -> f32 {
        let m = vec3(p.x.abs(), p.y, p.z);
        let ear = ellipsoid(m, vec3(0.077, -0.012, -0.006), vec3(0.011, 0.03, 0.018));
        let head = join(self.face(m), ear, 0.01);
        let head = join(head, self.hair(p), 0.003);
        let throat = (vec3(0.0, -0.08, -0.018), 0.05);
        let mut neck = limb(m, throat, (vec3(0.0, -0.22, -0.03), 0.058));
        let sinew = (vec3(0.052, -0.045, -0.028), 0.012);
        neck = join(neck, limb(m, sinew, (vec3(0.012, -0.21, 0.02), 0.01)), 0.02);
        join(join(head, neck, 0.025), self.torso(p, m), 0.03)
    }

    /// Converts a point `p` of the upright bust, whose head looks ahead, to its position in the random pose of this bust.
    /// Both positions are in metres, and their origin is the middle of the upright bust's head. The head turns and tilts,
    /// the neck follows in part, and the chest stays.
    fn posed(&self, p: Vec3) -> Vec3 {
        let pivot = vec3(0.0, -0.1, -0.025);
        let t = ((p.y + 0.22) / 0.16).clamp(0.0, 1.0);
        let fraction = t * t * (3.0 - 2.0 * t);
        let turn = Mat3::from_rotation_y(self.turn * fraction);
        pivot + turn * Mat3::from_rotation_z(self.tilt * fraction) * (p - pivot)
    }
}

/// A bust on its foot, 0.68 m high, as one shape with smooth normals. `random` chooses its features and its
/// pose. It stands at the origin and faces +Z.
pub fn bust(random: &mut Random) -> Shape {
    let sitter = Sitter::new(random);
    let across = [(-0.055, 0.01), (0.055, 0.004), (0.24, 0.01)];
    let grid = [
        ticks(-0.24, &across),
        ticks(-0.46, &[(-0.13, 0.012), (0.04, 0.0035), (0.15, 0.006)]),
        ticks(-0.2, &[(0.05, 0.01), (0.14, 0.004)]),
    ];
    let detail = Detail {
        triangles: 2700,
        // The face gets more triangles than the back, since it is seen more closely.
        weight: |p: Vec3| {
            1.0 + 80.0 * (-(p - vec3(0.0, -0.045, 0.09)).length_squared() / 0.004).exp()
        },
    };
    let body = surface(&grid, &detail, |p| sitter.body(p));
    let mut bust = body.map(|p| sitter.posed(p) + Vec3::Y * HEAD);
    let foot = Profile::new(0.0, 0.0)
        .line(0.105, 0.0)
        .line(0.0, 0.022)
        .line(-0.008, 0.0)
        .arc(0.0, 0.024, 180.0, 4)
        .line(-0.008, 0.0)
        .arc(-0.035, 0.05, -110.0, 4)
        .line(0.012, 0.004)
        .line(0.0, 0.012)
        .line(-0.01, 0.004)
        .capped();
    bust.add(foot.turned(24).map(|p| p - Vec3::Z * 0.01));
    bust
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bust_is_closed_and_has_about_three_thousand_triangles() {
        for seed in 0..3 {
            let bust = bust(&mut Random::new(seed));
            assert!(bust.is_closed(), "{seed}");
            assert!(bust.signed_volume() > 0.0, "{seed}");
            let count = bust.triangle_count();
            assert!((2800..3600).contains(&count), "{seed}: {count}");
        }
    }
}

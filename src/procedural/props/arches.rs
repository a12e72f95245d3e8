//! Shapes of round arches: the flat wall around an arch, and mouldings along its edge, with their fronts
//! towards +Z. The origin is in the middle between the two sides of the opening, at its foot.

use crate::procedural::modelling::{Profile, Shape};
use glam::{Vec2, Vec3, vec3};

/// The opening of a round arch: a rectangle with a half circle on top. The wall around it and the mouldings along its edge
/// are computed from it.
#[derive(Clone, Copy)]
pub struct Arch {
    /// The radius of the round part, which is half the width of the opening, in metres.
    pub radius: f32,
    /// The height in metres, above the foot of the opening, at which the round part begins.
    pub spring: f32,
    /// The number of straight segments of the half circle. More segments give a rounder arch with more
    /// triangles.
    pub steps: u32,
}

impl Arch {
    fn rim(&self, step: u32) -> Vec2 {
        let turn = step as f32 / self.steps as f32 * std::f32::consts::PI;
        let (sin, cos) = turn.sin_cos();
        Vec2::new(self.radius * cos, self.spring + self.radius * sin)
    }

    /// The flat wall around the opening, in the plane z = 0, with its front towards +Z. It reaches `half`
    /// metres from the middle of the opening to each side, and from its foot up to `height` metres.
    pub fn wall(&self, half: f32, height: f32) -> Shape {
        let mut wall = self.spandrel(half, height);
        for (from, to) in [(-half, -self.radius), (self.radius, half)] {
            let corner = |x: f32, y: f32| vec3(x, y, 0.0);
            let [a, b] = [corner(from, 0.0), corner(to, 0.0)];
            let [c, d] = [corner(to, self.spring), corner(from, self.spring)];
            wall.add(Shape::triangle([a, b, c]));
            wall.add(Shape::triangle([a, c, d]));
        }
        wall
    }

    /// The upper part of the flat wall around the opening, for example above columns. It begins at the height
    /// [`Self::spring`], reaches up to `height` metres, and `half` metres from the middle of the opening to
    /// each side.
    pub fn spandrel(&self, half: f32, height: f32) -> Shape {
        let mut wall = Shape::default();
        let mut face = |a: Vec2, b: Vec2, c: Vec2| {
            wall.add(Shape::triangle([a, b, c].map(|p| p.extend(0.0))));
        };
        // A fan from each upper corner and one from the middle of the top, so that no vertex is on the
        // edge of another triangle, where a ray could pass through.
        let middle = self.steps / 2;
        for step in 0..self.steps {
            let side = if step < middle { half } else { -half };
            face(Vec2::new(side, height), self.rim(step + 1), self.rim(step));
        }
        let (left, right) = (Vec2::new(-half, height), Vec2::new(half, height));
        face(right, left, self.rim(middle));
        let foot = |x: f32| Vec2::new(x, self.spring);
        face(right, self.rim(0), foot(half));
        face(left, foot(-half), self.rim(self.steps));
        wall
    }

    /// A moulding along the edge of the opening: along the half circle, and down both sides for the length `down` in metres.
    /// In `profile`, the radius is the distance in metres outwards from the edge of the opening, and the height is the depth
    /// behind the face of the wall (negative in front of it). The profile begins behind the face, at the edge of the
    /// opening, and ends at or behind the face.
    pub fn moulding(&self, profile: &Profile, down: f32) -> Shape {
        let profile = profile.clone().widened(self.radius);
        let mut along = profile.swung(0.0, 0.5, self.steps);
        if down > 0.0 {
            along.add(profile.drawn(-down, 0.0));
            let left = profile.drawn(0.0, down);
            along.add(left.map(|p| vec3(-p.x, p.y, -p.z)));
        }
        let spring = Vec3::Y * self.spring;
        along.map(|p| vec3(p.x, p.z, -p.y) + spring)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wall_leaves_the_opening_free() {
        let arch = Arch {
            radius: 0.5,
            spring: 1.0,
            steps: 64,
        };
        let open = 1.0 + std::f32::consts::PI / 8.0;
        let area = arch.wall(1.0, 2.0).area();
        assert!((area - (4.0 - open)).abs() < 1e-3, "{area}");
    }
}

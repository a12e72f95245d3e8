//! A simulation of rigid bodies that fall into a heap, which arranges the objects of the scene `colourful-mess`. Each body
//! consists of a few balls. In each step, balls that overlap are moved apart; then each body gets the position and rotation
//! that fit its balls best (shape matching, Müller et al. 2005, 2016).
//!
//! Only +, −, ×, ÷ and square roots of scalars are used, because they give the same bits on every machine. Otherwise a
//! difference in the last bit would grow to a different heap.

use glam::{Mat3, Vec3};

/// The duration of one step of the simulation, in seconds. Shorter steps make the motion more accurate, but
/// the same fall then takes more steps.
const STEP: f32 = 1.0 / 180.0;
/// The number of steps between two searches for the pairs of balls that may meet. A larger number needs fewer searches, but
/// each search then finds more pairs, which every step must test.
const SEARCH_INTERVAL: u32 = 4;
/// The maximum distance in metres that a ball moves per step, which limits its speed to 4 m/s. Without this limit, bodies
/// that fall from a great height could pass through others.
const MAX_STEP: f32 = 4.0 * STEP;
/// The coefficient of friction between two balls, and between a ball and the floor. In each step, touching objects slide
/// along each other by some distance. Friction reduces this distance by `FRICTION` × the depth of their overlap, but not
/// below 0.
const FRICTION: f32 = 1.5;

/// A rigid body for the simulation of a falling object, with its current position and rotation in the world. It consists of
/// balls that approximate the object. After the simulation, the caller moves the visible shape of the object to its place in
/// the heap with [`Self::moved`].
pub struct Body {
    /// The centre and the radius of each ball of the body, in metres. The centre is relative to the mean of all centres,
    /// along the axes of the coordinates that were given to [`Self::new`].
    balls: Vec<(Vec3, f32)>,
    /// The mean of the balls' centres in metres, in the coordinates that were given to [`Self::new`]. The body rotates
    /// around this point ([`Self::moved`]).
    middle: Vec3,
    /// The mass of each ball: the volume of the body in cubic metres, divided by the number of its balls. When two balls are
    /// moved apart, the one with less mass moves further.
    mass: f32,
    at: Vec3,
    turn: Mat3,
}

impl Body {
    /// Makes a body of `balls`, each with its centre and its radius in metres. The body starts with the rotation `turn`, and
    /// with the mean of the balls' centres at `at` in the world. `volume` in cubic metres is used as the mass of the body,
    /// as if all bodies had the same density.
    pub fn new(mut balls: Vec<(Vec3, f32)>, volume: f32, at: Vec3, turn: Mat3) -> Self {
        let count = balls.len() as f32;
        let middle = balls.iter().map(|b| b.0).sum::<Vec3>() / count;
        balls.iter_mut().for_each(|b| b.0 -= middle);
        Self {
            balls,
            middle,
            mass: volume / count,
            at,
            turn,
        }
    }

    /// Converts a point `p` from the coordinates that were given to [`Self::new`] to the world, with the current position
    /// and rotation of the body.
    pub fn moved(&self, p: Vec3) -> Vec3 {
        self.at + self.turn * (p - self.middle)
    }

    /// Gives the body the position and rotation that fit `balls` best. These are the balls of this body in the simulation,
    /// which have moved independently of each other in this step. Then each ball is put back at its fixed place in the body,
    /// so that the body stays rigid. A body of one ball only gets a position, and keeps its rotation.
    fn fit(&mut self, balls: &mut [Ball]) {
        let count = balls.len() as f32;
        self.at = balls.iter().map(|b| b.at).sum::<Vec3>() / count;
        if balls.len() == 1 {
            return;
        }
        let mut spread = Mat3::ZERO;
        for (ball, &(rest, _)) in balls.iter().zip(&self.balls) {
            let p = ball.at - self.at;
            spread += Mat3::from_cols(p * rest.x, p * rest.y, p * rest.z);
        }
        for _ in 0..2 {
            let (mut torque, mut agreement) = (Vec3::ZERO, 1e-9);
            for axis in 0..3 {
                torque += self.turn.col(axis).cross(spread.col(axis));
                agreement += self.turn.col(axis).dot(spread.col(axis));
            }
            let by = torque / agreement.abs();
            let x = self.turn.x_axis + by.cross(self.turn.x_axis);
            let y = self.turn.y_axis + by.cross(self.turn.y_axis);
            let x = x.normalize();
            let z = x.cross(y).normalize();
            self.turn = Mat3::from_cols(x, z.cross(x), z);
        }
        for (ball, &(rest, _)) in balls.iter_mut().zip(&self.balls) {
            ball.at = self.at + self.turn * rest;
        }
    }
}

#[derive(Clone, Copy)]
struct Ball {
    at: Vec3,
    before: Vec3,
    radius: f32,
    /// 1 / the ball's mass, in 1/m³, because masses are volumes ([`Body::new`]). When two balls are moved apart, the one
    /// with the larger value moves further.
    inverse_mass: f32,
    body: usize,
}

/// Resolves a collision of two balls: if they overlap, moves them apart until they only touch, the lighter
/// one further, and brakes their sliding along each other ([`FRICTION`]). Balls that do not overlap stay as
/// they are.
fn separate(a: &mut Ball, b: &mut Ball) {
    let gap = a.at - b.at;
    let near = a.radius + b.radius;
    if gap.length_squared() >= near * near {
        return;
    }
    let distance = gap.length().max(1e-6);
    let out = gap / distance;
    let depth = near - distance;
    let slide = (a.at - a.before) - (b.at - b.before);
    let slide = slide - out * out.dot(slide);
    let braked = slide * (FRICTION * depth / slide.length().max(1e-9)).min(1.0);
    let push = (out * depth - braked) / (a.inverse_mass + b.inverse_mass);
    a.at += push * a.inverse_mass;
    b.at -= push * b.inverse_mass;
}

/// If a ball reaches below the floor at height 0, lifts it onto the floor, and brakes its sliding ([`FRICTION`]).
fn keep_above_floor(ball: &mut Ball) {
    let depth = ball.radius - ball.at.y;
    if depth > 0.0 {
        let slide = (ball.at - ball.before).with_y(0.0);
        ball.at -= slide * (FRICTION * depth / slide.length().max(1e-9)).min(1.0);
        ball.at.y = ball.radius;
    }
}

/// Finds the pairs of balls that may meet before the next search, as pairs of indices of `balls`. The two balls belong to
/// different bodies, and the smaller index is first.
fn neighbours(balls: &[Ball]) -> Vec<(usize, usize)> {
    // Distance at which a ball may touch something before the next search.
    let reach = |b: &Ball| {
        let way = 1.5 * (b.at - b.before).length() + 0.002;
        b.radius + SEARCH_INTERVAL as f32 * way.min(MAX_STEP)
    };
    // Sorted along the axis of the largest extent.
    let low = balls.iter().fold(Vec3::MAX, |low, b| low.min(b.at));
    let high = balls.iter().fold(Vec3::MIN, |high, b| high.max(b.at));
    let axis = (high - low).max_position();
    let mut order: Vec<(f32, f32, usize)> = balls
        .iter()
        .enumerate()
        .map(|(i, b)| (b.at[axis], reach(b), i))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let largest = order.iter().map(|b| b.1).fold(0.0, f32::max);
    let mut pairs = Vec::new();
    for (n, &(along, own, i)) in order.iter().enumerate() {
        let a = &balls[i];
        let within = order[n + 1..]
            .iter()
            .take_while(|b| b.0 < along + own + largest);
        for &(other, reach, j) in within {
            let near = own + reach;
            let b = &balls[j];
            if other - along < near
                && a.body != b.body
                && (a.at - b.at).length_squared() < near * near
            {
                pairs.push((i.min(j), i.max(j)));
            }
        }
    }
    pairs
}

/// Simulates for `seconds` how bodies fall onto the floor at height 0. Damping is stronger in the last quarter of the time,
/// so that they come to rest.
pub fn simulate_fall(bodies: &mut [Body], seconds: f32) {
    let mut balls = Vec::new();
    for (index, body) in bodies.iter().enumerate() {
        for &(rest, radius) in &body.balls {
            let at = body.at + body.turn * rest;
            balls.push(Ball {
                at,
                before: at,
                radius,
                inverse_mass: 1.0 / body.mass,
                body: index,
            });
        }
    }
    let steps = (seconds / STEP) as u32;
    let mut pairs = Vec::new();
    for step in 0..steps {
        if step % SEARCH_INTERVAL == 0 {
            pairs = neighbours(&balls);
        }
        // Stronger damping towards the end, so that the bodies come to rest.
        let kept = if step * 4 > steps * 3 { 0.97 } else { 0.999 };
        for ball in &mut balls {
            let way = (ball.at - ball.before) * kept - Vec3::Y * (9.81 * STEP * STEP);
            ball.before = ball.at;
            ball.at += way * (MAX_STEP / way.length().max(1e-9)).min(1.0);
        }
        for &(i, j) in &pairs {
            let (low, high) = balls.split_at_mut(j);
            separate(&mut low[i], &mut high[0]);
        }
        balls.iter_mut().for_each(keep_above_floor);
        let mut rest = balls.as_mut_slice();
        for body in &mut *bodies {
            let (own, others) = rest.split_at_mut(body.balls.len());
            body.fit(own);
            rest = others;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_and_a_block_come_to_rest_side_by_side_or_on_each_other() {
        let corners = (0..8).map(|i| {
            let side = |bit: i32| if i >> bit & 1 == 0 { -0.1 } else { 0.1 };
            (Vec3::new(side(0), side(1), side(2)), 0.1)
        });
        let high = Vec3::Y * 1.5;
        let mut bodies = [
            Body::new(vec![(Vec3::ZERO, 0.2)], 0.03, Vec3::Y * 0.5, Mat3::IDENTITY),
            Body::new(corners.collect(), 0.06, high, Mat3::IDENTITY),
        ];
        simulate_fall(&mut bodies, 4.0);
        assert!((bodies[0].at.y - 0.2).abs() < 0.01, "{}", bodies[0].at);
        assert!(bodies[1].at.y > 0.15, "{}", bodies[1].at);
        assert!(bodies[0].at.distance(bodies[1].at) > 0.35);
        let turn = bodies[1].turn;
        assert!((turn.determinant() - 1.0).abs() < 1e-4);
    }
}

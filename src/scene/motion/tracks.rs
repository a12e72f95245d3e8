//! Values that change with time, such as the translation of a node or the strength of an emission: keyframes and their
//! interpolation (glTF 2.0, appendix C).

use glam::{DQuat, DVec3};
use std::ops::{Add, Mul};

/// A type whose values can be the keys of a [`Track`], which interpolates between them: a number, a vector or
/// a rotation.
pub trait Keyed: Copy + PartialEq + Add<Output = Self> + Mul<f64, Output = Self> {
    /// The value at the fraction `t` in [0, 1] of the way from this value to `next`. Numbers and vectors are interpolated
    /// linearly, rotations spherically.
    fn toward(self, next: Self, t: f64) -> Self {
        self * (1.0 - t) + next * t
    }

    /// Corrects the weighted sum of keys and tangents that a cubic spline computes: a rotation is scaled to a unit
    /// quaternion. Numbers and vectors are returned unchanged.
    fn normalized(self) -> Self {
        self
    }

    /// True if no component is NaN or infinite. Other values are refused as keys and tangents.
    fn is_finite(self) -> bool;

    /// The reason why this value cannot be a key, such as `is not finite`; `None` if the value is valid. A message that
    /// names the key ends with this text.
    fn fault(self) -> Option<&'static str> {
        (!self.is_finite()).then_some("is not finite")
    }
}

impl Keyed for f64 {
    fn is_finite(self) -> bool {
        self.is_finite()
    }
}

impl Keyed for DVec3 {
    fn is_finite(self) -> bool {
        self.is_finite()
    }
}

/// A rotation: a unit quaternion. Linear tracks interpolate it spherically along the shorter arc; splines scale each result
/// back to unit length.
impl Keyed for DQuat {
    fn toward(self, next: Self, t: f64) -> Self {
        self.slerp(next, t)
    }

    fn normalized(self) -> Self {
        if self.length() > 1e-12 {
            self.normalize()
        } else {
            Self::IDENTITY
        }
    }

    fn is_finite(self) -> bool {
        self.is_finite()
    }

    fn fault(self) -> Option<&'static str> {
        let unit = (self.length() - 1.0).abs() < 1e-2;
        (!unit).then_some("is not a unit quaternion")
    }
}

/// The method by which a track computes values between its keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Between two keys, the value is that of the earlier key. It jumps to the next key's value at the time of that key.
    Step,
    /// Between two keys, the value is interpolated linearly. A rotation is interpolated spherically, along
    /// the shorter arc.
    Linear,
    /// The value follows a cubic Hermite spline through the values of the keys. Each key also stores two tangents of the
    /// spline: one for the curve before the key, and one for the curve after it.
    CubicSpline,
}

/// Keyframes of one property: values at times in ascending order, and the interpolation between them. [`Track::at`] computes
/// the property's value at any time from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<T> {
    /// The method by which [`Track::at`] computes values between keys: the earlier key's value, linear, or a
    /// cubic spline.
    pub interpolation: Interpolation,
    /// The times of the keys in seconds: at least one, finite, and each not before the one that precedes it. If several keys
    /// are at one time, the value jumps there: it approaches the first of them, and the last of them counts from this time
    /// on. Times may be negative; a picture shows them only if it is rendered at a negative time.
    pub times: Vec<f64>,
    /// The values of the keys, in the order of `times`. Each key has one entry or, with [`Interpolation::CubicSpline`],
    /// three: the incoming tangent, the value, the outgoing tangent. Tangents are changes of the value per second.
    pub values: Vec<T>,
}

/// A fault that [`Track::check`] finds in a track, as a text for a message. The variant says which array contains the fault,
/// so that the reader of a file can name that array in its message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TrackFault {
    /// A fault in [`Track::times`], such as times that decrease. The text describes it and becomes part of the error message.
    Times(String),
    /// A fault in [`Track::values`], such as a number that is not finite. The text describes it and becomes part of the
    /// error message.
    Values(String),
}

impl<T: Keyed> Track<T> {
    /// The number of entries of [`Track::values`] per key: 3 for splines, which also store two tangents; 1 otherwise.
    fn stride(&self) -> usize {
        match self.interpolation {
            Interpolation::CubicSpline => 3,
            Interpolation::Step | Interpolation::Linear => 1,
        }
    }

    /// The values of the keys in the order of their times, without the tangents of a spline. The reader of glTF files uses
    /// them to check that each emission is within its range.
    pub fn keys(&self) -> impl Iterator<Item = T> {
        let (first, stride) = (self.stride() / 2, self.stride());
        self.values.iter().skip(first).step_by(stride).copied()
    }

    /// Checks that the track has keys, that their times never decrease, and that the values are valid and fit the keys. The
    /// other methods rely on these rules, so a scene that breaks them is refused.
    ///
    /// # Errors
    /// The first fault: no keys, a time that is not finite or is before the one that precedes it, a wrong number of values, a
    /// value that is not a valid key, or a tangent that is not finite.
    pub fn check(&self) -> Result<(), TrackFault> {
        let times = |text: String| Err(TrackFault::Times(text));
        let values = |text: String| Err(TrackFault::Values(text));
        if self.times.is_empty() {
            return times("there are no keys".into());
        }
        if let Some(i) = self.times.iter().position(|t| !t.is_finite()) {
            let time = self.times[i];
            return times(format!("key {i} is at {time} s; it must be finite"));
        }
        if let Some(i) = self.times.windows(2).position(|pair| pair[0] > pair[1]) {
            let (time, before) = (self.times[i + 1], self.times[i]);
            return times(format!(
                "key {} is at {time} s, before the preceding key, which is at {before} s",
                i + 1
            ));
        }
        let wanted = self.times.len() * self.stride();
        if self.values.len() != wanted {
            return values(format!(
                "there are {} values for {} keys, not {wanted}",
                self.values.len(),
                self.times.len()
            ));
        }
        for (i, value) in self.keys().enumerate() {
            if let Some(fault) = value.fault() {
                return values(format!("the value of key {i} {fault}"));
            }
        }
        let is_slope = |i: usize| i % self.stride() != self.stride() / 2;
        let wild = |&i: &usize| is_slope(i) && !self.values[i].is_finite();
        if let Some(i) = (0..wanted).find(wild) {
            return values(format!("a slope of key {} is not finite", i / 3));
        }
        Ok(())
    }

    /// The value at `time` (in seconds). Before the first key it is the first key's value, and after the last key the last
    /// key's value.
    pub fn at(&self, time: f64) -> T {
        let (stride, last) = (self.stride(), self.times.len() - 1);
        let value = |key: usize| self.values[key * stride + stride / 2];
        let next = self.times.partition_point(|&key| key <= time);
        if next == 0 || next > last {
            return value(next.min(last));
        }
        let key = next - 1;
        let length = self.times[next] - self.times[key];
        let t = (time - self.times[key]) / length;
        match self.interpolation {
            Interpolation::Step => value(key),
            Interpolation::Linear => value(key).toward(value(next), t),
            Interpolation::CubicSpline => {
                let (out, into) = (self.values[3 * key + 2], self.values[3 * next]);
                let (t2, t3) = (t * t, t * t * t);
                let sum = value(key) * (2.0 * t3 - 3.0 * t2 + 1.0)
                    + out * (length * (t3 - 2.0 * t2 + t))
                    + value(next) * (3.0 * t2 - 2.0 * t3)
                    + into * (length * (t3 - t2));
                sum.normalized()
            }
        }
    }

    /// True if the track has the same value at all times: all keys are equal, and all tangents of a spline are 0. Such a
    /// track can be replaced by its value.
    pub fn is_constant(&self) -> bool {
        let first = self.at(self.times[0]);
        let flat = |value: &T| *value == *value * 0.0;
        self.keys().all(|value| value == first)
            && (self.interpolation != Interpolation::CubicSpline
                || self
                    .values
                    .chunks(3)
                    .all(|key| flat(&key[0]) && flat(&key[2])))
    }
}

/// A value of a moving scene that is constant or changes with time, such as the rotation of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Animated<T> {
    /// The value at all times if there is no track. If there is a track, pictures do not depend on this value; an exported
    /// file states it as the value that applies without the animation.
    pub rest: T,
    /// The keyframes of the value; `None` if the value is constant.
    pub track: Option<Track<T>>,
}

impl<T: Keyed> Animated<T> {
    /// Makes a constant value: it is `rest` at all times, without keyframes.
    pub fn still(rest: T) -> Self {
        Self { rest, track: None }
    }

    /// The value at `time` (in seconds): that of the track or, if there is no track, `rest`.
    pub fn at(&self, time: f64) -> T {
        self.track
            .as_ref()
            .map_or(self.rest, |track| track.at(time))
    }

    /// The values at the keys, in the order of their times; if there is no track, the constant value alone.
    /// An upper bound of a material's emission is computed from them.
    pub fn keys(&self) -> impl Iterator<Item = T> {
        let rest = self.track.is_none().then_some(self.rest);
        rest.into_iter()
            .chain(self.track.iter().flat_map(Track::keys))
    }

    /// The time of the last key in seconds, after which the value is constant; 0 if there is no track.
    pub fn seconds(&self) -> f64 {
        let last = self.track.as_ref().and_then(|track| track.times.last());
        last.copied().unwrap_or(0.0)
    }

    /// If the track has the same value at all times, removes the track and stores its value in `rest`, so that frames need
    /// not compute it.
    pub(super) fn simplify(&mut self) {
        if let Some(track) = self.track.take_if(|track| track.is_constant()) {
            self.rest = track.at(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track<T>(interpolation: Interpolation, times: &[f64], values: Vec<T>) -> Track<T> {
        Track {
            interpolation,
            times: times.to_vec(),
            values,
        }
    }

    #[test]
    fn steps_hold_and_lines_are_straight() {
        let times = [1.0, 2.0, 4.0];
        let step = track(Interpolation::Step, &times, vec![5.0, 7.0, -1.0]);
        for (time, value) in [(0.0, 5.0), (1.9, 5.0), (2.0, 7.0), (3.9, 7.0), (9.0, -1.0)] {
            assert_eq!(step.at(time), value, "{time}");
        }
        let line = track(Interpolation::Linear, &times, vec![5.0, 7.0, -1.0]);
        for (time, value) in [(0.0, 5.0), (1.25, 5.5), (2.0, 7.0), (3.0, 3.0), (4.0, -1.0)] {
            assert_eq!(line.at(time), value, "{time}");
        }
        assert_eq!(line.at(-1e300), 5.0);
        assert_eq!(line.at(f64::INFINITY), -1.0);
    }

    #[test]
    fn several_keys_at_one_time_are_a_jump() {
        let times = [-2.0, 1.0, 1.0, 1.0, 2.0, 2.0];
        let values = vec![0.0, 3.0, 90.0, 5.0, 6.0, 7.0];
        let line = track(Interpolation::Linear, &times, values.clone());
        assert_eq!(line.check(), Ok(()));
        for (time, value) in [(0.0, 2.0), (0.5, 2.5), (1.0, 5.0), (1.5, 5.5), (2.0, 7.0)] {
            assert_eq!(line.at(time), value, "{time}");
        }
        let step = track(Interpolation::Step, &times, values);
        for (time, value) in [(0.0, 0.0), (0.9, 0.0), (1.0, 5.0), (1.9, 5.0), (2.0, 7.0)] {
            assert_eq!(step.at(time), value, "{time}");
        }
        let values = [0.0, 3.0, 5.0, 4.0].map(|value| [0.0, value, 0.0]);
        let spline = track(
            Interpolation::CubicSpline,
            &[0.0, 1.0, 1.0, 2.0],
            values.concat(),
        );
        for (time, value) in [(0.5, 1.5), (1.0, 5.0), (1.5, 4.5), (2.0, 4.0)] {
            assert_eq!(spline.at(time), value, "{time}");
        }
    }

    #[test]
    fn splines_reproduce_the_cubic_they_were_taken_from() {
        let f = |t: f64| DVec3::new(t * t * t - 2.0 * t, 1.0 - t * t, 3.0 * t);
        let slope = |t: f64| DVec3::new(3.0 * t * t - 2.0, -2.0 * t, 3.0);
        let times = [0.5, 1.0, 3.0];
        let values = times.iter().flat_map(|&t| [slope(t), f(t), slope(t)]);
        let spline = track(Interpolation::CubicSpline, &times, values.collect());
        assert_eq!(spline.check(), Ok(()));
        for i in 0..=50 {
            let t = 0.5 + 0.05 * f64::from(i);
            assert!((spline.at(t) - f(t)).length() < 1e-12, "{t}");
        }
        assert_eq!(spline.at(0.0), f(0.5));
        assert_eq!(spline.at(5.0), f(3.0));
    }

    #[test]
    fn rotations_turn_evenly_along_the_shorter_arc() {
        let turn = DQuat::from_rotation_y;
        let line = track(
            Interpolation::Linear,
            &[0.0, 1.0, 2.0],
            vec![turn(0.0), -turn(2.0), turn(3.0)],
        );
        for (time, angle) in [(0.25, 0.5), (0.5, 1.0), (1.5, 2.5)] {
            assert!(line.at(time).dot(turn(angle)).abs() > 1.0 - 1e-12, "{time}");
        }
        let spline = track(
            Interpolation::CubicSpline,
            &[0.0, 1.0],
            [turn(0.0), turn(1.0)]
                .iter()
                .flat_map(|&q| [q * 0.0, q, q * 0.0])
                .collect(),
        );
        assert!((spline.at(0.3).length() - 1.0).abs() < 1e-12);
        assert!(spline.at(0.5).dot(turn(0.5)) > 1.0 - 1e-12);
    }

    #[test]
    fn constant_tracks_are_detected() {
        let step = |values| track(Interpolation::Step, &[0.0, 1.0], values);
        assert!(step(vec![2.0, 2.0]).is_constant());
        assert!(!step(vec![2.0, 3.0]).is_constant());
        let spline = |slope| {
            let values = vec![0.0, 2.0, slope, 0.0, 2.0, 0.0];
            track(Interpolation::CubicSpline, &[0.0, 1.0], values)
        };
        assert!(spline(0.0).is_constant());
        assert!(!spline(1.0).is_constant());
        let mut animated = Animated {
            rest: 0.0,
            track: Some(step(vec![2.0, 2.0])),
        };
        animated.simplify();
        assert_eq!(animated, Animated::still(2.0));
    }

    #[test]
    fn faults_name_times_or_values() {
        let check = |times: &[f64], values: Vec<f64>| {
            track(Interpolation::Linear, times, values)
                .check()
                .unwrap_err()
        };
        let expect = |fault: TrackFault, text: &str| match fault {
            TrackFault::Times(found) => assert!(
                text.starts_with("times") && found.contains(&text[6..]),
                "{found}"
            ),
            TrackFault::Values(found) => assert!(
                text.starts_with("values") && found.contains(&text[7..]),
                "{found}"
            ),
        };
        expect(check(&[], vec![]), "times no keys");
        expect(
            check(&[0.0, f64::NAN], vec![1.0; 2]),
            "times key 1 is at NaN",
        );
        expect(
            check(&[0.0, 2.0, 1.0], vec![1.0; 3]),
            "times key 2 is at 1 s, before the preceding key, which is at 2 s",
        );
        expect(
            check(&[0.0, 2.0], vec![1.0; 3]),
            "values 3 values for 2 keys, not 2",
        );
        expect(
            check(&[0.0], vec![f64::INFINITY]),
            "values the value of key 0 is not finite",
        );
        let spline = track(Interpolation::CubicSpline, &[0.0], vec![f64::NAN, 1.0, 0.0]);
        expect(
            spline.check().unwrap_err(),
            "values a slope of key 0 is not finite",
        );
        let turn = track(
            Interpolation::Step,
            &[0.0],
            vec![DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)],
        );
        expect(
            turn.check().unwrap_err(),
            "values the value of key 0 is not a unit quaternion",
        );
    }
}

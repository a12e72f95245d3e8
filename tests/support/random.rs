//! Random numbers for tests. They depend only on a seed, so each run of a test has the same numbers.

use glam::DVec3;

/// The generator PCG RXS-M-XS with 64 bits of state, which are also its seed (O'Neill 2014).
pub struct Random(pub u64);

impl Random {
    /// A uniform random number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let word =
            ((self.0 >> ((self.0 >> 59) + 5)) ^ self.0).wrapping_mul(12_605_985_483_714_917_081);
        ((word >> 43) ^ word) as f64 / 2_f64.powi(64)
    }

    /// A uniform random index below `count`, which must not be 0.
    pub fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    /// A random unit vector, uniform over the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = 1.0 - 2.0 * self.unit();
        let (sin, cos) = (std::f64::consts::TAU * self.unit()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

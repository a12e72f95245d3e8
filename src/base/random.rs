//! Random numbers for the host that are equal on every machine; shaders have their own. Procedural scenes are made with
//! them, so that the content hash of a scene is the same everywhere. The light BVH also uses them: from each cluster (group
//! of lights) it traces rays in random directions, to measure the distance at which surfaces block the cluster's light.

/// A generator of random numbers, for example for procedural scenes. Equal seeds give equal numbers on every
/// machine. The method is PCG XSH-RR with 64 bits of state (O'Neill, "PCG: A Family of Simple Fast
/// Space-Efficient Statistically Good Algorithms for Random Number Generation", 2014).
pub struct Random(u64);

impl Random {
    /// Makes a generator whose whole sequence of numbers is determined by `seed`.
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        random.bits();
        random
    }

    /// The next 32 random bits, as an unsigned integer. All 2³² values are equally likely.
    pub fn bits(&mut self) -> u32 {
        let state = self.0;
        self.0 = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let word = (((state >> 18) ^ state) >> 27) as u32;
        word.rotate_right((state >> 59) as u32)
    }

    /// The next random number, a multiple of 2⁻²⁴ that is uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }

    /// The next random number, uniform in [`low`, `high`). Because of rounding, it can also be `high` itself.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// The next random number as an index in [0, `count`). All indices have nearly the same probability; `count` must not be
    /// 0.
    pub fn index(&mut self, count: usize) -> usize {
        (self.unit() * count as f32) as usize % count
    }

    /// A random element of `things`, which must not be empty. All elements have nearly the same probability.
    pub fn pick<T: Copy>(&mut self, things: &[T]) -> T {
        things[self.index(things.len())]
    }
}

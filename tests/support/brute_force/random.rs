//! Random numbers of the paths: stratified over a group of paths, and uniform for each path alone.
//!
//! The generator differs from the one of other tests and of the shaders. This path tracer is the independent truth that the
//! renderer is compared with, so a flaw of their generators must not be here too.

use std::array;

/// The number of draws of a path that are stratified over its group: those of the first vertices, which decide most of the
/// noise. Later draws are independent.
const STRATIFIED: usize = 18;
/// The maximum number of paths in a group.
const MOST: u32 = 256;
/// The minimum number of groups per pixel, unless a pixel has fewer paths. The error of a pixel is computed from the spread
/// of its groups, so fewer groups would make it uncertain.
const LEAST_GROUPS: u32 = 8;

/// Random numbers for the paths of one pixel, one group of paths after another.
///
/// The draws of a path come in threes: a single number, then a pair. Over a group, whose size is a power of two, the single
/// number is a van der Corput sequence, and the pair is a (0, 2)-net, the first two dimensions of Sobol's sequence (Sobol'
/// 1967). Each sequence is changed by a random digital shift and assigned to the paths in a random order. So the draws of
/// one path are exactly uniform and independent of each other, and groups are independent; only paths of one group depend on
/// each other (Kollig and Keller, "Efficient Multidimensional Sampling", 2002).
pub struct Draws {
    random: SplitMix64,
    /// The stratified numbers of the present group in [0, 1): for each draw of a path, one number per path.
    dealt: [Vec<f64>; STRATIFIED],
    order: Vec<u32>,
    path: usize,
    draw: usize,
}

impl Draws {
    /// The number of paths in a group for a pixel with `samples` paths: a power of two that divides `samples`.
    pub fn group(samples: u32) -> u32 {
        let most = (samples / LEAST_GROUPS).clamp(1, MOST).ilog2();
        1 << most.min(samples.trailing_zeros())
    }

    /// Random numbers of the pixel `stream`, for groups of `group` paths; `group` must be a power of two.
    pub fn new(seed: u64, stream: u64, group: u32) -> Self {
        assert!(group.is_power_of_two());
        Self {
            random: SplitMix64::new(seed, stream),
            dealt: array::from_fn(|_| vec![0.0; group as usize]),
            order: (0..group).collect(),
            path: 0,
            draw: 0,
        }
    }

    /// Draws the numbers of a new group of paths; [`Self::path`] then selects one of its paths.
    pub fn deal(&mut self) {
        for three in self.dealt.chunks_exact_mut(3) {
            let [one, u, v] = three else { unreachable!() };
            shuffle(&mut self.order, &mut self.random);
            let shift = self.random.next();
            for (to, &from) in one.iter_mut().zip(&self.order) {
                *to = unit(van_der_corput(from) ^ shift);
            }
            shuffle(&mut self.order, &mut self.random);
            let shifts = [self.random.next(), self.random.next()];
            for ((u, v), &from) in u.iter_mut().zip(v).zip(&self.order) {
                *u = unit(van_der_corput(from) ^ shifts[0]);
                *v = unit(sobol(from) ^ shifts[1]);
            }
        }
    }

    /// Selects a path of the group by its index, and begins with its first draw.
    pub fn path(&mut self, path: u32) {
        self.path = path as usize;
        self.draw = 0;
    }

    /// The next draw of the selected path, in [0, 1).
    pub fn unit(&mut self) -> f64 {
        let draw = self.draw;
        self.draw += 1;
        match self.dealt.get(draw) {
            Some(dealt) => dealt[self.path],
            None => unit(self.random.next()),
        }
    }
}

/// Converts the upper 53 bits of a word to a number in [0, 1).
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (-53_f64).exp2()
}

fn van_der_corput(index: u32) -> u64 {
    u64::from(index.reverse_bits()) << 32
}

/// The element at `index` of the second dimension of Sobol's sequence, as a fraction of 2⁶⁴.
fn sobol(index: u32) -> u64 {
    let mut digits = 0;
    let mut column = 1_u32 << 31;
    let mut rest = index;
    while rest != 0 {
        if rest & 1 != 0 {
            digits ^= column;
        }
        column ^= column >> 1;
        rest >>= 1;
    }
    u64::from(digits) << 32
}

/// Brings a list into a random order (Fisher and Yates).
fn shuffle(order: &mut [u32], random: &mut SplitMix64) {
    for last in (1..order.len()).rev() {
        let other = (u128::from(random.next()) * (last as u128 + 1)) >> 64;
        order.swap(last, other as usize);
    }
}

/// The generator SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
struct SplitMix64(u64);

impl SplitMix64 {
    fn new(seed: u64, stream: u64) -> Self {
        let mut start = Self(stream);
        let mixed = start.next() ^ seed;
        start.0 = mixed;
        Self(start.next())
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

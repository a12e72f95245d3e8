//! Random numbers of the paths: stratified over a group of paths, each path's own uniform.
//!
//! The generator is not that of other tests, nor the shaders': this path tracer is the independent
//! truth that the renderer is compared with, so a flaw of theirs must not be here too.

use std::array;

/// Draws of a path that are stratified: those of its first vertices, which matter most. The rest
/// are independent.
const STRATIFIED: usize = 18;
/// Paths of a group at most.
const MOST: u32 = 256;
/// Groups of a pixel at least, where its paths are enough: so many are what its error comes from.
const LEAST_GROUPS: u32 = 8;

/// Random numbers for one group of paths after another.
///
/// The draws of a path come in threes: one by itself, then two that belong together. Over a group,
/// a power of two, the lone one is a van der Corput sequence and the two are a (0, 2)-net, the first
/// two dimensions of Sobol's sequence (Sobol' 1967). Each is moved by a random digital shift and
/// dealt out to the paths in a random order of its own, so that one path's draws are exactly
/// uniform and independent of each other, and so are groups: only paths of one group depend on each
/// other (Kollig and Keller, "Efficient Multidimensional Sampling", 2002).
pub struct Draws {
    random: SplitMix64,
    /// Draw by draw, the numbers of a group's paths.
    dealt: [Vec<f64>; STRATIFIED],
    order: Vec<u32>,
    path: usize,
    draw: usize,
}

impl Draws {
    /// How many paths a group has where a pixel has `samples`: a power of two that divides them.
    pub fn group(samples: u32) -> u32 {
        let most = (samples / LEAST_GROUPS).clamp(1, MOST).ilog2();
        1 << most.min(samples.trailing_zeros())
    }

    /// The numbers of `stream` for groups of `group` paths, a power of two.
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

    /// Deals out a new group; [`Self::path`] then chooses among its paths.
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

    /// Begins with the draws of one path of the group.
    pub fn path(&mut self, path: u32) {
        self.path = path as usize;
        self.draw = 0;
    }

    /// The path's next draw, in [0, 1).
    pub fn unit(&mut self) -> f64 {
        let draw = self.draw;
        self.draw += 1;
        match self.dealt.get(draw) {
            Some(dealt) => dealt[self.path],
            None => unit(self.random.next()),
        }
    }
}

/// In [0, 1), from the upper 53 bits.
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (-53_f64).exp2()
}

fn van_der_corput(index: u32) -> u64 {
    u64::from(index.reverse_bits()) << 32
}

/// The second dimension of Sobol's sequence.
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

/// Fisher and Yates's.
fn shuffle(order: &mut [u32], random: &mut SplitMix64) {
    for last in (1..order.len()).rev() {
        let other = (u128::from(random.next()) * (last as u128 + 1)) >> 64;
        order.swap(last, other as usize);
    }
}

/// The generator of Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014.
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

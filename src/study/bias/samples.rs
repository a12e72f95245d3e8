//! Runs and references without a renderer, for tests of the bias check.

use super::*;

pub const BLOCKS: usize = 6;

/// A reference of six blocks in a row, each of luminance 1 and almost without error, for tests of the bias check.
pub fn reference() -> Reference {
    let side = crate::study::reference::BLOCK;
    let pixels = BLOCKS * side * side;
    let width = (BLOCKS * side) as u32;
    Reference::known(
        width,
        vec![[1.0; 3]; pixels],
        vec![[0.001; 3]; pixels],
        4096,
    )
}

/// A reference of six blocks with known errors. Block `b` is the mean of `counts[b]` runs, so a smaller count gives a
/// larger error. The seeds of these runs are `first_seed` + 1000 · `b` and the following ones.
pub fn noisy_reference(first_seed: u32, counts: [u32; BLOCKS]) -> Reference {
    let blocks: Vec<Estimate> = (0..BLOCKS)
        .map(|b| {
            let of = runs(counts[b], first_seed + 1000 * b as u32, [0.0; BLOCKS]);
            Estimate::of(&of.iter().map(|run| run.blocks[b]).collect::<Vec<f64>>())
        })
        .collect();
    let side = crate::study::reference::BLOCK;
    let mut noisy = reference();
    for (i, (mean, error)) in noisy.mean.iter_mut().zip(&mut noisy.error).enumerate() {
        let block = &blocks[i % (BLOCKS * side) / side];
        *mean = [block.mean as f32; 3];
        // Pixels are independent, so a block's error is a part of each one's.
        *error = [(block.standard_error * side as f64) as f32; 3];
    }
    noisy
}

/// Makes `count` runs with the seeds `first_seed` and following, without rendering. The luminance of block `b` scatters
/// around 1 + `offset[b]`. A part of the noise is common to two neighbouring blocks, as in real pictures.
pub fn runs(count: u32, first_seed: u32, offset: [f64; BLOCKS]) -> Vec<Run> {
    let noise = |seed: u32, block: u32| {
        let bits = blake3::hash(&[seed.to_le_bytes(), block.to_le_bytes()].concat());
        let word = u32::from_le_bytes(bits.as_bytes()[..4].try_into().unwrap());
        f64::from(word) / 4_294_967_296.0 - 0.5
    };
    (first_seed..first_seed + count)
        .map(|seed| {
            let blocks: Vec<f64> = (0..BLOCKS as u32)
                .map(|b| {
                    1.0 + offset[b as usize] + 0.1 * (noise(seed, b) + noise(seed, b / 2 + 99))
                })
                .collect();
            let mean = blocks.iter().sum::<f64>() / BLOCKS as f64;
            Run {
                seed,
                mean: [mean; 3],
                blocks,
                ..Run::default()
            }
        })
        .collect()
}

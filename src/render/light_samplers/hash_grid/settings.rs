//! Settings of the hash grid (`hash_grid.*`), which have an effect with `direct.candidates=hash-grid`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The contents of a reservoir of the hash grid, and the MIS weights with which pixels merge it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GridMode {
    /// Each reservoir belongs to one pixel of the frame, and pixels merge it with defensive weights, independent of
    /// `direct.mis`.
    #[default]
    Unbiased,
    /// Each reservoir mixes points of its cell and is made once, in the first frame, for the surfaces of the whole scene.
    /// Its confidence follows from its number of candidates: biased, as published.
    Published,
}

/// The hash grid: reservoirs of direct light in cells of space, which pixels merge with their own candidates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HashGridSettings {
    /// The contents of a reservoir, and the MIS weights with which pixels merge it. `published` is biased.
    pub mode: GridMode,
    /// Size of a cell, in pixels; in the scene, the size is rounded up or down at random to a power of two. Higher: more
    /// reservoirs that pixels have in common, which fit them less well. No effect with `published`.
    #[schemars(range(min = 1, max = 1024))]
    pub cell: u32,
    /// Number of cells along the longest side of the scene, with `published` only. Higher: reservoirs that fit better, but
    /// fewer of them per cell.
    #[schemars(range(min = 1, max = 1024))]
    pub cells: u32,
    /// Number of bins of normals along each side of the octahedral map: 8 means 64 bins; 1: normals do not matter. Higher:
    /// reservoirs that fit the pixels better, but fewer of them per pixel.
    #[schemars(range(min = 1, max = 16))]
    pub bins: u32,
    /// Maximum number of reservoirs per cell and bin. Higher: pixels have fewer samples in common, but find fewer reservoirs
    /// in small cells.
    #[schemars(range(min = 1, max = 1024))]
    pub reservoirs: u32,
    /// Number of light candidates of each reservoir. Higher: better samples. Cost per candidate: one light sample in one of
    /// sixteen pixels.
    #[schemars(range(min = 1, max = 65536))]
    pub candidates: u32,
    /// Maximum number of reservoirs that a pixel merges with its own candidates. Cost: three evaluations of the target
    /// function each, no ray.
    #[schemars(range(min = 1, max = 16))]
    pub merged: u32,
    /// Confidence of each merged reservoir. Unit: all candidates of the pixel together. Higher: less noise in first frames,
    /// more in late ones, since pixels have samples in common. Unbiased at any value. With `published`, the confidence is
    /// `candidates` divided by `direct.light_samples` instead, and at least 1.
    #[schemars(range(min = 1, max = 500))]
    pub confidence: u32,
    /// Index of the first frame in which pixels do not merge these reservoirs, because their history is better; 0: pixels
    /// always merge them.
    #[schemars(range(min = 0, max = 1000000))]
    pub until_frame: u32,
}

impl Default for HashGridSettings {
    fn default() -> Self {
        Self {
            mode: GridMode::default(),
            cell: 16,
            cells: 64,
            bins: 8,
            reservoirs: 4,
            candidates: 64,
            merged: 4,
            confidence: 1,
            until_frame: 0,
        }
    }
}

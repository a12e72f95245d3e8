//! Settings of the hash grid, from which `candidates=hash-grid` draws.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a reservoir of the hash grid is made of, and how pixels merge it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GridMode {
    /// Each reservoir belongs to one point, and pixels weigh it as every other technique.
    #[default]
    Unbiased,
    /// Each reservoir mixes points of its cell, and pixels trust it by its number of candidates: biased, as published.
    Published,
}

/// Reservoirs of direct light at points of the scene's surfaces, which pixels merge with their own initial ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HashGridSettings {
    /// What a reservoir is made of, and how pixels merge it. `published` is biased.
    pub mode: GridMode,
    /// Cells along the longest side of the scene. Higher: reservoirs that fit the pixels better, and more of them.
    #[schemars(range(min = 1, max = 128))]
    pub cells: u32,
    /// Bins of normals along each side of the octahedral map: 8 are 64 bins; 1: normals do not matter. Higher: reservoirs
    /// that fit the pixels better, and more of them.
    #[schemars(range(min = 1, max = 16))]
    pub bins: u32,
    /// Maximum number of reservoirs of a cell's bin. Higher: pixels have fewer samples in common. Cost: 36 bytes each.
    #[schemars(range(min = 1, max = 1024))]
    pub reservoirs: u32,
    /// Light candidates of each reservoir. Higher: better samples. Cost: one target each when a cell is first seen, and
    /// when it is refreshed; no ray.
    #[schemars(range(min = 1, max = 65536))]
    pub candidates: u32,
    /// Reservoirs that a pixel merges with its own. Cost: three targets each, and one ray for all.
    #[schemars(range(min = 1, max = 16))]
    pub merged: u32,
    /// Confidence of each of these; a pixel's own initial reservoir has 1. Higher: less noise in first frames, more in late
    /// ones, since pixels have samples in common. Unbiased at any value.
    #[schemars(range(min = 1, max = 500))]
    pub confidence: u32,
    /// Frames after which all reservoirs in use are made anew, some in each frame; 0: never. Lower: errors do not stay, at
    /// the cost of making them. Where things move, all are made anew in each frame.
    #[schemars(range(min = 0, max = 10000))]
    pub refresh: u32,
    /// The frame from which on pixels do not merge them any more, because their own history is better; 0: never ends.
    #[schemars(range(min = 0, max = 1000000))]
    pub until_frame: u32,
}

impl Default for HashGridSettings {
    fn default() -> Self {
        Self {
            mode: GridMode::default(),
            cells: 64,
            bins: 8,
            reservoirs: 16,
            candidates: 32,
            merged: 4,
            confidence: 1,
            refresh: 16,
            until_frame: 0,
        }
    }
}

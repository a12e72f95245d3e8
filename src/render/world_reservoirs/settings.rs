//! Settings of world reservoirs (`world_reservoirs.*`), which have an effect with `indirect.secondary=world-reservoirs`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The MIS weights with which path vertices merge world reservoirs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WorldMode {
    /// Each sample is weighted by its target function at all merged vertices: unbiased.
    #[default]
    Unbiased,
    /// Each sample is weighted by the confidence of its reservoir alone: biased, as published.
    Published,
}

/// The light sample that a path vertex stores for vertices of the next frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WorldStores {
    /// The sample that a matte white surface at the vertex would select from the light candidates of the vertex. No sample
    /// is passed on from frame to frame, as published.
    Initial,
    /// The sample that the merge selected, so that samples are passed on from frame to frame. A merge weights each stored
    /// sample as if a matte white surface had selected it. Metal and surfaces with interpolated normals can never select
    /// some of the light that a matte white surface reflects. To avoid bias, vertices on them store the sample that
    /// `initial` stores.
    #[default]
    Merged,
}

/// World reservoirs: path vertices store reservoirs in cells of space, and vertices of the next frame merge them with their
/// own light samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WorldReservoirsSettings {
    /// The MIS weights with which vertices merge world reservoirs, independent of `indirect.mis`. `unbiased` uses the
    /// weights of `mis=defensive`; `published` is biased.
    pub mode: WorldMode,
    /// The light sample that a vertex stores for vertices of the next frame. No effect on bias.
    pub stores: WorldStores,
    /// Size of a cell, in pixels; in the scene, the size is rounded up or down at random to a power of two. Higher: more
    /// reservoirs to choose from, which fit less well. Unbiased at any value.
    #[schemars(range(min = 1, max = 4096))]
    pub cell: u32,
    /// Number of bins of normals along each side of the octahedral map: 8 means 64 bins; 1: normals do not matter. Higher:
    /// reservoirs that fit better, but fewer of them. Unbiased at any value.
    #[schemars(range(min = 1, max = 16))]
    pub bins: u32,
    /// Width of the range around a vertex from which it selects a cell at random. Unit: cells. Lower: the borders of cells
    /// show in the noise. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 16.0))]
    pub jitter: f32,
    /// Maximum number of world reservoirs that a vertex merges with its own light sample. Cost: three evaluations of the
    /// target function each, no ray. Unbiased at any value.
    #[schemars(range(min = 1, max = 16))]
    pub merged: u32,
    /// Maximum confidence of each merged reservoir. Unit: all light samples of a vertex together. Higher: less noise, but
    /// errors stay longer. No effect with `stores=initial`, where the confidence is 1. Unbiased at any value.
    #[schemars(range(min = 1, max = 500))]
    pub confidence_cap: u32,
    /// Number of slots in the table of cells, per vertex of a frame; the total is rounded up to a power of two. Lower: less
    /// memory, but cells without a slot are left out, which gives more noise. Unbiased at any value.
    #[schemars(range(min = 1e-9, max = 1000.0))]
    pub table: f64,
    /// Minimum number of lights for world reservoirs; rare lights and infinitely distant lights do not count. A scene with a
    /// single emitter group, of any number of triangles, has no world reservoirs either. With few lights, the candidates of
    /// a vertex find the right ones. 0: every scene has world reservoirs.
    #[schemars(range(min = 0, max = 1000000000))]
    pub min_lights: u32,
    /// Number of vertices per path, from the second vertex on, that have reservoirs. Cost: about 74 bytes per pixel for each
    /// vertex. Unbiased at any value.
    #[schemars(range(min = 1, max = 1000))]
    pub depth: u32,
}

impl Default for WorldReservoirsSettings {
    fn default() -> Self {
        Self {
            mode: WorldMode::default(),
            stores: WorldStores::default(),
            cell: 16,
            bins: 4,
            jitter: 1.0,
            merged: 4,
            confidence_cap: 8,
            table: 0.25,
            min_lights: 64,
            depth: 1,
        }
    }
}

//! Settings of world reservoirs, with `indirect.secondary=world-reservoirs`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The way in which world reservoirs are merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WorldMode {
    /// Vertices weigh each sample by its target function at all merged vertices.
    #[default]
    Unbiased,
    /// Vertices weigh samples by confidence alone: biased, as published.
    Published,
}

/// The sample that a vertex keeps for vertices of the next frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WorldStores {
    /// The sample that the light candidates of the vertex selected, as published.
    Initial,
    /// The sample that the merge selected, so that samples are passed on from frame to frame; as `initial` on metal and where
    /// normals are interpolated.
    #[default]
    Merged,
}

/// Reservoirs of the vertices of indirect paths, in cells of space; vertices of the next frame merge them with their
/// reservoirs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WorldReservoirsSettings {
    /// The way in which reservoirs are merged, independent of `indirect.mis`: `unbiased` as for neighbours with
    /// `mis=defensive`. `published` is biased.
    pub mode: WorldMode,
    /// The sample that a vertex keeps for vertices of the next frame. No effect on bias.
    pub stores: WorldStores,
    /// Size of a cell, in pixels; in the scene, it is rounded up or down at random to a power of two. Higher: more reservoirs
    /// to choose from, which fit less well. Unbiased at any value.
    #[schemars(range(min = 1, max = 4096))]
    pub cell: u32,
    /// Bins of normals along each side of the octahedral map: 8 means 64 bins; 1: normals do not matter. Unbiased at any value.
    #[schemars(range(min = 1, max = 16))]
    pub bins: u32,
    /// Width of the range around a vertex in which it looks for a cell. Unit: cells. Lower: the borders of cells show in the
    /// noise. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 16.0))]
    pub jitter: f32,
    /// Number of reservoirs that a vertex merges with its candidates. Cost: three targets each, no ray. Unbiased at any value.
    #[schemars(range(min = 1, max = 16))]
    pub merged: u32,
    /// Maximum confidence of each merged reservoir. Unit: all light samples of a vertex together. Higher: less noise, but
    /// errors stay longer. No effect with `stores=initial`, where it is 1. Unbiased at any value.
    #[schemars(range(min = 1, max = 500))]
    pub confidence_cap: u32,
    /// Slots of the table of cells per vertex of a frame; the total is rounded up to a power of two. Lower: less memory, but
    /// cells without a slot are left out, which gives more noise. Unbiased at any value.
    #[schemars(range(min = 1e-9, max = 1000.0))]
    pub table: f64,
    /// Minimum number of lights for world reservoirs; rare lights and infinitely distant lights do not count. A scene with a
    /// single emitter group, of any number of triangles, has no world reservoirs either. With few lights, the candidates of a
    /// vertex find the right ones. 0: always.
    #[schemars(range(min = 0, max = 1000000000))]
    pub min_lights: u32,
    /// Number of vertices per path, from the second vertex on, that have reservoirs. Cost: about 74 bytes per pixel each.
    /// Unbiased at any value.
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

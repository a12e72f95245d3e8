//! Settings of world reservoirs, with `indirect.secondary=world-reservoirs`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The way in which world reservoirs are merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WorldMode {
    /// By what each of the merged vertices would reflect of each sample.
    #[default]
    Unbiased,
    /// By confidence alone: biased, as published.
    Published,
}

/// The sample that a vertex keeps for vertices of the next frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WorldStores {
    /// The sample that its own light candidates selected, as published.
    Initial,
    /// The sample that it merged, so that samples pass on from frame to frame; on metal and where normals are interpolated as `initial`.
    #[default]
    Merged,
}

/// Reservoirs of the vertices of indirect paths, in cells of space, which the vertices of the next frame merge with their own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WorldReservoirsSettings {
    /// The way in which they are merged, whatever `indirect.mis` is: `unbiased` like neighbours with `mis=defensive`. `published` is biased.
    pub mode: WorldMode,
    /// The sample that a vertex keeps for vertices of the next frame. No effect on bias.
    pub stores: WorldStores,
    /// Side of a cell, in pixels; in the scene, it is rounded up or down at random to a power of two. Higher: more reservoirs to
    /// choose from, which fit less well. Unbiased at any value.
    #[schemars(range(min = 1, max = 4096))]
    pub cell: u32,
    /// Bins of normals along each side of the octahedral map: 8 are 64 bins; 1: normals do not matter. Unbiased at any value.
    #[schemars(range(min = 1, max = 16))]
    pub bins: u32,
    /// Width of the range, around itself, in which a vertex looks for a cell. Unit: cells. Lower: the borders of cells show in
    /// the noise. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 16.0))]
    pub jitter: f32,
    /// Reservoirs that a vertex merges with its own. Cost: three targets each, no ray. Unbiased at any value.
    #[schemars(range(min = 1, max = 16))]
    pub merged: u32,
    /// Maximum confidence of each of these. Unit: a vertex' own light samples together. Higher: less noise, but errors stay
    /// longer. No effect with `stores=initial`, where it is 1. Unbiased at any value.
    #[schemars(range(min = 1, max = 500))]
    pub confidence_cap: u32,
    /// Slots of the table of cells for each vertex of a frame, rounded up to a power of two in all. Lower: less memory, and
    /// cells that find no slot are left out: more noise. Unbiased at any value.
    #[schemars(range(min = 1e-9, max = 1000.0))]
    pub table: f64,
    /// Minimum number of lights for world reservoirs, without those that are rare or infinitely far away; one emitter group
    /// alone, of any number of triangles, has none either. With few lights vertices draw the right ones themselves. 0: always.
    #[schemars(range(min = 0, max = 1000000000))]
    pub min_lights: u32,
    /// Vertices of a path, from the second on, that have reservoirs. Cost: about 74 bytes a pixel each. Unbiased at any value.
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

//! Settings of world reservoirs (`world_reservoirs.*`), the reservoirs of path vertices, whose light samples paths of the
//! next frame reuse. They have an effect only with `indirect.secondary=world-reservoirs`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The MIS weights with which path vertices merge world reservoirs, the reservoirs that vertices of the previous frame
/// stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WorldMode {
    /// The MIS weight of a sample follows from its target function at the vertices of all merged reservoirs (defensive
    /// weights). This is unbiased.
    #[default]
    Unbiased,
    /// The MIS weight of a sample follows from the confidence of its reservoir alone. This is biased, as published (Boissé
    /// 2021).
    Published,
}

/// The light sample that a path vertex stores in its world reservoir, so that vertices of the next frame can merge it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WorldStores {
    /// The sample that a matte white surface at the vertex would select from the vertex's own light candidates, as published
    /// (Boissé 2021). So no sample is passed on over several frames.
    Initial,
    /// The sample that the vertex selected in its merge, so samples are passed on from frame to frame. Later merges compute
    /// MIS weights as if a matte white surface at the vertex had selected it. Metal and surfaces with interpolated normals
    /// cannot select every sample that a matte white surface can, so these weights would cause bias there. Vertices on such
    /// surfaces therefore store the sample of `initial`.
    #[default]
    Merged,
}

/// Settings of world reservoirs: path vertices store light samples in cells of space, and vertices of the next frame merge
/// the samples of their cell with their own light samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WorldReservoirsSettings {
    /// The MIS weights with which vertices merge world reservoirs, independent of `indirect.mis`. `unbiased` uses the
    /// weights of `mis=defensive`; `published` is biased.
    pub mode: WorldMode,
    /// The light sample that a vertex stores for vertices of the next frame: `initial` is selected from the vertex's own
    /// light candidates alone, `merged` is the result of its merge. No effect on bias.
    pub stores: WorldStores,
    /// Side of a cell of space, as the number of pixels that it spans in the picture. The length of the side in the scene
    /// is a power of two (in the device's unit of length), so that cells stay in place while the camera moves. It is
    /// chosen at random: either the next power of two below the length that this many pixels span, or the next one above.
    /// Higher: a vertex can choose from more reservoirs, but their vertices are farther away from it, so their samples
    /// fit it less well. Unbiased at any value.
    #[schemars(range(min = 1, max = 4096))]
    pub cell: u32,
    /// Number of bins along each side of the octahedral map of normals (the unit sphere, unfolded to a square): 8 means 64
    /// bins. A vertex merges only reservoirs in the bin of its own normal; 1: normals do not matter. Higher: reservoirs that
    /// fit better, but fewer of them. Unbiased at any value.
    #[schemars(range(min = 1, max = 16))]
    pub bins: u32,
    /// Width of the range on the surface around a vertex in which a random point is picked; the vertex merges reservoirs of
    /// the cell at this point. Unit: cells. 0: the vertex's own cell. Lower: the borders of cells become visible in the
    /// noise. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 16.0))]
    pub jitter: f32,
    /// Maximum number of world reservoirs that a vertex merges with its own light sample. Higher: each vertex benefits from
    /// more light samples. Cost: three evaluations of the target function per reservoir, no ray. Unbiased at any value.
    #[schemars(range(min = 1, max = 16))]
    pub merged: u32,
    /// Maximum confidence of each merged reservoir in a merge, where 1 is the confidence of all light samples of a vertex
    /// together. Higher: less noise, but errors stay longer. No effect with `stores=initial`, where the confidence is 1.
    /// Unbiased at any value.
    #[schemars(range(min = 1, max = 500))]
    pub confidence_cap: u32,
    /// Number of slots in the table that finds cells, divided by the number of vertices of a frame; the number of slots is
    /// rounded up to a power of two. Each slot can store one cell. Lower: less memory, but the reservoirs of cells without a
    /// slot are not used, so there is more noise. Unbiased at any value.
    #[schemars(range(min = 1e-9, max = 1000.0))]
    pub table: f64,
    /// Minimum number of lights for world reservoirs. In scenes with fewer lights they are switched off, because there the
    /// light candidates of a vertex already give little noise. They are also switched off if all lights are triangles of a
    /// single emitter group (triangles with common corners form one group). Infinitely distant lights do not count. Rare
    /// lights (the dimmest ones) do not count either if they have separate candidates. 0: every scene has world reservoirs,
    /// even one with a single emitter group.
    #[schemars(range(min = 0, max = 1000000000))]
    pub min_lights: u32,
    /// Maximum number of vertices of each path that store and merge world reservoirs, counted from the second vertex on.
    /// Higher: later vertices have less noise. Cost: about 74 bytes per pixel for each vertex. Unbiased at any value.
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

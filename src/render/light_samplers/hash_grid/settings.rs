//! Settings of the hash grid (`hash_grid.*`). The grid stores reservoirs of direct light in cells of space, and each pixel
//! merges the reservoirs of its cell with its own light candidates. The settings have an effect only with
//! `direct.candidates=hash-grid`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The points for which the hash grid makes its reservoirs of direct light, and the MIS weights with which pixels merge
/// these reservoirs. The grid stores the reservoirs in cells of space, so that pixels find those that were made near their
/// own surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GridMode {
    /// The hash grid makes each reservoir for the surface of a pixel, and makes all reservoirs again in each frame. Pixels
    /// merge them with defensive MIS weights, for any value of `direct.mis`. This is unbiased.
    #[default]
    Unbiased,
    /// The hash grid makes the reservoirs once, in the first frame, for points on all surfaces of the scene. The candidates
    /// of one reservoir are drawn at several points of its cell. The MIS weights depend on the confidence of the reservoirs
    /// alone. This is biased, as in the publication ("Normal-aware hash grid of precomputed reservoirs", 2025).
    Published,
}

/// Settings of the hash grid, which stores reservoirs of direct light in cells of space. Pixels merge the reservoirs of
/// their cell with their own light candidates, so that each pixel selects its light among more candidates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HashGridSettings {
    /// The points for which the reservoirs are made (surfaces of pixels, or points in the whole scene), and the MIS weights
    /// with which pixels merge the reservoirs. `published` is biased.
    pub mode: GridMode,
    /// Side of a cell of space, as the number of pixels that it spans in the picture. The length of the side in the scene
    /// is a power of two (in the device's unit of length), so that cells stay in place while the camera moves. It is
    /// chosen at random: either the next power of two below the length that this many pixels span, or the next one above.
    /// Higher: more pixels merge the same reservoirs, which were made for surfaces farther away from these pixels. No
    /// effect with `published`.
    #[schemars(range(min = 1, max = 1024))]
    pub cell: u32,
    /// Number of cells along the longest side of the box around all surfaces of the scene. Higher: smaller cells, so
    /// reservoirs fit the pixels better. But each cell then has fewer reservoirs, because the number of points on surfaces
    /// for which reservoirs are made is fixed. No effect with `unbiased`.
    #[schemars(range(min = 1, max = 1024))]
    pub cells: u32,
    /// Number of bins along each side of the octahedral map of normals (the unit sphere, unfolded to a square): 8 means 64
    /// bins. A pixel merges only reservoirs in the bin of its own normal; 1: normals do not matter. Higher: reservoirs that
    /// fit the pixels better, but fewer of them per pixel.
    #[schemars(range(min = 1, max = 16))]
    pub bins: u32,
    /// Number of slots for reservoirs in each cell, for each bin of normals (see `bins`). A slot stores one reservoir or
    /// none. A pixel looks at `merged` random slots. Higher: two pixels less often merge the same reservoirs, but in small
    /// cells more of these slots are empty.
    #[schemars(range(min = 1, max = 1024))]
    pub reservoirs: u32,
    /// Number of light candidates from which one is selected for each reservoir of the grid. Higher: reservoirs with less
    /// noise. Cost: one evaluation of the target function per candidate, and no ray. At most one of sixteen pixels makes a
    /// reservoir in each frame; with `published`, all reservoirs are made in the first frame.
    #[schemars(range(min = 1, max = 65536))]
    pub candidates: u32,
    /// Maximum number of reservoirs of the grid that a pixel merges with its own candidates in each frame. Higher: each
    /// pixel benefits from more candidates. Cost: three evaluations of the target function per reservoir, no ray.
    #[schemars(range(min = 1, max = 16))]
    pub merged: u32,
    /// Confidence of each merged reservoir of the grid, where 1 is the confidence of all candidates of the pixel together.
    /// Higher: less noise in the first frames, but more in later ones, because pixels then have samples in common. Unbiased
    /// at any value. With `published`, the confidence is instead `candidates` divided by `direct.light_samples`, but at
    /// least 1.
    #[schemars(range(min = 1, max = 500))]
    pub confidence: u32,
    /// Index of the first frame in which pixels no longer merge reservoirs of the grid, or 0 if they merge them in every
    /// frame. After some frames, the reservoirs of the previous frame are better than those of the grid.
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

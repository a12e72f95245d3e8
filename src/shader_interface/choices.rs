//! Enumerations that settings and shaders share. Each is declared once, in Rust; each variant becomes a `uint` constant in
//! GLSL.

crate::gpu_enum! {
    /// The MIS heuristic of path tracing. It weighs the two techniques that find the light of an emitter: light samples, and
    /// BSDF rays that hit the emitter. It changes the noise, not the mean.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Heuristic {
        /// Weights in proportion to the densities of the two techniques: the noise is close to the minimum in every scene.
        #[default]
        Balance,
        /// Weights in proportion to the squares of the densities: less noise where one of the two techniques is much better
        /// than the other.
        Power,
    }
}

crate::gpu_enum! {
    /// The MIS weights of a merge. They divide each sample's contribution among the reservoirs that could have drawn this
    /// sample.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Mis {
        /// Weights by confidence alone: cheapest, but biased where a neighbour cannot draw samples that the pixel needs.
        Constant,
        /// The balance heuristic over all reservoirs of the merge: unbiased, least noise; the cost grows with the square of
        /// the number of neighbours.
        Balance,
        /// The balance heuristic between the pixel and one neighbour at a time: unbiased; the cost grows linearly with the
        /// number of neighbours.
        Pairwise,
        /// Pairwise weights in which the sample of the pixel's own reservoir keeps a minimum weight: unbiased, and with less
        /// noise where neighbours have poor samples.
        #[default]
        Defensive,
    }
}

crate::gpu_enum! {
    /// The source of the surface points that fill the hash grid. The hash grid is a light sampler that stores reservoirs of
    /// direct light in cells of space, which pixels in the cell merge with their own light samples.
    pub enum HashGrid {
        /// There is no hash grid: pixels draw light samples by another light sampler only.
        #[default]
        None,
        /// The surface at one random pixel of each block of 4 × 4 pixels, selected again in every frame: unbiased.
        Pixels,
        /// Points on all surfaces of the scene, from a list. They fill the grid once, in the first frame, and the grid then
        /// stays as it is. This is the method as published ("Normal-aware hash grid of precomputed reservoirs", 2025); it is
        /// biased.
        Points,
    }
}

crate::gpu_enum! {
    /// The way in which vertices of indirect paths reuse light samples. A vertex can merge its own light sample with those
    /// that vertices of the previous frame stored in the same cell of space (world reservoirs).
    pub enum WorldReservoirs {
        /// Vertices reuse no samples: each uses only the light samples that it draws.
        #[default]
        None,
        /// Vertices merge world reservoirs by defensive MIS weights. Each reservoir stores its own shading point, which
        /// these weights need to be exact.
        Unbiased,
        /// Vertices weigh world reservoirs by confidence alone, as published (Boissé, "World-Space Spatiotemporal Reservoir
        /// Reuse for Ray-Traced Global Illumination", 2021). It is biased.
        Published,
    }
}

crate::gpu_enum! {
    /// The step of resampling at which shadow rays test whether the shading point sees a sample. It decides on bias, noise
    /// and the number of rays.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Visibility {
        /// No test: shadows are missing. Biased, for comparisons only.
        None,
        /// A test, with one ray, only where the sample that was selected last is shaded. For direct light it is unbiased and
        /// noisy in shadows, and no BSDF samples are drawn. Paths of indirect light are traced anyway, so for them `final`
        /// means `initial`.
        Final,
        /// A test of the selected initial candidate, and another one where the selected sample is shaded. Biased: the
        /// picture is too dark.
        Initial,
        /// A test in every target function that a merge evaluates: one ray per target function with `mis=balance`, two rays
        /// for a pairwise merge. Unbiased.
        #[default]
        Weights,
    }
}

crate::gpu_enum! {
    /// The contents of a reservoir in memory. With the compact format, shaders read more from the scene when they unpack a
    /// reservoir; the full format needs more memory.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Format {
        /// 16 bytes for direct and 32 for indirect light: the index of the triangle or light, and the point on it. Position,
        /// normal, material and emission at the point are read from the scene.
        #[default]
        Compact,
        /// 44 bytes for direct and 60 for indirect light: the content of the compact format, and more. For direct light
        /// these are position, normal and emission at the point on the light; for indirect light, position, normals and
        /// material index at the second vertex of the path.
        Full,
    }
}

crate::gpu_enum! {
    /// The order of pixels in the buffers of resampling with one entry per pixel; the setting `reservoirs.order` selects it.
    /// It changes the locality of memory access, never the picture.
    pub enum PixelOrder {
        /// Row by row from the top, each row from left to right.
        #[default]
        Row,
        /// Column by column from the left, each column from top to bottom.
        Column,
        /// Square tile by square tile, and row by row within each tile. The side of a tile in pixels is
        /// [`Specialisation::swizzle`](crate::Specialisation::swizzle).
        Swizzle,
    }
}

/// The GLSL text of all enumerations of this file: for each variant one line `const uint ENUMERATION_VARIANT = INDEXu;`,
/// where the index counts the variants from 0.
pub fn glsl() -> String {
    [
        Heuristic::glsl(),
        HashGrid::glsl(),
        WorldReservoirs::glsl(),
        Mis::glsl(),
        Visibility::glsl(),
        Format::glsl(),
        PixelOrder::glsl(),
    ]
    .concat()
}

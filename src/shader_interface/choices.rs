//! Enumerations that settings and shaders share: the user selects a variant, and shaders follow it. Each enumeration is
//! declared once, in Rust; each variant becomes a `uint` constant in GLSL.

crate::gpu_enum! {
    /// The MIS heuristic of path tracing. It weighs the two techniques that find the light of an emitter: light samples, and
    /// BSDF rays that hit the emitter. It changes the noise, not the mean.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Heuristic {
        /// The weights of light samples and BSDF rays are proportional to their densities. No other heuristic
        /// has much less noise in any scene.
        #[default]
        Balance,
        /// The weights of light samples and BSDF rays are proportional to the squares of their densities. This has less
        /// noise where one of the two techniques is much better than the other.
        Power,
    }
}

crate::gpu_enum! {
    /// The model of a camera, which decides where its primary rays begin and where they go.
    pub enum CameraModel {
        /// All primary rays begin at the camera's position.
        #[default]
        Pinhole,
        /// All primary rays have the same direction, and begin in a plane through the camera's position.
        Orthographic,
        /// The primary rays of a pixel begin at all points of a disc around the camera's position, and meet at the focus
        /// distance.
        ThinLens,
    }
}

crate::gpu_enum! {
    /// The MIS weights of a merge, which selects one sample from the reservoirs of a pixel, of its neighbours or of the
    /// previous frame. The weights divide each sample's contribution among the reservoirs that could have drawn this sample.
    /// They decide on bias, noise and cost.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Mis {
        /// The weights are proportional to the confidences of the reservoirs. This is the cheapest choice, but it is biased
        /// where a neighbour cannot draw samples that the merging pixel needs.
        Constant,
        /// The balance heuristic compares all reservoirs of the merge. It is unbiased and has the least noise, but its cost
        /// grows with the square of the number of neighbours.
        Balance,
        /// The balance heuristic is applied to pairs: the merging pixel and one neighbour at a time. It is unbiased, and its
        /// cost grows linearly with the number of neighbours.
        Pairwise,
        /// The weights are those of `pairwise`, but the sample of the merging pixel's own reservoir always keeps a minimum
        /// weight. They are unbiased, and have less noise than `pairwise` where neighbours have poor samples.
        #[default]
        Defensive,
    }
}

crate::gpu_enum! {
    /// The source of the surface points that fill the hash grid. The hash grid is a light sampler: it stores
    /// reservoirs of direct light in cells of space, and each pixel merges reservoirs of its cell with its
    /// own light samples.
    pub enum HashGrid {
        /// There is no hash grid: pixels draw light samples by another light sampler only.
        #[default]
        None,
        /// In every frame, one random pixel of each block of 4 × 4 pixels is selected. The surfaces that the camera sees at
        /// these pixels fill the hash grid with reservoirs of light samples. This is unbiased.
        Pixels,
        /// A list of points on all surfaces of the scene fills the hash grid with reservoirs of light
        /// samples. The grid is filled once, in the first frame, and then stays unchanged. This is the method
        /// as published ("Normal-aware hash grid of precomputed reservoirs", 2025), and it is biased.
        Points,
    }
}

crate::gpu_enum! {
    /// The way in which vertices of indirect paths reuse light samples. A vertex can merge its own light sample with those
    /// that vertices of the previous frame stored in the same cell of space (world reservoirs).
    pub enum WorldReservoirs {
        /// Vertices of indirect paths reuse no light samples: each vertex uses only the light samples that it draws.
        #[default]
        None,
        /// Vertices of indirect paths merge world reservoirs by the MIS weights of `mis=defensive`, which is unbiased: each
        /// world reservoir stores its shading point, so the weights can be computed exactly.
        Unbiased,
        /// Vertices of indirect paths merge world reservoirs with weights that depend only on confidence, as published
        /// (Boissé, "World-Space Spatiotemporal Reservoir Reuse for Ray-Traced Global Illumination", 2021). This is biased.
        Published,
    }
}

crate::gpu_enum! {
    /// The step of resampling at which shadow rays test whether the shading point sees a sample. It decides on bias, noise
    /// and the number of rays.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Visibility {
        /// Visibility is never tested, so shadows are missing. This is biased, and useful only for comparisons.
        None,
        /// One shadow ray tests the sample that remains after all merges, when a pixel shades it. For direct light this is
        /// unbiased but noisy in shadows, and no BSDF samples are drawn. Paths of indirect light are traced in any case, so
        /// for indirect light `final` has the effect of `initial`.
        Final,
        /// A shadow ray tests the selected initial candidate, and another one tests the sample that is shaded at the end.
        /// This is biased: the picture is too dark.
        Initial,
        /// Shadow rays of each merge test whether shading points see the samples of other pixels, so that the weights of the
        /// samples take shadows into account. With `mis=balance` there is one ray for each pair of a sample and a shading
        /// point; otherwise a merge traces at most two rays. This is unbiased.
        #[default]
        Weights,
    }
}

crate::gpu_enum! {
    /// The contents of a reservoir in memory. The choice changes speed and memory: with the compact format, shaders read
    /// more from the scene when they unpack a reservoir; the full format needs more memory.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Format {
        /// A reservoir takes 16 bytes for direct and 32 for indirect light: it stores the index of the triangle or light,
        /// and the point on it. Position, normal, material and emission at the point are read from the scene.
        #[default]
        Compact,
        /// A reservoir takes 44 bytes for direct and 60 for indirect light. It stores the content of the compact format, and
        /// additionally, for direct light, position, normal and emission at the point on the light. For indirect light it
        /// additionally stores position, normals and material index at the second vertex of the path.
        Full,
    }
}

crate::gpu_enum! {
    /// The order of pixels in the buffers of resampling with one entry per pixel; the setting `reservoirs.order` selects it.
    /// It changes the locality of memory access, never the picture.
    pub enum PixelOrder {
        /// Pixels are stored row by row from the top, each row from left to right.
        #[default]
        Row,
        /// Pixels are stored column by column from the left, each column from top to bottom.
        Column,
        /// Pixels are stored tile by tile, and row by row within each tile. Tiles are squares, whose side in pixels is
        /// [`Specialisation::swizzle`](crate::Specialisation::swizzle).
        Swizzle,
    }
}

/// The GLSL text of all enumerations of this file: for each variant one line `const uint ENUMERATION_VARIANT = INDEXu;`,
/// where the index counts the variants from 0.
pub fn glsl() -> String {
    [
        Heuristic::glsl(),
        CameraModel::glsl(),
        HashGrid::glsl(),
        WorldReservoirs::glsl(),
        Mis::glsl(),
        Visibility::glsl(),
        Format::glsl(),
        PixelOrder::glsl(),
    ]
    .concat()
}

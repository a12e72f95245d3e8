//! Enumerations that settings and shaders share. Each is declared once; its variants are `uint` constants in GLSL.

crate::gpu_enum! {
    /// The MIS heuristic that weighs light samples against hits of BSDF rays in path tracing. It changes the noise, not the
    /// mean.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Heuristic {
        /// Weights in proportion to the densities: the noise is close to the minimum in every scene.
        #[default]
        Balance,
        /// Weights in proportion to the squared densities: less noise where one of the two techniques is much better than
        /// the other.
        Power,
    }
}

crate::gpu_enum! {
    /// The MIS weights with which a merge weighs the reservoirs that could have drawn a sample.
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
        /// Pairwise weights with a minimum weight for the pixel's canonical sample: unbiased, and with less noise where
        /// neighbours have poor samples.
        #[default]
        Defensive,
    }
}

crate::gpu_enum! {
    /// The source of the surface points that fill the hash grid, a light sampler which keeps reservoirs of direct light in
    /// cells of space.
    pub enum HashGrid {
        /// There is no hash grid: pixels draw their light samples by another light sampler.
        #[default]
        None,
        /// One random pixel of each block of 4 × 4 pixels, selected again in every frame: unbiased.
        Pixels,
        /// Points on all surfaces of the scene, from a list that fills the grid once, in the first frame. This is the
        /// published form of the method; it is biased.
        Points,
    }
}

crate::gpu_enum! {
    /// The way in which vertices of indirect paths reuse light samples of vertices of the previous frame in the same cell of
    /// space.
    pub enum WorldReservoirs {
        /// Vertices reuse no samples: each uses only the light samples that it draws.
        #[default]
        None,
        /// Vertices merge reservoirs with defensive weights, for which each reservoir stores its own shading point.
        Unbiased,
        /// Vertices weigh reservoirs by confidence alone. This is the published form of the method; it is biased.
        Published,
    }
}

crate::gpu_enum! {
    /// The step of resampling at which shadow rays test samples. It decides on bias, noise and the number of rays.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Visibility {
        /// No test: shadows are missing. Biased, for comparisons only.
        None,
        /// A test only where the selected sample is shaded, with one ray. For direct light it is unbiased, noisy in shadows,
        /// and without BSDF samples. Paths of indirect light are traced, so for them `final` means `initial`.
        Final,
        /// Tests of the selected initial candidate, and again where the selected sample is shaded. Biased: the picture is
        /// too dark.
        Initial,
        /// A test in every target function: one ray per target with `mis=balance`, two rays for a pairwise merge. Unbiased.
        #[default]
        Weights,
    }
}

crate::gpu_enum! {
    /// The contents of a reservoir in memory: the compact format reads more from the scene, the full one needs more memory.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Format {
        /// 16 bytes for direct and 32 for indirect light: the index of the triangle or light, and the point on it; position,
        /// normal, material and emission are read from the scene.
        #[default]
        Compact,
        /// 44 bytes for direct and 60 for indirect light: the compact words, and also position, normal and emission of the
        /// point on the light, or position, normals and material index of the second vertex.
        Full,
    }
}

crate::gpu_enum! {
    /// The order in which pixels follow each other in buffers with one entry per pixel; the setting `reservoirs.order`
    /// selects it. It changes the locality of memory access, never the picture.
    pub enum PixelOrder {
        /// Row by row from the top, each row from left to right.
        #[default]
        Row,
        /// Column by column from the left, each column from the top.
        Column,
        /// In square tiles, row by row within a tile; [`Specialisation::swizzle`](crate::Specialisation::swizzle) is their
        /// side.
        Swizzle,
    }
}

/// The GLSL text of all enumerations: one line `const uint ENUMERATION_VARIANT = INDEXu;` per variant.
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

//! Choices in settings and shaders: each enumeration is declared once for both.

crate::gpu_enum! {
    /// The MIS heuristic of next-event estimation and BSDF sampling.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Heuristic {
        /// In proportion to the densities: close to the optimum everywhere.
        #[default]
        Balance,
        /// In proportion to the squared densities: less noise where one technique is much better than the other.
        Power,
    }
}

crate::gpu_enum! {
    /// The MIS weights of a merge.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Mis {
        /// By confidence alone: cheapest; biased where a neighbour cannot draw samples that the pixel needs.
        Constant,
        /// The balance heuristic over all: unbiased, least noise; the cost grows with the square of the neighbours.
        Balance,
        /// The balance heuristic between the pixel and one neighbour at a time: unbiased, cheaper.
        Pairwise,
        /// Pairwise, with a minimum weight for the pixel's canonical sample: unbiased, robust against bad neighbours.
        #[default]
        Defensive,
    }
}

crate::gpu_enum! {
    /// The surfaces that fill the hash grid.
    pub enum HashGrid {
        /// No hash grid.
        #[default]
        None,
        /// Some pixels of the frame.
        Pixels,
        /// Points from a list.
        Points,
    }
}

crate::gpu_enum! {
    /// The way in which vertices of paths reuse light samples of other vertices.
    pub enum WorldReservoirs {
        /// No reuse.
        #[default]
        None,
        /// With weights that use each reservoir's shading point.
        Unbiased,
        /// Weighed by confidence alone.
        Published,
    }
}

crate::gpu_enum! {
    /// The step at which visibility is tested.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Visibility {
        /// No test: shadows are missing. Biased, for comparisons only.
        None,
        /// A test where the selected sample is shaded: one ray. For direct light unbiased, noisy in shadows, and without BSDF
        /// samples. Paths of indirect light are traced, so for them `final` means `initial`.
        Final,
        /// Tests of the selected initial candidate, and where the selected sample is shaded. Biased, dark.
        Initial,
        /// A test in every target function: one ray each with `mis=balance`, two for a pairwise merge. Unbiased.
        #[default]
        Weights,
    }
}

crate::gpu_enum! {
    /// The contents of a reservoir.
    #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Format {
        /// 16 bytes for direct and 32 for indirect light: the triangle or light, and the point on it; the rest is read from
        /// the scene.
        #[default]
        Compact,
        /// 44 and 60 bytes: points, their normals and materials, and for direct light also the emission of lights.
        Full,
    }
}

crate::gpu_enum! {
    /// The order of pixels in buffers; the setting `reservoirs.order` selects it.
    pub enum PixelOrder {
        /// Row by row.
        #[default]
        Row,
        /// Column by column.
        Column,
        /// In square tiles.
        Swizzle,
    }
}

/// The GLSL text of all enumerations.
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

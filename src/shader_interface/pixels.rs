//! The data of each pixel: its surface, its sums, and the contents of its reservoirs.

use glam::{DVec3, UVec2, UVec3, Vec2, Vec3};

crate::gpu_struct! {
    /// The contents of a pixel's reservoir, for debug AOVs.
    pub struct ReservoirAov {
        /// Unbiased contribution weight; 0 = empty. In squared scene units for indirect light and for points of triangles,
        /// in steradians for the environment, without a unit for punctual lights.
        pub weight: f32,
        /// Confidence, in units of one initial reservoir.
        pub confidence: f32,
        /// Frames since the sample was drawn.
        pub age: u32,
        /// The sample's light; NONE = empty, or a path of indirect light that does not reach one from its
        /// second vertex.
        pub light: u32,
        /// Neighbours that the frame's spatial passes found; 0 also if origins were not kept.
        pub neighbours: u32,
        /// The pixel that drew the sample, in that frame; −1 = empty, or origins were not kept.
        pub source: Vec2,
        /// The ratio of the sample's solid angle seen from here to that seen from its origin: the product of the
        /// Jacobians, by solid angle, of all its shifts; 0 = empty, or origins were not kept.
        pub jacobian: f32,
    }
}

crate::gpu_struct! {
    /// A pixel's primary surface, packed for later passes and the next frame.
    pub struct SampleData {
        /// Distance along the primary ray to just before the surface.
        pub depth: f32,
        /// Geometric and shading normal (22 + 22 bits each, octahedral) and the exponent of the ray offset (8).
        pub packed_normals: UVec3,
        /// Index of the material.
        pub material: u32,
        /// Index of the instance in the scene; NONE = no surface.
        pub instance: u32,
        /// Base colour, metalness and roughness where textures or vertex colours decide them.
        pub packed_material: UVec2,
    }
}

crate::gpu_struct! {
    /// Sums over a pixel's samples, each as an unevaluated pair high + low.
    pub struct PixelSums {
        /// Σ radiance, leading part.
        pub sum: Vec3,
        /// Σ radiance, rounding error of the leading part.
        pub sum_low: Vec3,
        /// Σ radiance², leading part.
        pub square: Vec3,
        /// Σ radiance², rounding error of the leading part.
        pub square_low: Vec3,
    }
}

crate::gpu_struct! {
    /// The pixels that a dispatch works on, row by row from the top.
    pub struct PixelRange {
        /// Index of the first pixel in the picture.
        pub first_pixel: u32,
        /// Number of pixels.
        pub pixels: u32,
    }
}

crate::gpu_struct! {
    /// The surface through a pixel's centre.
    pub struct PrimarySurface {
        /// Diffuse and specular albedo, by which a denoiser divides.
        pub albedo: Vec3,
        /// Unit shading normal, world space, towards the camera.
        pub normal: Vec3,
        /// Distance along the ray; 0 = miss.
        pub depth: f32,
        /// Index of the instance in the scene; NONE = miss.
        pub instance: u32,
        /// Previous minus current position in the image, in pixels, downwards. A miss is at infinite distance. 0 if the
        /// surface was behind the camera.
        pub motion: Vec2,
    }
}

crate::gpu_struct! {
    /// Constants of the pass that turns a part of a picture into display values.
    pub struct ToneMap {
        /// The distance from one pixel's radiance to the next, in words.
        pub stride: u32,
        /// Index of the first pixel in the picture.
        pub first_pixel: u32,
        /// Number of pixels.
        pub pixels: u32,
        /// Factor on radiance.
        pub scale: f32,
        /// 1: blue is in the least significant byte; 0: red is.
        pub begins_with_blue: u32,
    }
}

crate::gpu_struct! {
    /// The reservoir of direct light at a path vertex, for vertices that come close to it in the next frame.
    pub struct GpuWorldSample {
        /// Unbiased contribution weight; 0 = empty.
        pub weight: f32,
        /// Confidence and bits of the uv, as in reservoirs.
        pub history: u32,
        /// The kind and the index of the light.
        pub light: u32,
        /// The uv of the point on the light.
        pub uv: u32,
    }
}

impl PixelSums {
    /// Mean of `samples` ≥ 1 samples, for each channel.
    pub fn mean(&self, samples: u32) -> DVec3 {
        (self.sum.as_dvec3() + self.sum_low.as_dvec3()) / f64::from(samples)
    }

    /// Squared standard error of the mean, for each channel; `samples` ≥ 2.
    pub fn error_squared(&self, samples: u32) -> DVec3 {
        let n = f64::from(samples);
        let mean = self.mean(samples);
        let square = (self.square.as_dvec3() + self.square_low.as_dvec3()) / n;
        (square - mean * mean).max(DVec3::ZERO) / (n - 1.0)
    }
}

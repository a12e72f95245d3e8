//! The data of pixels in buffers: primary surfaces, sums of radiance, and the contents of reservoirs for debug AOVs.

use glam::{DVec3, UVec2, UVec3, Vec2, Vec3};

crate::gpu_struct! {
    /// The contents of a pixel's final reservoir in a frame, for debug AOVs.
    pub struct ReservoirAov {
        /// Unbiased contribution weight; 0 = empty. In squared lengths (scene units after `Renderer::reservoir_aovs`, device
        /// units in the buffer) for indirect light and for points of triangles; in steradians for the environment; without
        /// unit for punctual lights.
        pub weight: f32,
        /// Confidence: the number of initial reservoirs that the reservoir counts for.
        pub confidence: f32,
        /// Number of frames since the sample was drawn; 0 = in this frame.
        pub age: u32,
        /// Index, among lights of all kinds, of the light that the sample reaches; NONE for an empty reservoir, or for a
        /// path of indirect light that does not reach a light directly from its second vertex.
        pub light: u32,
        /// Number of neighbours that the spatial passes of this frame merged into the reservoir; 0 also if origins were not
        /// kept.
        pub neighbours: u32,
        /// Coordinates (x, y) of the pixel that drew the sample, in the picture of the frame in which it was drawn. −1 = the
        /// reservoir is empty, or origins were not kept.
        pub source: Vec2,
        /// Ratio of the solid angle of the sample, seen from this pixel's surface, to the solid angle seen from the surface
        /// that drew the sample: the product of the Jacobians of all its shifts. 0 = the reservoir is empty, or origins were
        /// not kept.
        pub jacobian: f32,
    }
}

crate::gpu_struct! {
    /// The primary surface of a pixel in 32 bytes. Later passes and the next frame restore the shading point from it.
    pub struct SampleData {
        /// Distance from the camera to the surface along the unit primary ray, in the device's unit of length.
        pub depth: f32,
        /// Geometric and shading normal, in octahedral coordinates of 22 bits each, and 8 bits with the exponent of the
        /// distance by which rays begin off the surface.
        pub packed_normals: UVec3,
        /// Index of the material in the buffer `materials`.
        pub material: u32,
        /// Index of the instance in the scene; NONE = the pixel shows no surface.
        pub instance: u32,
        /// Base colour (3 × 12 bits, as square roots), metalness (12 bits) and roughness (15 bits) where textures or vertex
        /// colours decide them; the highest bit is set if the base colour differs from that of the material. 0 in scenes
        /// without textures and colours.
        pub packed_material: UVec2,
    }
}

crate::gpu_struct! {
    /// Sums of radiance and of squared radiance over the samples of a pixel, RGB, in device units. Each sum is an
    /// unevaluated pair of a leading and a low part, so that the rounding error of f32 does not grow with the number of
    /// samples.
    pub struct PixelSums {
        /// Sum of radiance, leading part.
        pub sum: Vec3,
        /// Sum of radiance, rounding error of the leading part.
        pub sum_low: Vec3,
        /// Sum of squared radiance, leading part.
        pub square: Vec3,
        /// Sum of squared radiance, rounding error of the leading part.
        pub square_low: Vec3,
    }
}

crate::gpu_struct! {
    /// The pixels that a dispatch of the pass `accumulate` works on: consecutive pixels of the picture, row by row from the
    /// top.
    pub struct PixelRange {
        /// Index in the picture of the first pixel.
        pub first_pixel: u32,
        /// Number of pixels.
        pub pixels: u32,
    }
}

crate::gpu_struct! {
    /// The surface that the camera sees through the centre of a pixel, for AOVs and denoisers.
    pub struct PrimarySurface {
        /// Sum of diffuse and specular albedo, RGB, by which a denoiser divides radiance; 0 = miss.
        pub albedo: Vec3,
        /// Unit shading normal in world space, on the side of the camera; 0 = miss.
        pub normal: Vec3,
        /// Distance from the camera along the ray; 0 = miss. In scene units after `Renderer::primary_surfaces`, in device
        /// units in the buffer.
        pub depth: f32,
        /// Index of the instance in the scene; NONE = miss.
        pub instance: u32,
        /// Previous minus current position of the surface point in the picture, in pixels, to the right and down. A miss is
        /// treated as a point at infinite distance. 0 if the point was behind the camera.
        pub motion: Vec2,
    }
}

crate::gpu_struct! {
    /// Push constants of the pass `tone_map`, which turns one part of a picture into 8-bit sRGB values for displays.
    pub struct ToneMap {
        /// Distance from the radiance of one pixel to that of the next one, in 32-bit words of the radiance buffer.
        pub stride: u32,
        /// Index in the picture of the first pixel of the part.
        pub first_pixel: u32,
        /// Number of pixels of the part.
        pub pixels: u32,
        /// Factor of radiance before the tone curve: exposure, divided by the number of samples that were added up.
        pub scale: f32,
        /// 1: blue is in the least significant byte of a display word; 0: red is.
        pub begins_with_blue: u32,
    }
}

crate::gpu_struct! {
    /// The light sample of a world reservoir: a reservoir of direct light at a path vertex, which vertices near it merge in
    /// the next frame.
    pub struct GpuWorldSample {
        /// Unbiased contribution weight, an estimate of one over the density of the sample (per area, per solid angle or
        /// discrete); 0 = empty.
        pub weight: f32,
        /// Confidence in bits 0 to 13. Bits 24 to 31 have the upper 8 of the 40 bits of the point on the light, for which
        /// `uv` has no space.
        pub history: u32,
        /// Kind of the light (`LIGHT_…`, from bit `LIGHT_KIND_SHIFT` on), and below it its index: among lights of its kind
        /// or, for the environment, of the texel.
        pub light: u32,
        /// Lower 32 of the 40 bits of the point on the light, 20 bits per coordinate: barycentric weights of the second and
        /// third corner, or the position within the texel.
        pub uv: u32,
    }
}

impl PixelSums {
    /// The mean radiance of the pixel, RGB in device units, of `samples` ≥ 1 samples.
    pub fn mean(&self, samples: u32) -> DVec3 {
        (self.sum.as_dvec3() + self.sum_low.as_dvec3()) / f64::from(samples)
    }

    /// The squared standard error of the mean, for each channel, of `samples` ≥ 2 samples; 0 where rounding makes it
    /// negative.
    pub fn error_squared(&self, samples: u32) -> DVec3 {
        let n = f64::from(samples);
        let mean = self.mean(samples);
        let square = (self.square.as_dvec3() + self.square_low.as_dvec3()) / n;
        (square - mean * mean).max(DVec3::ZERO) / (n - 1.0)
    }
}

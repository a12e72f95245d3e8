//! The data that shaders store per pixel or per path vertex: primary surfaces, sums of radiance, light samples of world
//! reservoirs, and the contents of reservoirs for debug AOVs.

use glam::{DVec3, UVec2, UVec3, Vec2, Vec3};

crate::gpu_struct! {
    /// The contents of a pixel's reservoir after all merges of a frame, for debug AOVs (additional pictures that show the
    /// data of resampling).
    pub struct ReservoirAov {
        /// Unbiased contribution weight, an estimate of one over the density of the sample; 0 = the reservoir is empty. For
        /// indirect light and for points of triangles it is an area (scene units after `Renderer::reservoir_aovs`, device
        /// units in the buffer), for the environment a solid angle in steradians, and for punctual lights a number without
        /// unit.
        pub weight: f32,
        /// Confidence of the reservoir, which is its weight in a merge: a reservoir with confidence n counts as much as n
        /// initial reservoirs.
        pub confidence: f32,
        /// Number of frames since the reservoir's sample was drawn; 0 = it was drawn in this frame.
        pub age: u32,
        /// Index, among lights of all kinds, of the light that the sample reaches. NONE for an empty reservoir, and for a
        /// path of indirect light that does not go from its second vertex directly to a light.
        pub light: u32,
        /// Number of neighbours that the spatial passes of this frame merged into the pixel's reservoir. It is always 0 if
        /// reservoirs do not store origins (the pixel that drew each sample).
        pub neighbours: u32,
        /// Coordinates (x, y) of the pixel that drew the sample, in the picture of the frame in which the sample was drawn.
        /// (−1, −1) if the reservoir is empty, or if reservoirs do not store origins.
        pub source: Vec2,
        /// Solid angle of one unit of area at the sample as seen from this pixel's surface, divided by the same as seen from
        /// the surface that drew the sample. No weight contains this ratio, because samples are measured in area; a value far
        /// from 1 shows that the two surfaces see the sample very differently. 0 if the reservoir is empty, or if
        /// reservoirs do not store origins.
        pub jacobian: f32,
    }
}

crate::gpu_struct! {
    /// The primary surface of a pixel, which is the surface that the camera sees there, packed into 32 bytes. Later passes
    /// of the frame and the next frame compute the shading point from it.
    pub struct SampleData {
        /// Distance from the camera to the surface along the primary ray, in the device's unit of length.
        /// Shaders compute the position of the surface from it.
        pub depth: f32,
        /// Geometric and shading normal in world space, each as two octahedral coordinates of 22 bits. The remaining 8 bits
        /// are the exponent of the distance from the surface at which new rays begin, so that they do not hit the surface
        /// itself.
        pub packed_normals: UVec3,
        /// Index of the surface's material in the buffer `materials`, from which shaders read the BSDF of the
        /// surface. If surfaces are named (`Specialisation::surfaces_named`), it is the index of the surface's triangle in its
        /// mesh instead, in the order in which the device stores the mesh.
        pub material_or_primitive: u32,
        /// Index in the scene of the instance to which the surface belongs; NONE = the pixel shows no surface. If surfaces are
        /// named, it is the index in the buffer `instances`.
        pub instance: u32,
        /// Base colour (3 × 12 bits, as square roots), metalness (12 bits) and roughness (15 bits) at this point, with
        /// textures and vertex colours applied. The highest bit is set if a texture or vertex colours change the base
        /// colour. In scenes without textures and vertex colours all bits are 0, and shaders read the three values from the
        /// material in the buffer `materials`. A material with specular textures has fewer bits for each of them and, in the
        /// remaining bits, the factors of these textures. If surfaces are named, the two words are instead the barycentric
        /// weights of the second and the third corner of the triangle, as f32 in [0, 1].
        pub variation_or_weights: UVec2,
    }
}

crate::gpu_struct! {
    /// The sum of the radiance of a pixel's samples and the sum of their squared radiance, RGB, in the device's unit of
    /// radiance and in its square. The pixel's mean and its standard error are computed from them. Each sum is stored as two
    /// floats, the rounded sum and its rounding error, so that the error of f32 does not grow with the number of samples.
    pub struct PixelSums {
        /// Sum of the radiance of all samples of the pixel, RGB, rounded to f32, in the device's unit of radiance.
        pub sum: Vec3,
        /// Rounding error of `sum`: the exact sum is close to `sum` + `sum_low`.
        pub sum_low: Vec3,
        /// Sum of the squared radiance of all samples of the pixel, RGB, rounded to f32, in the square of the device's unit
        /// of radiance. The standard error of the pixel's mean is computed from it.
        pub square: Vec3,
        /// Rounding error of `square`: the exact sum of squares is close to `square` + `square_low`.
        pub square_low: Vec3,
    }
}

crate::gpu_struct! {
    /// Push constants of the pass `accumulate`, which adds the radiance of a frame to the sums of each pixel. They select
    /// consecutive pixels of the picture, in the order row by row from the top, because one buffer of sums may be too small
    /// for the whole picture.
    pub struct PixelRange {
        /// Index in the picture of the first pixel whose radiance the dispatch adds, counted row by row from the top. Its
        /// sums are the first entry of the buffer of sums.
        pub first_pixel: u32,
        /// Number of consecutive pixels whose radiance the dispatch adds, beginning with `first_pixel`.
        pub pixels: u32,
    }
}

crate::gpu_struct! {
    /// The surface that the camera sees through the centre of a pixel, not packed, for AOVs (additional pictures) and
    /// denoisers. All fields but `motion` have special values for a miss, where the pixel shows no surface.
    pub struct PrimarySurface {
        /// Fraction of light that the surface reflects, RGB: the sum of diffuse and specular albedo. A denoiser divides
        /// radiance by it, so that textures are not blurred. (0, 0, 0) for a miss.
        pub albedo: Vec3,
        /// Unit shading normal in world space, on the side of the surface that the camera sees; (0, 0, 0) for a miss.
        pub normal: Vec3,
        /// Distance from the camera to the surface along the ray; 0 = miss. It is in scene units in the result of
        /// `Renderer::primary_surfaces`, and in the device's unit of length in the buffer.
        pub depth: f32,
        /// Index in the scene of the instance that the camera sees in the pixel, for the AOV `instance`; NONE
        /// = miss.
        pub instance: u32,
        /// Motion vector in pixels, to the right and down: the position of the surface point in the previous picture minus
        /// that in the current picture. With it, a denoiser finds the same point in the previous picture. A miss is treated
        /// as a point at infinite distance. 0 if the point is behind the camera of either frame.
        pub motion: Vec2,
    }
}

crate::gpu_struct! {
    /// Push constants of the pass `tone_map`. It converts the radiance of one part of a picture, which is a range of
    /// consecutive pixels, to 8-bit sRGB values for a display.
    pub struct ToneMap {
        /// Distance in the buffer of radiance from one pixel to the next one, in 32-bit words.
        pub stride: u32,
        /// Index in the picture of the first pixel that the dispatch converts, counted row by row from the top. The buffer
        /// of radiance begins with this pixel.
        pub first_pixel: u32,
        /// Number of consecutive pixels that the dispatch converts, beginning with `first_pixel`.
        pub pixels: u32,
        /// Factor by which the values in the buffer are multiplied before the tone curve: the exposure factor times the
        /// device's unit of radiance, divided by the number of samples whose radiance the buffer sums.
        pub scale: f32,
        /// 1: blue is in the least significant byte of the 32-bit word of a pixel; 0: red is. Displays differ in this order.
        pub begins_with_blue: u32,
    }
}

crate::gpu_struct! {
    /// The light sample that a path vertex stores in a world reservoir. World reservoirs are reservoirs of direct light in
    /// cells of space. In the next frame, path vertices in the same cell merge this sample with their own light sample, so
    /// that their noise is lower.
    pub struct GpuWorldSample {
        /// Unbiased contribution weight, an estimate of one over the density of the sample. The density is per area for
        /// triangles, per solid angle for the environment, and a probability for punctual lights. 0 = the reservoir is
        /// empty.
        pub weight: f32,
        /// Bits 0 to 13: the confidence of the reservoir. Bits 14 to 23 are unused. Bits 24 to 31: the upper 8 of the 40
        /// bits that state the point on the light; `uv` contains the other 32.
        pub history: u32,
        /// The light to which the sample belongs. The bits from `LIGHT_KIND_SHIFT` on are its kind (`LIGHT_…`). The bits
        /// below them are its index among the lights of this kind or, for the environment, the index of the texel.
        pub light: u32,
        /// Lower 32 of the 40 bits of the point on the light, 20 bits per coordinate. The two coordinates are the
        /// barycentric weights of the second and the third corner or, for the environment, the position within the texel.
        pub uv: u32,
    }
}

impl PixelSums {
    /// The mean radiance of the pixel, RGB, in the device's unit of radiance. `samples` is the number of samples in the
    /// sums, at least 1.
    pub fn mean(&self, samples: u32) -> DVec3 {
        (self.sum.as_dvec3() + self.sum_low.as_dvec3()) / f64::from(samples)
    }

    /// The square of the standard error of the pixel's mean radiance, for each RGB channel, in the square of the device's
    /// unit of radiance. `samples` is the number of samples in the sums, at least 2. 0 where rounding would make the
    /// variance negative.
    pub fn error_squared(&self, samples: u32) -> DVec3 {
        let n = f64::from(samples);
        let mean = self.mean(samples);
        let square = (self.square.as_dvec3() + self.square_low.as_dvec3()) / n;
        (square - mean * mean).max(DVec3::ZERO) / (n - 1.0)
    }
}

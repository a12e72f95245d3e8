//! The properties, limits and abilities of a physical device, queried once.

use ash::{ext, khr, vk};
use std::ffi::CStr;

/// Size in bytes of a texel in a buffer that shaders read through a texel view: four `uint`s. Sizes of
/// buffers are rounded up to a multiple of this size, so that the last words can be read as a texel.
pub(super) const TEXEL_SIZE: u64 = 16;

/// The driver of a device, as far as it needs special treatment, such as access to the buffers of a scene by
/// bindings instead of by address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverKind {
    /// The device runs on Mesa's Vulkan driver for the CPU, llvmpipe (also called lavapipe). Before Mesa 25, the driver may
    /// end the loops of an invocation after a number of iterations.
    Llvmpipe {
        /// Major version of Mesa, which decides whether the driver limits loop iterations (before 25). It is 0 if the driver
        /// does not report it; the driver then counts as one with the limit.
        mesa: u32,
    },
    /// The device runs on SwiftShader, Google's Vulkan driver for the CPU. It is slower with buffer addresses than with
    /// bindings.
    SwiftShader,
    /// The device runs on any other driver, which needs no special treatment.
    Other,
}

impl DriverKind {
    fn new(id: vk::DriverId, info: &str) -> Self {
        match id {
            // The version number is 1 in every release, so the version is read from the text.
            vk::DriverId::MESA_LLVMPIPE => Self::Llvmpipe {
                mesa: info
                    .strip_prefix("Mesa ")
                    .and_then(|version| version.split('.').next()?.parse().ok())
                    .unwrap_or(0),
            },
            vk::DriverId::GOOGLE_SWIFTSHADER => Self::SwiftShader,
            _ => Self::Other,
        }
    }

    /// The total number of loop iterations after which the driver ends all loops of an invocation; `None` for a driver
    /// without such a limit.
    ///
    /// Mesa 22.3.6 counts the iterations of all loops of an invocation, inner and outer, and ends the loops after 65,535
    /// (`LP_MAX_TGSI_LOOP_ITERATIONS`). Mesa 25.0.7 has no limit. `tests/drivers.rs` checks this. Versions between these two
    /// were not tested, and count as limited.
    fn loop_turns(self) -> Option<u32> {
        matches!(self, Self::Llvmpipe { mesa } if mesa < 25).then_some(65_535)
    }
}

/// Properties, limits and abilities of a physical device. From them, Headwater chooses the device, its features, and the
/// shader variant.
#[derive(Clone, Debug, serde::Serialize)]
pub struct DeviceInfo {
    /// Index in the driver's list of devices, counted from 0; `--device` accepts it.
    pub index: usize,
    /// Name of the device as the driver reports it; `--device` accepts a part of it.
    pub name: String,
    /// Kind of the device: `discrete`, `integrated`, `virtual`, `cpu` or `other`. Without `--device`, the first kind in this
    /// order is preferred.
    pub kind: &'static str,
    /// Name and version of the driver in one text, such as `llvmpipe Mesa 25.0.7`.
    pub driver: String,
    /// Vulkan version of the device as `major.minor.patch`. Headwater cannot use a device with a version below 1.2.
    pub vulkan: String,
    /// True if compute shaders can trace rays in acceleration structures by ray queries, as the tracer `ray-query` does.
    pub ray_query: bool,
    /// True if the device can give buffers addresses. In variants that use them, shaders access a buffer by its address
    /// without a binding, so that the limit on the size of a bound buffer does not apply.
    pub buffer_addresses: bool,
    /// True if buffers can get the same addresses again when a capture is replayed. If it is false, captured frames use no
    /// addresses.
    pub address_replay: bool,
    /// True if the index into an array of sampled images may differ between the invocations of a subgroup (descriptor
    /// indexing). Shaders that sample textures from images need this.
    pub image_arrays: bool,
    /// True if the device has swapchains (`VK_KHR_swapchain`), by which pictures are presented to capture tools.
    /// Presentation also needs headless surfaces of the instance, see [`Instance::presents`](super::Instance::presents).
    pub presentation: bool,
    /// True if submissions can mark the end of a frame (`VK_EXT_frame_boundary`), by which capture tools find frames.
    pub frame_boundary: bool,
    /// True if the driver can report statistics of its compiler about a shader, such as registers
    /// (`VK_KHR_pipeline_executable_properties`). `headwater statistics` needs such reports.
    pub executable_properties: bool,
    /// Number of invocations in a subgroup, which `headwater info` shows; 0 if the device has no Vulkan 1.2.
    pub subgroup_size: u32,
    /// Length of a timestamp tick in nanoseconds. It is 0 if the compute queue has no timestamps; passes then have no times.
    pub timestamp_period: f32,
    /// The maximum size in bytes of a buffer that is bound as a storage buffer. Larger buffers can only be read by address
    /// or as texels.
    pub max_storage_buffer_range: u64,
    /// The maximum number of storage buffers that one shader can bind. A pass whose shader binds more cannot be made.
    pub max_storage_buffers: u32,
    /// The maximum number of texels, of 16 bytes each, in a buffer that shaders read as texels. It limits the size of the
    /// data for which the shader variant chooses this kind of access, such as the nodes of trees.
    pub max_texels: u32,
    /// The maximum number of images that one pass can bind. On some devices, bound buffers count as images too, so 64 of
    /// these bindings are kept free for buffers, and a scene may have only as many images as remain. If it has more, all its
    /// textures are stored in one buffer instead of images.
    pub max_sampled_images: u32,
    /// The maximum width and height of an image, in texels. If a texture is larger, all textures of the scene are stored in
    /// one buffer instead of images, or the scene is refused if the user has requested images.
    pub max_image_side: u32,
    /// The maximum size of one buffer or image in bytes, which is the driver's limit for one allocation of memory. A scene
    /// that needs a larger buffer is refused.
    pub max_buffer_size: u64,
    /// Total size of the device-local memory in bytes, including memory that is in use. A scene whose buffers together need
    /// more is refused, and so is a picture whose sums of radiance, or whose AOVs of surfaces, need more by themselves. Other
    /// buffers are not compared with it: if all buffers together do not fit, an allocation fails.
    pub device_memory: u64,
    /// The total number of loop iterations after which the driver ends all loops of an invocation; `None` for a driver
    /// without such a limit. With a limit, a dispatch of the path tracer computes fewer samples, and each frame is checked
    /// for loops that were ended.
    pub loop_turns: Option<u32>,
    /// The driver, if it needs special treatment, for example because it is slower with buffer addresses than with bindings;
    /// otherwise [`DriverKind::Other`].
    #[serde(skip)]
    pub driver_kind: DriverKind,
    /// The reason why Headwater cannot use the device, such as `it has no compute queue`; `None` if Headwater can use it.
    pub unusable: Option<String>,
    #[serde(skip)]
    pub(super) raw: vk::PhysicalDevice,
    #[serde(skip)]
    pub(super) queue_family: u32,
}

impl DeviceInfo {
    /// True if the device is a software driver that computes on the CPU. On it, other shader variants and another order of
    /// the workgroups are faster than on a GPU.
    pub fn is_cpu(&self) -> bool {
        self.kind == "cpu"
    }

    /// The maximum size in bytes of a buffer that shaders read as texels of four `uint`s.
    pub fn max_texel_bytes(&self) -> u64 {
        TEXEL_SIZE * u64::from(self.max_texels)
    }

    /// The number of threads among which the driver splits a dispatch; 1 for GPUs. Each thread gets one
    /// contiguous range of workgroups, and all ranges have the same length (llvmpipe does so). From this
    /// number, shaders compute the pixels of a workgroup, so that each thread gets pixels from the whole
    /// image. Otherwise a thread with an easy part of the image would idle.
    pub fn interleave(&self) -> u32 {
        match std::thread::available_parallelism() {
            Ok(threads) if self.is_cpu() => threads.get() as u32,
            _ => 1,
        }
    }

    /// Queries the properties of the physical device `device`; `index` is its index in the driver's list of devices.
    pub(super) fn of(instance: &ash::Instance, index: usize, device: vk::PhysicalDevice) -> Self {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut maintenance3 = vk::PhysicalDeviceMaintenance3Properties::default();
        // SAFETY: plain queries on a device of this instance; the chains live through the calls.
        let (plain, families, memory) = unsafe {
            let plain = instance.get_physical_device_properties(device);
            if plain.api_version >= vk::API_VERSION_1_2 {
                let mut properties = vk::PhysicalDeviceProperties2::default()
                    .push_next(&mut driver)
                    .push_next(&mut subgroup)
                    .push_next(&mut maintenance3);
                instance.get_physical_device_properties2(device, &mut properties);
            }
            (
                plain,
                instance.get_physical_device_queue_family_properties(device),
                instance.get_physical_device_memory_properties(device),
            )
        };
        // SAFETY: plain query on a device of this instance.
        let extensions = unsafe { instance.enumerate_device_extension_properties(device) };
        let extensions = extensions.unwrap_or_default();
        let has = |name: &CStr| {
            extensions
                .iter()
                .any(|e| e.extension_name_as_c_str() == Ok(name))
        };
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut acceleration = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
        let mut ray_query = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
        let mut boundary = vk::PhysicalDeviceFrameBoundaryFeaturesEXT::default();
        let mut executable = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
        if plain.api_version >= vk::API_VERSION_1_2 {
            let mut features = vk::PhysicalDeviceFeatures2::default()
                .push_next(&mut vulkan12)
                .push_next(&mut acceleration)
                .push_next(&mut ray_query);
            // Structures that capture tools may not know are given to devices that know them.
            if has(ext::frame_boundary::NAME) {
                features = features.push_next(&mut boundary);
            }
            if has(khr::pipeline_executable_properties::NAME) {
                features = features.push_next(&mut executable);
            }
            // SAFETY: as above; unknown structures of the chain are left untouched.
            unsafe { instance.get_physical_device_features2(device, &mut features) };
        }
        let queue_family = families
            .iter()
            .position(|f| f.queue_flags.contains(vk::QueueFlags::COMPUTE));
        let unusable = if plain.api_version < vk::API_VERSION_1_2 {
            Some("it has no Vulkan 1.2".to_owned())
        } else if vulkan12.scalar_block_layout == 0 {
            Some("it lacks scalarBlockLayout".to_owned())
        } else if queue_family.is_none() {
            Some("it has no compute queue".to_owned())
        } else {
            None
        };
        let queue_family = queue_family.unwrap_or(0);
        let timestamps = families
            .get(queue_family)
            .is_some_and(|f| f.timestamp_valid_bits > 0);
        let text = |s: std::result::Result<&CStr, _>| -> String {
            s.map(|s| s.to_string_lossy().into_owned())
                .unwrap_or_default()
        };
        let driver_info = text(driver.driver_info_as_c_str());
        let driver_kind = DriverKind::new(driver.driver_id, &driver_info);
        Self {
            index,
            name: text(plain.device_name_as_c_str()),
            kind: match plain.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
                vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
                vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
                vk::PhysicalDeviceType::CPU => "cpu",
                _ => "other",
            },
            driver: format!("{} {}", text(driver.driver_name_as_c_str()), driver_info)
                .trim()
                .to_owned(),
            vulkan: format!(
                "{}.{}.{}",
                vk::api_version_major(plain.api_version),
                vk::api_version_minor(plain.api_version),
                vk::api_version_patch(plain.api_version)
            ),
            ray_query: acceleration.acceleration_structure != 0
                && ray_query.ray_query != 0
                && vulkan12.buffer_device_address != 0
                && has(khr::acceleration_structure::NAME)
                && has(khr::ray_query::NAME)
                && has(khr::deferred_host_operations::NAME),
            buffer_addresses: vulkan12.buffer_device_address != 0,
            address_replay: vulkan12.buffer_device_address_capture_replay != 0,
            image_arrays: vulkan12.runtime_descriptor_array != 0
                && vulkan12.shader_sampled_image_array_non_uniform_indexing != 0,
            presentation: has(khr::swapchain::NAME),
            frame_boundary: has(ext::frame_boundary::NAME) && boundary.frame_boundary != 0,
            executable_properties: has(khr::pipeline_executable_properties::NAME)
                && executable.pipeline_executable_info != 0,
            subgroup_size: subgroup.subgroup_size,
            timestamp_period: if timestamps {
                plain.limits.timestamp_period
            } else {
                0.0
            },
            max_storage_buffer_range: u64::from(plain.limits.max_storage_buffer_range),
            max_storage_buffers: (plain.limits.max_per_stage_descriptor_storage_buffers)
                .min(plain.limits.max_descriptor_set_storage_buffers),
            max_texels: plain.limits.max_texel_buffer_elements,
            max_sampled_images: (plain.limits.max_per_stage_descriptor_sampled_images)
                .min(plain.limits.max_descriptor_set_sampled_images)
                .min(plain.limits.max_per_stage_resources),
            max_image_side: plain.limits.max_image_dimension2_d,
            max_buffer_size: maintenance3.max_memory_allocation_size,
            device_memory: memory.memory_heaps[..memory.memory_heap_count as usize]
                .iter()
                .filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
                .map(|heap| heap.size)
                .sum(),
            loop_turns: driver_kind.loop_turns(),
            driver_kind,
            unusable,
            raw: device,
            queue_family: queue_family as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mesas_version_is_read_from_its_text() {
        let mesa = |info| DriverKind::new(vk::DriverId::MESA_LLVMPIPE, info);
        for (info, version, turns) in [
            ("Mesa 22.3.6 (LLVM 15.0.6)", 22, Some(65_535)),
            ("Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)", 25, None),
            ("Mesa 26.1.0-devel (git-0123456789)", 26, None),
            ("unheard of", 0, Some(65_535)),
        ] {
            assert_eq!(mesa(info), DriverKind::Llvmpipe { mesa: version });
            assert_eq!(mesa(info).loop_turns(), turns, "{info}");
        }
        let radeon = DriverKind::new(vk::DriverId::MESA_RADV, "Mesa 22.3.6");
        assert_eq!(radeon, DriverKind::Other);
    }
}

//! The Vulkan instance, its devices, and the choice of one.

use super::messages::DebugUtils;
use crate::{Error, Result};
use ash::{ext, khr, vk};
use std::ffi::CStr;
use std::sync::{Arc, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Bytes of a texel, as buffers are read through texel views: four `uint`s.
pub(super) const TEXEL_SIZE: u64 = 16;

/// Guards the lists of instances and devices in the Vulkan loader. Versions up to 1.4 at least walk them without a lock
/// to find the device of an object that is given a name, and crash where another thread opens or closes a device.
static LISTS: RwLock<()> = RwLock::new(());

/// Permission to walk the loader's lists.
pub(super) fn walk_lists() -> RwLockReadGuard<'static, ()> {
    LISTS.read().unwrap_or_else(|e| e.into_inner())
}

/// Permission to change the loader's lists: to open or close an instance or a device.
pub(super) fn change_lists() -> RwLockWriteGuard<'static, ()> {
    LISTS.write().unwrap_or_else(|e| e.into_inner())
}

/// The loaded Vulkan library and its instance.
pub struct Instance {
    pub(super) raw: ash::Instance,
    pub(super) debug: Option<DebugUtils>,
    /// What makes headless surfaces, if that was asked for and is there.
    pub(super) surfaces: Option<Surfaces>,
    /// Keeps the Vulkan library loaded; dropped last.
    entry: ash::Entry,
}

/// The extensions by which surfaces without a window are made and queried.
pub(super) struct Surfaces {
    pub(super) surface: khr::surface::Instance,
    pub(super) headless: ext::headless_surface::Instance,
}

/// What an instance is wanted for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InstanceOptions {
    /// The Khronos layer with synchronization validation.
    pub validation: bool,
    /// Pictures are presented to a headless surface, where Vulkan has such surfaces.
    pub presentation: bool,
}

/// Drivers that need special treatment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverKind {
    /// Mesa's Vulkan on the CPU, also called lavapipe.
    Llvmpipe {
        /// Mesa's major version; 0 if the driver does not report it.
        mesa: u32,
    },
    /// Google's Vulkan on the CPU.
    SwiftShader,
    /// Any other driver.
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

    /// The driver's limit on loop iterations, if it has one: it ends all loops of an invocation after
    /// this many iterations in total.
    ///
    /// Mesa 22.3.6 counts the iterations of all loops, inner and outer, and ends them after 65,535
    /// (`LP_MAX_TGSI_LOOP_ITERATIONS`); Mesa 25.0.7 has no limit. `tests/drivers.rs` checks this.
    /// Versions between were not tested.
    fn loop_turns(self) -> Option<u32> {
        matches!(self, Self::Llvmpipe { mesa } if mesa < 25).then_some(65_535)
    }
}

/// Properties and abilities of a physical device.
#[derive(Clone, Debug, serde::Serialize)]
pub struct DeviceInfo {
    /// Index in the driver's list, as `--device` takes it.
    pub index: usize,
    /// The device's name.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    pub kind: &'static str,
    /// The driver's name and version.
    pub driver: String,
    /// Vulkan version, `major.minor.patch`.
    pub vulkan: String,
    /// Whether acceleration structures and ray queries work in compute shaders.
    pub ray_query: bool,
    /// Whether buffers have device addresses.
    pub buffer_addresses: bool,
    /// Whether buffers can have the same addresses when a capture is replayed.
    pub address_replay: bool,
    /// Whether each invocation can index arrays of sampled images by itself (descriptor indexing).
    pub image_arrays: bool,
    /// Whether pictures can be presented.
    pub presentation: bool,
    /// Whether submissions can say that they end a frame (`VK_EXT_frame_boundary`).
    pub frame_boundary: bool,
    /// Whether the driver tells what its compiler made of a shader (`VK_KHR_pipeline_executable_properties`).
    pub executable_properties: bool,
    /// Invocations in a subgroup.
    pub subgroup_size: u32,
    /// Nanoseconds per timestamp tick; 0 if compute queues have no timestamps.
    pub timestamp_period: f32,
    /// Largest range of one storage-buffer descriptor, in bytes.
    pub max_storage_buffer_range: u64,
    /// Largest number of texels in one buffer.
    pub max_texels: u32,
    /// Most images and buffers that one pass can bind where it samples images.
    pub max_sampled_images: u32,
    /// Longest side of an image, in texels.
    pub max_image_side: u32,
    /// Largest buffer, in bytes.
    pub max_buffer_size: u64,
    /// Memory on the device, in bytes.
    pub device_memory: u64,
    /// Loop iterations after which the driver ends all loops of an invocation, if it does.
    pub loop_turns: Option<u32>,
    /// The driver.
    #[serde(skip)]
    pub driver_kind: DriverKind,
    /// Why Headwater cannot use the device; none if it can.
    pub unusable: Option<String>,
    #[serde(skip)]
    pub(super) raw: vk::PhysicalDevice,
    #[serde(skip)]
    pub(super) queue_family: u32,
}

impl DeviceInfo {
    /// Whether the device computes on the CPU.
    pub fn is_cpu(&self) -> bool {
        self.kind == "cpu"
    }

    /// Largest buffer that can be read as texels of four `uint`s, in bytes.
    pub fn max_texel_bytes(&self) -> u64 {
        TEXEL_SIZE * u64::from(self.max_texels)
    }

    /// Number of threads among which the driver splits a dispatch into equal contiguous ranges of
    /// workgroups, as llvmpipe does; 1 for GPUs. Shaders interleave the image's parts by it, since a
    /// thread with an easy part of the image would idle.
    pub fn interleave(&self) -> u32 {
        match std::thread::available_parallelism() {
            Ok(threads) if self.is_cpu() => threads.get() as u32,
            _ => 1,
        }
    }
}

impl Instance {
    /// Loads Vulkan. `validation` turns on the Khronos layer with synchronization validation.
    ///
    /// # Errors
    /// Those of [`Self::with_options`].
    pub fn new(validation: bool) -> Result<Arc<Self>> {
        Self::with_options(InstanceOptions {
            validation,
            ..InstanceOptions::default()
        })
    }

    /// Loads Vulkan with the layers and extensions that are wanted.
    ///
    /// # Errors
    /// No Vulkan library, no instance, or no validation layer although it is wanted.
    pub fn with_options(options: InstanceOptions) -> Result<Arc<Self>> {
        let validation = options.validation;
        // SAFETY: loading runs the library's initialisers, which have no preconditions.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| {
            Error::failed(format!(
                "no Vulkan on this machine ({e}); install a driver and libvulkan1, or start through tools/run, which brings a software Vulkan"
            ))
        })?;
        let layer = c"VK_LAYER_KHRONOS_validation";
        // SAFETY: plain queries on a loaded entry.
        let (layers, extensions) = unsafe {
            (
                entry
                    .enumerate_instance_layer_properties()
                    .unwrap_or_default(),
                entry
                    .enumerate_instance_extension_properties(None)
                    .unwrap_or_default(),
            )
        };
        if validation && !layers.iter().any(|l| l.layer_name_as_c_str() == Ok(layer)) {
            return Err(Error::failed(
                "validation was asked for (HEADWATER_VALIDATION) but VK_LAYER_KHRONOS_validation is not installed; unset it, or start through tools/run or tools/test",
            ));
        }
        // The validation layer provides debug utilities itself.
        let has = |name: &CStr| {
            let mut names = extensions.iter().map(|e| e.extension_name_as_c_str());
            names.any(|own| own == Ok(name))
        };
        let has_debug = validation || has(ext::debug_utils::NAME);
        let mut extension_names = Vec::new();
        if has_debug {
            extension_names.push(ext::debug_utils::NAME.as_ptr());
        }
        let presents =
            options.presentation && has(khr::surface::NAME) && has(ext::headless_surface::NAME);
        if presents {
            let names = [khr::surface::NAME, ext::headless_surface::NAME];
            extension_names.extend(names.map(CStr::as_ptr));
        }
        let mut layer_names = Vec::new();
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let application = vk::ApplicationInfo::default()
            .application_name(c"headwater")
            .engine_name(c"headwater")
            .api_version(vk::API_VERSION_1_2);
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validation {
            layer_names.push(layer.as_ptr());
            extension_names.push(ext::validation_features::NAME.as_ptr());
            info = info.push_next(&mut features);
        }
        info = info
            .enabled_layer_names(&layer_names)
            .enabled_extension_names(&extension_names);
        let _changing = change_lists();
        // SAFETY: `info` and all it points to live through the call.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|e| {
            Error::failed(format!(
                "Vulkan is installed but gives no instance ({e}); check the driver with vulkaninfo, or start through tools/run"
            ))
        })?;
        let debug = if has_debug {
            Some(DebugUtils::new(&entry, &raw)?)
        } else {
            None
        };
        Ok(Arc::new(Self {
            surfaces: presents.then(|| Surfaces {
                surface: khr::surface::Instance::new(&entry, &raw),
                headless: ext::headless_surface::Instance::new(&entry, &raw),
            }),
            raw,
            debug,
            entry,
        }))
    }

    /// Every device, usable or not, in the driver's order.
    ///
    /// # Errors
    /// The driver cannot list its devices.
    pub fn devices(&self) -> Result<Vec<DeviceInfo>> {
        // SAFETY: plain query on a live instance.
        let devices = unsafe { self.raw.enumerate_physical_devices() }
            .map_err(|e| Error::failed(format!("Vulkan lists no devices ({e})")))?;
        Ok(devices
            .into_iter()
            .enumerate()
            .map(|(index, device)| self.describe(index, device))
            .collect())
    }

    /// Chooses a device; returns it with the reason. `wanted` is an index or a part of a name in
    /// upper or lower case; without it, discrete devices come before integrated, virtual and CPU.
    ///
    /// # Errors
    /// No usable device, or none that matches `wanted` (wrong input).
    pub fn choose(&self, wanted: Option<&str>) -> Result<(DeviceInfo, String)> {
        let devices = self.devices()?;
        let listed = || {
            devices
                .iter()
                .map(|d| format!("{} {}", d.index, d.name))
                .collect::<Vec<_>>()
                .join(", ")
        };
        if let Some(wanted) = wanted.filter(|w| !w.is_empty()) {
            // A name may consist of digits, so a number counts as an index only if it is in range.
            let by_index = wanted.parse::<usize>().ok().and_then(|i| devices.get(i));
            let named = |d: &&DeviceInfo| d.name.to_lowercase().contains(&wanted.to_lowercase());
            let by_name = || {
                let usable = |d: &&DeviceInfo| named(d) && d.unusable.is_none();
                devices
                    .iter()
                    .find(usable)
                    .or_else(|| devices.iter().find(named))
            };
            let device = by_index.or_else(by_name).ok_or_else(|| {
                Error::input(format!(
                    "no device '{wanted}'; there are: {}",
                    if devices.is_empty() {
                        "none".into()
                    } else {
                        listed()
                    }
                ))
            })?;
            return match &device.unusable {
                Some(reason) => Err(Error::input(format!(
                    "device '{}' cannot be used: {reason}",
                    device.name
                ))),
                None => Ok((device.clone(), format!("asked for as '{wanted}'"))),
            };
        }
        let rank = |d: &DeviceInfo| match d.kind {
            "discrete" => 0,
            "integrated" => 1,
            "virtual" => 2,
            "cpu" => 3,
            _ => 4,
        };
        devices
            .iter()
            .filter(|d| d.unusable.is_none())
            .min_by_key(|d| (rank(d), d.index))
            .map(|d| {
                let others = devices.len() - 1;
                let reason = if others == 0 {
                    "the only device".to_owned()
                } else {
                    format!("the first {} device among {}", d.kind, devices.len())
                };
                (d.clone(), reason)
            })
            .ok_or_else(|| {
                let reasons: Vec<String> = devices
                    .iter()
                    .filter_map(|d| Some(format!("{}: {}", d.name, d.unusable.as_ref()?)))
                    .collect();
                Error::failed(format!(
                    "no usable Vulkan device ({}); install a driver, or start through tools/run, which brings a software Vulkan",
                    if reasons.is_empty() { "none found".into() } else { reasons.join("; ") }
                ))
            })
    }

    /// The validation layers' messages so far, without the [allowed](super::messages::ALLOWED) ones.
    pub fn validation_messages(&self) -> Vec<String> {
        let debug = self.debug.as_ref();
        debug.map(DebugUtils::messages).unwrap_or_default()
    }

    /// Whether pictures can be presented on a device: the instance was made for it, and both are able to.
    pub fn presents(&self, device: &DeviceInfo) -> bool {
        self.surfaces.is_some() && device.presentation
    }

    /// The tools that have put themselves between Headwater and a device, such as the layer of GFXReconstruct, by the names
    /// that they give themselves; those of the validation layers are not among them.
    pub fn tools(&self, device: &DeviceInfo) -> Vec<String> {
        let name = c"vkGetPhysicalDeviceToolPropertiesEXT";
        // SAFETY: a plain query; the function that it finds has this type.
        let list = unsafe {
            let found = self
                .entry
                .get_instance_proc_addr(self.raw.handle(), name.as_ptr());
            let Some(found) = found else {
                return Vec::new();
            };
            std::mem::transmute::<
                unsafe extern "system" fn(),
                vk::PFN_vkGetPhysicalDeviceToolProperties,
            >(found)
        };
        let mut count = 0;
        // SAFETY: as Vulkan wants it: first the number of tools, then as many of them.
        let tools = unsafe {
            if list(device.raw, &mut count, std::ptr::null_mut()) != vk::Result::SUCCESS {
                return Vec::new();
            }
            let mut tools = vec![vk::PhysicalDeviceToolProperties::default(); count as usize];
            if list(device.raw, &mut count, tools.as_mut_ptr()) != vk::Result::SUCCESS {
                return Vec::new();
            }
            tools.truncate(count as usize);
            tools
        };
        (tools.iter())
            .filter(|tool| !tool.purposes.contains(vk::ToolPurposeFlags::VALIDATION))
            .filter_map(|tool| Some(tool.name_as_c_str().ok()?.to_string_lossy().into_owned()))
            .collect()
    }

    /// A device's extensions.
    pub(super) fn extensions(&self, device: vk::PhysicalDevice) -> Vec<vk::ExtensionProperties> {
        // SAFETY: plain query on a device of this instance.
        unsafe { self.raw.enumerate_device_extension_properties(device) }.unwrap_or_default()
    }

    fn describe(&self, index: usize, device: vk::PhysicalDevice) -> DeviceInfo {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut maintenance3 = vk::PhysicalDeviceMaintenance3Properties::default();
        // SAFETY: plain queries on a device of this instance; the chains live through the calls.
        let (plain, families, memory) = unsafe {
            let plain = self.raw.get_physical_device_properties(device);
            if plain.api_version >= vk::API_VERSION_1_2 {
                let mut properties = vk::PhysicalDeviceProperties2::default()
                    .push_next(&mut driver)
                    .push_next(&mut subgroup)
                    .push_next(&mut maintenance3);
                self.raw
                    .get_physical_device_properties2(device, &mut properties);
            }
            (
                plain,
                self.raw.get_physical_device_queue_family_properties(device),
                self.raw.get_physical_device_memory_properties(device),
            )
        };
        let extensions = self.extensions(device);
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
            unsafe {
                self.raw
                    .get_physical_device_features2(device, &mut features)
            };
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
        DeviceInfo {
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

impl Drop for Instance {
    fn drop(&mut self) {
        let _changing = change_lists();
        // SAFETY: every device keeps the instance alive, so none is left.
        unsafe {
            if let Some(debug) = &self.debug {
                debug.destroy();
            }
            self.raw.destroy_instance(None);
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

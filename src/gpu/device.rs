//! An open device (Vulkan's logical device): its queue and memory, and the names and labels that profilers and debuggers
//! show.

use super::device_info::DeviceInfo;
use super::instance::{Instance, change_lists, walk_lists};
use super::recorder::{Recorder, Submission};
use super::records::Records;
use crate::{Error, Result};
use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use gpu_allocator::{AllocationError, MemoryLocation};
use std::collections::VecDeque;
use std::ffi::CString;
use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Optional features with which a device is opened. A feature is enabled only if it is requested, because not every device
/// has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// Enables acceleration structures and ray queries in compute shaders, for the tracer `ray-query`. It includes
    /// `buffer_addresses`, because structures are built from addresses.
    pub ray_query: bool,
    /// Gives every buffer a device address, by which shaders access it without a binding, and so without the limits on the
    /// size and the number of bound buffers.
    pub buffer_addresses: bool,
    /// Enables arrays of sampled images whose index may differ between the invocations of a subgroup (descriptor indexing).
    /// Shaders that sample textures from images need it.
    pub image_arrays: bool,
    /// Enables presentation of pictures to a headless surface (a surface without a window), by which capture tools find
    /// frames. Submissions also mark the ends of frames, if the device has `VK_EXT_frame_boundary`.
    pub presentation: bool,
    /// Records statistics of the driver's compiler about each pipeline ([`CompilerReport`](super::CompilerReport)), which
    /// profiles and `headwater statistics` show.
    pub executable_properties: bool,
    /// Makes a device that only compiles pipelines: buffers have no memory and read as zeros, and no command runs. So the
    /// compiler of a driver can be used on a machine without the GPU of the driver. No Vulkan feature or extension is
    /// needed for this.
    pub compiles_only: bool,
    /// Allows the buffers that passes write to be hashed for regression tests ([`Device::hash_outputs`]). Every buffer
    /// begins with zeros, so that bytes that no pass writes do not change the hashes. The driver itself need not support
    /// anything for this.
    pub hashed_outputs: bool,
}

/// An open device with its queue and memory allocator. Buffers, passes and other objects that are made from a device keep it
/// open.
pub struct Device {
    /// Properties, limits and abilities of the physical device, from which features and shader variants are
    /// chosen.
    pub info: DeviceInfo,
    /// The features with which the device was opened; `buffer_addresses` is also true if `ray_query` is.
    pub features: Features,
    pub(super) raw: ash::Device,
    pub(super) queue: vk::Queue,
    pub(super) acceleration: Option<khr::acceleration_structure::Device>,
    pub(super) debug: Option<ext::debug_utils::Device>,
    pub(super) presentation: Option<khr::swapchain::Device>,
    pub(super) executables: Option<khr::pipeline_executable_properties::Device>,
    /// True if submissions mark the ends of frames for capture tools: presentation was requested, and the device has
    /// `VK_EXT_frame_boundary`.
    pub(super) ends_frames: bool,
    /// Minimum alignment, in bytes, of the address of scratch memory for builds of acceleration structures; at least 256.
    pub(super) scratch_alignment: u64,
    pub(super) allocator: ManuallyDrop<Mutex<Allocator>>,
    /// Lock that is held while the queue is used, because Vulkan allows only one thread at a time to use it.
    pub(super) queue_lock: Mutex<()>,
    /// Recorders (command buffers with fence and timestamps) that no recording uses, because their commands have finished.
    /// Later recordings reuse them.
    pub(super) idle: Mutex<Vec<Recorder>>,
    /// Submissions that no caller has waited for yet, the oldest first. Their commands may still run.
    pub(super) running: Mutex<VecDeque<Submission>>,
    /// Records of the work on the device since it was opened, such as compiled shaders and memory in use. Profiles and
    /// regression tests read them.
    pub records: Records,
    instance: Arc<Instance>,
}

impl Device {
    /// Switches on the hashing of outputs: from now on, each pass runs in a separate submission, and a hash
    /// of each buffer that the pass may write is stored. [`Records::take_outputs`] returns the hashes, which
    /// regression tests compare to find the first pass whose results differ.
    ///
    /// # Errors
    /// The device was opened without [`Features::hashed_outputs`].
    pub fn hash_outputs(&self) -> Result<()> {
        if !self.features.hashed_outputs {
            return Err(Error::failed(
                "outputs of passes were to be hashed on a device that was opened without that",
            ));
        }
        self.records.hash_outputs();
        Ok(())
    }

    /// Opens the physical device `info` with `features`.
    ///
    /// If the validation layers are loaded, the caller ensures that no other thread uses Vulkan while a device is opened or
    /// closed. The layers (1.3.239) keep their devices in a map without a lock. A change of the map while another thread
    /// searches it damages the heap.
    ///
    /// # Errors
    /// The device lacks one of the features, the driver cannot open it, its memory allocator cannot be made, or the host
    /// cannot map its memory.
    pub fn open(
        instance: &Arc<Instance>,
        info: DeviceInfo,
        features: Features,
    ) -> Result<Arc<Self>> {
        let addresses = features.buffer_addresses || features.ray_query;
        let wanted = [
            (
                features.ray_query && !info.ray_query,
                "has no ray query; use --tracer compute-bvh",
            ),
            (
                addresses && !info.buffer_addresses,
                "has no buffer addresses",
            ),
            (
                features.image_arrays && !info.image_arrays,
                "has no arrays of images",
            ),
            (
                features.presentation && !instance.presents(&info),
                "cannot present to a headless surface",
            ),
            (
                features.executable_properties && !info.executable_properties,
                "does not report what its compiler makes of shaders",
            ),
        ];
        if let Some((_, obstacle)) = wanted.iter().find(|(is_missing, _)| *is_missing) {
            return Err(Error::input(format!("device '{}' {obstacle}", info.name)));
        }
        let ends_frames = features.presentation && info.frame_boundary;
        let mut boundary =
            vk::PhysicalDeviceFrameBoundaryFeaturesEXT::default().frame_boundary(true);
        let mut executable = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default()
            .scalar_block_layout(true)
            .buffer_device_address(addresses)
            .runtime_descriptor_array(features.image_arrays)
            .shader_sampled_image_array_non_uniform_indexing(features.image_arrays);
        let mut acceleration = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default()
            .acceleration_structure(true);
        let mut ray_query = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
        let mut extensions = Vec::new();
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(info.queue_family)
            .queue_priorities(&priorities)];
        let mut create = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .push_next(&mut vulkan12);
        if features.ray_query {
            extensions.extend([
                khr::acceleration_structure::NAME.as_ptr(),
                khr::ray_query::NAME.as_ptr(),
                khr::deferred_host_operations::NAME.as_ptr(),
            ]);
            create = create
                .push_next(&mut acceleration)
                .push_next(&mut ray_query);
        }
        if features.presentation {
            extensions.push(khr::swapchain::NAME.as_ptr());
        }
        if ends_frames {
            extensions.push(ext::frame_boundary::NAME.as_ptr());
            create = create.push_next(&mut boundary);
        }
        if features.executable_properties {
            extensions.push(khr::pipeline_executable_properties::NAME.as_ptr());
            create = create.push_next(&mut executable);
        }
        create = create.enabled_extension_names(&extensions);
        let changing = change_lists();
        // SAFETY: the features and extensions were found on this device; `create` lives through
        // the call.
        let raw = unsafe { instance.raw.create_device(info.raw, &create, None) }
            .map_err(|e| Error::failed(format!("device '{}' does not open ({e})", info.name)))?;
        drop(changing);
        // SAFETY: the queue family and queue 0 were requested above.
        let queue = unsafe { raw.get_device_queue(info.queue_family, 0) };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: raw.clone(),
            physical_device: info.raw,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: addresses,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        });
        let allocator = match allocator {
            Ok(allocator) => allocator,
            Err(e) => {
                let _changing = change_lists();
                // SAFETY: nothing was made from the device yet.
                unsafe { raw.destroy_device(None) };
                return Err(Error::failed(format!("no memory allocator ({e})")));
            }
        };
        let mut limits = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
        if features.ray_query {
            let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
            // SAFETY: plain query; the chain lives through the call.
            unsafe {
                instance
                    .raw
                    .get_physical_device_properties2(info.raw, &mut properties);
            }
        }
        let device = Arc::new(Self {
            acceleration: features
                .ray_query
                .then(|| khr::acceleration_structure::Device::new(&instance.raw, &raw)),
            debug: instance
                .debug
                .as_ref()
                .map(|_| ext::debug_utils::Device::new(&instance.raw, &raw)),
            presentation: (features.presentation)
                .then(|| khr::swapchain::Device::new(&instance.raw, &raw)),
            executables: (features.executable_properties)
                .then(|| khr::pipeline_executable_properties::Device::new(&instance.raw, &raw)),
            ends_frames,
            scratch_alignment: u64::from(
                limits.min_acceleration_structure_scratch_offset_alignment,
            )
            .max(256),
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            queue_lock: Mutex::new(()),
            idle: Mutex::default(),
            running: Mutex::default(),
            records: Records::default(),
            info,
            features: Features {
                buffer_addresses: addresses,
                ..features
            },
            raw,
            queue,
            instance: instance.clone(),
        });
        if device.runs() {
            device.check_mapping()?;
        }
        Ok(device)
    }

    /// True if the device runs commands and its buffers have memory; false if it only compiles
    /// ([`Features::compiles_only`]).
    pub(super) const fn runs(&self) -> bool {
        !self.features.compiles_only
    }

    /// Checks that the host can map memory of the device. The check fails on a machine without the driver's GPU. Without the
    /// check, such a driver would crash when commands are recorded.
    ///
    /// # Errors
    /// The host cannot map the memory, or the device has none left for the check.
    fn check_mapping(&self) -> Result<()> {
        let wanted = AllocationCreateDesc {
            name: "a test of mapping",
            requirements: vk::MemoryRequirements {
                size: 256,
                alignment: 256,
                memory_type_bits: u32::MAX,
            },
            location: MemoryLocation::CpuToGpu,
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation = match self.lock_allocator()?.allocate(&wanted) {
            Ok(allocation) => Some(allocation),
            // Such a device may have no memory that the host could map.
            Err(AllocationError::NoCompatibleMemoryTypeFound) => None,
            Err(cause) => return Err(self.lacks(&wanted, wanted.requirements.size, &cause)),
        };
        let is_mapped = (allocation.as_ref()).is_some_and(|memory| memory.mapped_ptr().is_some());
        self.free(allocation);
        if is_mapped {
            return Ok(());
        }
        Err(Error::failed(format!(
            "the memory of device '{}' cannot be mapped, so nothing runs on it (a driver without its GPU?); 'headwater statistics' compiles for it, --device takes another",
            self.info.name
        )))
    }

    /// Messages of the validation layers since the Vulkan instance was made, the oldest first, about all devices of the
    /// instance. A test with a message fails. Empty if the validation layers are not loaded.
    pub fn validation_messages(&self) -> Vec<String> {
        self.instance.validation_messages()
    }

    /// Names of the tools that are active between Headwater and the device, such as capture layers; empty if there are none.
    /// A capture of frames (`--capture`) needs such a tool, or RenderDoc; see [`Instance::tools`].
    pub fn tools(&self) -> Vec<String> {
        self.instance.tools(&self.info)
    }

    /// The Vulkan instance from which the device was opened. Presentation needs it to make a headless
    /// surface.
    pub(super) fn instance(&self) -> &Instance {
        &self.instance
    }

    /// Opens a debug label with the text `name` in the queue, and ends it when the returned value is dropped. Capture tools
    /// and profilers show the label around all submissions between the call and the drop.
    pub fn label(self: &Arc<Self>, name: &str) -> Label {
        if let (Some(debug), Ok(name)) = (&self.debug, CString::new(name)) {
            let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
            let _lock = self.queue_lock.lock();
            // SAFETY: `Label` closes it.
            unsafe { debug.queue_begin_debug_utils_label(self.queue, &label) };
            return Label(Some(self.clone()));
        }
        Label(None)
    }

    /// Sets the name of a Vulkan object, which debugging tools and validation messages show. It has no effect without debug
    /// utilities.
    pub(super) fn name<T: vk::Handle>(&self, object: T, name: &str) {
        if let (Some(debug), Ok(name)) = (&self.debug, CString::new(name)) {
            let info = vk::DebugUtilsObjectNameInfoEXT::default()
                .object_handle(object)
                .object_name(&name);
            let _walking = walk_lists();
            // SAFETY: the object belongs to this device. A name is optional, so errors are ignored.
            let _ = unsafe { debug.set_debug_utils_object_name(&info) };
        }
    }

    /// Allocates memory for a buffer or an image as `wanted` describes it. `bytes`, the size of the buffer or image, is only
    /// for the error message.
    ///
    /// # Errors
    /// The device has too little free memory, or none of a suitable type.
    pub(super) fn allocate(
        &self,
        wanted: &AllocationCreateDesc<'_>,
        bytes: u64,
    ) -> Result<Allocation> {
        let allocated = self.lock_allocator()?.allocate(wanted);
        allocated.map_err(|cause| self.lacks(wanted, bytes, &cause))
    }

    fn lock_allocator(&self) -> Result<MutexGuard<'_, Allocator>> {
        let panicked = |_| Error::failed("the memory allocator panicked in another thread");
        self.allocator.lock().map_err(panicked)
    }

    /// The error for a failed allocation of `bytes` bytes. Its message has the name of the buffer or image from `wanted`,
    /// and the name of the device.
    fn lacks(
        &self,
        wanted: &AllocationCreateDesc<'_>,
        bytes: u64,
        cause: &AllocationError,
    ) -> Error {
        Error::failed(format!(
            "{} needs {bytes} bytes, which device '{}' does not have ({cause})",
            wanted.name, self.info.name
        ))
    }

    /// Frees the memory of a buffer or an image. Does nothing for `None`, which stands for an object without memory.
    pub(super) fn free(&self, allocation: Option<Allocation>) {
        if let (Some(allocation), Ok(mut allocator)) = (allocation, self.allocator.lock()) {
            let _ = allocator.free(allocation);
        }
    }

    /// The error for a failed Vulkan call. `what` completes the sentence "device … failed to …", and `cause` is the result
    /// that the call returned.
    pub(super) fn failure(&self, what: &str, cause: vk::Result) -> Error {
        Error::failed(format!(
            "device '{}' failed to {what} ({cause})",
            self.info.name
        ))
    }
}

/// A debug label around submissions, which capture tools and profilers show as one group with a name.
/// Dropping the value ends the label. Without debug utilities it is empty and has no effect.
pub struct Label(Option<Arc<Device>>);

impl Drop for Label {
    fn drop(&mut self) {
        if let Some(device) = &self.0
            && let Some(debug) = &device.debug
        {
            let _lock = device.queue_lock.lock();
            // SAFETY: [`Device::label`] has opened one.
            unsafe { debug.queue_end_debug_utils_label(device.queue) };
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let running = self
            .running
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        let running = std::mem::take(running);
        let idle = self.idle.get_mut();
        let idle = idle.unwrap_or_else(PoisonError::into_inner);
        // Without any recorder nothing was submitted. A driver without its GPU crashes where it waits.
        let has_submitted = !running.is_empty() || !idle.is_empty();
        // SAFETY: all objects made from the device keep it alive, so none is left; the allocator
        // frees its memory before the device is destroyed.
        unsafe {
            if has_submitted {
                let _ = self.raw.device_wait_idle();
            }
            for submission in running {
                submission.destroy(&self.raw);
            }
            for recorder in idle.drain(..) {
                recorder.destroy(&self.raw);
            }
            ManuallyDrop::drop(&mut self.allocator);
            let _changing = change_lists();
            self.raw.destroy_device(None);
        }
    }
}

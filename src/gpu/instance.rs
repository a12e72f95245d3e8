//! The Vulkan instance, the list of its physical devices, and the choice of one of them.

use super::device_info::DeviceInfo;
use super::messages::DebugUtils;
use crate::{Error, Result};
use ash::{ext, khr, vk};
use std::ffi::CStr;
use std::sync::{Arc, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Guards the lists of instances and devices inside the Vulkan loader. To give an object a name, loaders (at least up to
/// version 1.4) search these lists for the object's device without a lock. They crash if another thread opens or closes a
/// device meanwhile.
static LISTS: RwLock<()> = RwLock::new(());

/// Locks [`LISTS`] for reading. The caller holds the lock while it gives an object a name, because the Vulkan loader then
/// searches its lists of instances and devices. Several threads can hold the lock for reading at the same time, but
/// meanwhile none can open or close a device.
pub(super) fn walk_lists() -> RwLockReadGuard<'static, ()> {
    LISTS.read().unwrap_or_else(|e| e.into_inner())
}

/// Locks [`LISTS`] for writing. The caller holds the lock while it opens or closes an instance or a device, because the
/// Vulkan loader then changes its lists of instances and devices. No other thread can hold the lock at the same time.
pub(super) fn change_lists() -> RwLockWriteGuard<'static, ()> {
    LISTS.write().unwrap_or_else(|e| e.into_inner())
}

/// The loaded Vulkan library and an instance of it, from which devices are listed and opened.
pub struct Instance {
    pub(super) raw: ash::Instance,
    pub(super) debug: Option<DebugUtils>,
    /// Functions that make and query headless surfaces; `None` if presentation was not requested, or if Vulkan lacks the
    /// extensions for it.
    pub(super) surfaces: Option<Surfaces>,
    /// The loaded Vulkan library. It must stay loaded while the instance is used, so it is dropped last.
    entry: ash::Entry,
}

/// The loaded functions of `VK_KHR_surface` and `VK_EXT_headless_surface`, by which surfaces without a window are made and
/// queried. Pictures are presented to such a surface, so that capture tools see where frames end.
pub(super) struct Surfaces {
    pub(super) surface: khr::surface::Instance,
    pub(super) headless: ext::headless_surface::Instance,
}

/// The purposes for which a Vulkan instance is made. They decide which layers and extensions it loads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InstanceOptions {
    /// Loads the Khronos validation layer, with synchronization validation. It checks the use of Vulkan, and its messages,
    /// except allowed ones, make the command or the test fail. It is an error if the layer is not installed.
    pub validation: bool,
    /// Enables headless surfaces (surfaces without a window), to which pictures are presented for capture tools. It has no
    /// effect if Vulkan lacks such surfaces.
    pub presentation: bool,
}

impl Instance {
    /// Loads the Vulkan library and makes an instance with the layers and extensions of `options`.
    ///
    /// # Errors
    /// There is no Vulkan library, the library makes no instance or no debug messenger, or the validation layer is requested
    /// and not installed.
    pub fn new(options: InstanceOptions) -> Result<Arc<Self>> {
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
                "validation is on (HEADWATER_VALIDATION or --validate), but VK_LAYER_KHRONOS_validation is not installed; unset it, or start through tools/run or tools/test",
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

    /// Every physical device, in the driver's order, for the list of `headwater info` and the choice of one. Devices that
    /// Headwater cannot use are included ([`DeviceInfo::unusable`]).
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
            .map(|(index, device)| DeviceInfo::of(&self.raw, index, device))
            .collect())
    }

    /// Chooses a physical device, and returns it with the reason for reports. `wanted` is the index of a device, or a part
    /// of its name in upper or lower case. If it is `None` or empty, the first usable device is chosen in the order
    /// discrete, integrated, virtual, CPU, other.
    ///
    /// # Errors
    /// The driver cannot list its devices, or no device is usable. With `wanted`, no device matches it or the device that it
    /// names is unusable; both are errors of wrong input.
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
                None => Ok((device.clone(), format!("selected by '{wanted}'"))),
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

    /// The messages of the validation layers since the instance was made, the oldest first; a command or a test with a
    /// message fails. [Allowed](super::messages::ALLOWED) messages, which are known to be harmless, are left out. Empty if
    /// the validation layers are not loaded.
    pub fn validation_messages(&self) -> Vec<String> {
        let debug = self.debug.as_ref();
        debug.map(DebugUtils::messages).unwrap_or_default()
    }

    /// True if the device can present pictures to headless surfaces, so that capture tools see where frames end. For this,
    /// the instance must have the extensions for headless surfaces, and the device must have swapchains.
    pub fn presents(&self, device: &DeviceInfo) -> bool {
        self.surfaces.is_some() && device.presentation
    }

    /// Names of the tools that are active between Headwater and a device, such as the capture layer of GFXReconstruct, by
    /// which a capture is possible. Each tool reports its name itself. Validation layers are left out. Empty if there are no
    /// tools, or if Vulkan cannot list them.
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

//! Messages of the validation layers, and a list of those that are allowed.

use crate::{Error, Result};
use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::Mutex;

/// A harmless message of the validation layers.
#[derive(Debug)]
pub struct Allowed {
    /// The message's identifier, such as `VUID-vkCmdDispatch-None-08114`.
    pub id: &'static str,
    /// A part of its text that distinguishes this case from others with the same identifier.
    pub text: &'static str,
    /// The reason why Headwater does not cause the fault.
    pub reason: &'static str,
}

/// The messages that are ignored. Every other one fails the tests, so a new entry needs a reason
/// that a reader can check: the driver's or the layer's fault, with its version.
///
/// Empty, as Mesa 22.3.6 and 25.0.7 and SwiftShader need none.
pub const ALLOWED: &[Allowed] = &[];

/// The maximum number of stored messages: a message in a loop must not fill the memory.
const MAX_MESSAGES: usize = 1000;

/// Vulkan's debug utilities with a messenger that collects messages.
pub(super) struct DebugUtils {
    instance: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    /// The messages that the callback collects; boxed so that its address does not change.
    log: Box<Log>,
}

/// The validation layers' messages.
type Log = Mutex<Vec<String>>;

impl DebugUtils {
    pub(super) fn new(entry: &ash::Entry, raw: &ash::Instance) -> Result<Self> {
        let instance = ext::debug_utils::Instance::new(entry, raw);
        let log = Box::<Log>::default();
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                    | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                    | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE
                    | vk::DebugUtilsMessageTypeFlagsEXT::GENERAL,
            )
            .pfn_user_callback(Some(on_message))
            .user_data(std::ptr::from_ref::<Log>(&log) as *mut c_void);
        // SAFETY: the log outlives the messenger, which Instance::drop destroys first.
        let messenger = unsafe { instance.create_debug_utils_messenger(&info, None) }
            .map_err(|e| Error::failed(format!("Vulkan gives no debug messenger ({e})")))?;
        Ok(Self {
            instance,
            messenger,
            log,
        })
    }

    /// The validation layers' messages so far, without the allowed ones.
    pub(super) fn messages(&self) -> Vec<String> {
        self.log.lock().map(|log| log.clone()).unwrap_or_default()
    }

    /// Destroys the messenger.
    ///
    /// # Safety
    /// Called once, while the instance lives.
    pub(super) unsafe fn destroy(&self) {
        // SAFETY: as the caller promises.
        unsafe {
            self.instance
                .destroy_debug_utils_messenger(self.messenger, None);
        }
    }
}

/// Stores every warning and error of the layers that is not allowed; messages of drivers and of the
/// loader are only logged.
///
/// # Safety
/// Called by the loader with valid data and the `Log` of [`DebugUtils::new`].
unsafe extern "system" fn on_message(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the specification promises valid pointers during the call.
    let (id, message, log) = unsafe {
        let text = |text: Option<&CStr>| {
            text.map(|t| t.to_string_lossy().replace('\n', " "))
                .unwrap_or_default()
        };
        (
            text((*data).message_id_name_as_c_str()),
            text((*data).message_as_c_str()),
            &*(user as *const Log),
        )
    };
    log::debug!("Vulkan {severity:?} {types:?}: {message}");
    let of_layers = vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
        | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE;
    if types.intersects(of_layers)
        && !allows(ALLOWED, &id, &message)
        && let Ok(mut messages) = log.lock()
        && messages.len() < MAX_MESSAGES
    {
        messages.push(message);
    }
    vk::FALSE
}

/// True if a list contains a message.
fn allows(list: &[Allowed], id: &str, message: &str) -> bool {
    list.iter()
        .any(|allowed| allowed.id == id && message.contains(allowed.text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_allows_its_own_case_only() {
        let list = [Allowed {
            id: "VUID-a-1",
            text: "queue 7",
            reason: "a test",
        }];
        assert!(allows(&list, "VUID-a-1", "on queue 7 it is so"));
        assert!(!allows(&list, "VUID-a-1", "on queue 8 it is so"));
        assert!(!allows(&list, "VUID-a-10", "on queue 7 it is so"));
        assert!(!allows(&[], "VUID-a-1", "on queue 7 it is so"));
    }

    #[test]
    fn every_entry_says_which_case_it_means_and_why() {
        for allowed in ALLOWED {
            assert!(
                !allowed.id.is_empty() && !allowed.text.is_empty() && allowed.reason.len() > 20,
                "{allowed:?}"
            );
        }
    }
}

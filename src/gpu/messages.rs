//! Messages of the Vulkan validation layers, and the list of harmless messages that are ignored. Any other message shows a
//! fault, and makes the command or the test fail.

use crate::{Error, Result};
use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::Mutex;

/// An entry of the list of ignored messages of the validation layers. It applies to every message whose identifier equals
/// `id` and whose text contains `text`.
#[derive(Debug)]
pub struct Allowed {
    /// Identifier that the validation layers give the message, such as `VUID-vkCmdDispatch-None-08114`.
    pub id: &'static str,
    /// A part of the message's text. It restricts the entry to one fault, because the validation layers report different
    /// faults with the same identifier.
    pub text: &'static str,
    /// The reason why the message shows no fault of Headwater, in words. It is for those who review the list; the program
    /// does not use it.
    pub reason: &'static str,
}

/// The messages that are ignored. Every other message fails the tests, so a new entry needs a reason that a reader can
/// check: a fault of the driver or of the layer, with its version.
///
/// The list is empty: Mesa 22.3.6, Mesa 25.0.7 and SwiftShader need no entry.
pub const ALLOWED: &[Allowed] = &[];

/// The maximum number of messages that are stored. Later messages are dropped, so that a message that is repeated in a loop
/// does not fill the memory.
const MAX_MESSAGES: usize = 1000;

/// Vulkan's debug utilities (`VK_EXT_debug_utils`), with a messenger that stores the messages of the validation layers.
pub(super) struct DebugUtils {
    instance: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    /// The messages that the messenger's callback has stored. They are in a box, because the messenger holds their address,
    /// which must not change.
    log: Box<Log>,
}

/// The stored messages of the validation layers, the oldest first; at most [`MAX_MESSAGES`]. At the end of a command or a
/// test, they are read and reported. Any thread can add a message, so a mutex guards the list.
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

    /// The stored messages of the validation layers, the oldest first. Messages to which an entry of [`ALLOWED`] applies are
    /// not stored.
    pub(super) fn messages(&self) -> Vec<String> {
        self.log.lock().map(|log| log.clone()).unwrap_or_default()
    }

    /// Destroys the messenger. After this, Vulkan no longer calls the callback.
    ///
    /// # Safety
    /// Must be called once, while the Vulkan instance exists.
    pub(super) unsafe fn destroy(&self) {
        // SAFETY: as the caller promises.
        unsafe {
            self.instance
                .destroy_debug_utils_messenger(self.messenger, None);
        }
    }
}

/// The callback of the messenger. It writes every message to the debug log. It stores those messages of the validation
/// layers to which no entry of [`ALLOWED`] applies; messages of drivers and of the loader are not stored.
///
/// # Safety
/// Must be called by the Vulkan loader, with valid `data` and with the [`Log`] of [`DebugUtils::new`] as `user`.
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

/// True if the message with the identifier `id` and the text `message` is to be ignored, because an entry of `list` applies
/// to it.
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

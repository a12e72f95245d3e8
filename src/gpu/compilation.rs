//! Pipelines that the driver compiles in the background.
//!
//! Drivers take up to a second for a large shader, each on one core. So the pipelines of all passes are compiled
//! at the same time, and the first recording of a pass waits for its own.

use super::device::Device;
use super::records::Compiled;
use super::specialise::specialise;
use crate::Result;
use ash::vk;
use rspirv::dr::Module;
use std::ffi::CStr;
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::{Builder, JoinHandle};
use std::time::Instant;

/// What the driver made of a shader.
type Made = std::result::Result<vk::Pipeline, vk::Result>;

/// Bytes of a compiling thread's stack: as much as a main thread usually has, since compilers recurse deeply.
const STACK_BYTES: usize = 8 << 20;

/// A compute pipeline, finished or not. Dropping it waits for the driver, which cannot be interrupted, and destroys the
/// pipeline, but not the layout.
pub(super) struct Compilation {
    device: Arc<Device>,
    name: String,
    made: OnceLock<Made>,
    thread: Mutex<Option<JoinHandle<Made>>>,
}

impl Compilation {
    /// Begins to compile a shader. `constants` are specialisation constants: (id, value), four bytes each.
    pub(super) fn start(
        device: &Arc<Device>,
        name: &str,
        shader: Module,
        constants: &[(u32, u32)],
        layout: vk::PipelineLayout,
    ) -> Self {
        let shader = Arc::new(shader);
        let thread = {
            let (device, name) = (device.clone(), name.to_owned());
            let (shader, constants) = (shader.clone(), constants.to_vec());
            Builder::new()
                .name(format!("compile {name}"))
                .stack_size(STACK_BYTES)
                .spawn(move || compile(&device, &name, &shader, &constants, layout))
        };
        let made = OnceLock::new();
        if thread.is_err() {
            // Where the process can have no more threads, it waits.
            made.get_or_init(|| compile(device, name, &shader, constants, layout));
        }
        Self {
            device: device.clone(),
            name: name.to_owned(),
            made,
            thread: Mutex::new(thread.ok()),
        }
    }

    /// Waits for the pipeline.
    ///
    /// # Errors
    /// The driver rejects the shader.
    pub(super) fn wait(&self) -> Result<vk::Pipeline> {
        let made = self.made.get_or_init(|| {
            let thread = self.thread.lock().ok().and_then(|mut thread| thread.take());
            // A thread that panicked has made nothing.
            let joined = thread.and_then(|thread| thread.join().ok());
            joined.unwrap_or(Err(vk::Result::ERROR_UNKNOWN))
        });
        made.map_err(|e| self.device.failure(&format!("make pass {}", self.name), e))
    }
}

/// Compiles a shader.
fn compile(
    device: &Device,
    name: &str,
    shader: &Module,
    constants: &[(u32, u32)],
    layout: vk::PipelineLayout,
) -> Made {
    let words = specialise(shader, constants);
    let bytes = size_of_val(words.as_slice()) as u64;
    device.records.note_shader(bytes);
    let raw = &device.raw;
    // SAFETY: every create-info and what it points to lives through its call. The layout outlives the compilation,
    // which the pass that owns both waits for before it destroys the layout.
    unsafe {
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        let module = raw.create_shader_module(&info, None)?;
        device.name(module, name);
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main");
        let flags = match device.features.executable_properties {
            true => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
            false => vk::PipelineCreateFlags::empty(),
        };
        let info = vk::ComputePipelineCreateInfo::default()
            .flags(flags)
            .stage(stage)
            .layout(layout);
        let start = Instant::now();
        let made = raw.create_compute_pipelines(vk::PipelineCache::null(), &[info], None);
        raw.destroy_shader_module(module, None);
        let pipeline = made.map_err(|(_, e)| e)?[0];
        device.name(pipeline, name);
        device.records.note_compiled(Compiled {
            name: name.to_owned(),
            milliseconds: start.elapsed().as_secs_f64() * 1e3,
            statistics: statistics(device, pipeline).unwrap_or_default(),
        });
        Ok(pipeline)
    }
}

/// What the driver's compiler says of a pipeline, if it was asked to; nothing is lost where it fails to.
fn statistics(device: &Device, pipeline: vk::Pipeline) -> Option<Vec<(String, String)>> {
    let executables = device.executables.as_ref()?;
    let text = |name: std::result::Result<&CStr, _>| -> Option<String> {
        Some(name.ok()?.to_string_lossy().into_owned())
    };
    let mut all = Vec::new();
    // SAFETY: the pipeline was made with the flag for it, and every structure lives through its call; the member of the
    // union is the one that its format names.
    unsafe {
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        let list = executables.get_pipeline_executable_properties(&info).ok()?;
        for index in 0..list.len() as u32 {
            let info = vk::PipelineExecutableInfoKHR::default()
                .pipeline(pipeline)
                .executable_index(index);
            for statistic in executables.get_pipeline_executable_statistics(&info).ok()? {
                use vk::PipelineExecutableStatisticFormatKHR as Format;
                let value = match statistic.format {
                    Format::BOOL32 => (statistic.value.b32 != 0).to_string(),
                    Format::INT64 => statistic.value.i64.to_string(),
                    Format::UINT64 => statistic.value.u64.to_string(),
                    _ => statistic.value.f64.to_string(),
                };
                all.push((text(statistic.name_as_c_str())?, value));
            }
        }
    }
    Some(all)
}

impl Drop for Compilation {
    fn drop(&mut self) {
        self.device.wait_before_drop();
        if let Ok(pipeline) = self.wait() {
            // SAFETY: all commands that used it have finished.
            unsafe { self.device.raw.destroy_pipeline(pipeline, None) };
        }
    }
}

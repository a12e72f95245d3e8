//! Programs. A program has everything that the device needs to run a pass: the compute pipeline that was made
//! from its specialised shader, the layouts of the pipeline, and the list of the bindings that the shader
//! uses.

use super::dead_code::remove_dead_code;
use super::device::Device;
use super::records::{Compiled, CompilerReport};
use super::reflection::{Binding, BindingKind, Reflection};
use super::specialise::specialise;
use crate::base::short_hash::short;
use crate::{Error, Result};
use ash::vk;
use rspirv::binary::Assemble;
use rspirv::dr::Module;
use std::ffi::CStr;
use std::sync::Arc;
use std::time::Instant;

/// The inputs from which a [`Program`] (a compute pipeline with its layouts) is made: the shader, and the values that its
/// pipeline and layouts depend on.
pub(super) struct Source {
    /// Name of the pass in debug labels, times and messages.
    pub name: String,
    /// The parsed SPIR-V of the shader, before specialisation.
    pub shader: Module,
    /// Values of specialisation constants: pairs of `constant_id` and 32-bit word. Other constants keep their defaults.
    pub constants: Vec<(u32, u32)>,
    /// Size of the push constants in bytes; 0 if the shader has none.
    pub push_constant_size: u32,
    /// Length of the shader's array of images; 0 for a shader without one.
    pub image_count: u32,
}

/// A compute pipeline with its layouts, made from a shader that was specialised and freed from dead code. Each run of the
/// pass binds resources according to the layouts, and dispatches the pipeline.
pub(super) struct Program {
    device: Arc<Device>,
    /// The bindings that the shader still uses after specialisation and removal of dead code, sorted by binding number.
    /// Resources are bound in this order.
    pub bindings: Vec<Binding>,
    /// The Vulkan layout of descriptor set 0, with one entry for each of `bindings`.
    pub set: vk::DescriptorSetLayout,
    /// The Vulkan layout of the pipeline: descriptor set 0 and the push constants.
    pub layout: vk::PipelineLayout,
    /// The compute pipeline. A device that only compiles runs no pipeline; there it is null if the same SPIR-V was compiled
    /// before for a pass of the same name.
    pub pipeline: vk::Pipeline,
}

impl Program {
    /// Specialises a shader, removes the code that can no longer run, and has the driver compile the rest.
    ///
    /// # Errors
    /// The shader binds more storage buffers than the device allows, or the driver rejects it.
    pub(super) fn new(device: &Arc<Device>, source: &Source) -> Result<Self> {
        let mut shader = source.shader.clone();
        specialise(&mut shader, &source.constants);
        remove_dead_code(&mut shader);
        let reflection = Reflection::of(shader);
        let bindings = reflection.interface()?.bindings;
        check_limit(device, &source.name, &bindings)?;
        let mut program = Self {
            device: device.clone(),
            bindings,
            set: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
        };
        let fail = |e| device.failure(&format!("make pass {}", source.name), e);
        program.lay_out(source).map_err(fail)?;
        let words = reflection.into_module().assemble();
        program.compile(&source.name, &words).map_err(fail)?;
        Ok(program)
    }

    /// Makes two Vulkan layouts: that of descriptor set 0, from the bindings of the program, and that of the pipeline. The
    /// pipeline layout consists of this set and the push constants of `source`.
    fn lay_out(&mut self, source: &Source) -> std::result::Result<(), vk::Result> {
        let bindings: Vec<_> = (self.bindings.iter())
            .map(|b| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(b.number)
                    .descriptor_type(descriptor_type(b.kind))
                    .descriptor_count(match b.kind {
                        BindingKind::Images => source.image_count,
                        _ => 1,
                    })
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let push = [vk::PushConstantRange {
            stage_flags: vk::ShaderStageFlags::COMPUTE,
            offset: 0,
            size: source.push_constant_size,
        }];
        let raw = &self.device.raw;
        // SAFETY: every create-info and what it points to lives through its call; what was made before a failure is
        // destroyed by Drop.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            self.set = raw.create_descriptor_set_layout(&info, None)?;
            let sets = [self.set];
            let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            if source.push_constant_size > 0 {
                info = info.push_constant_ranges(&push);
            }
            self.layout = raw.create_pipeline_layout(&info, None)?;
        }
        Ok(())
    }

    /// Makes the pipeline of the pass `name` from the SPIR-V `words`, and adds the driver's result (compile time and report)
    /// to the device's records. A device that only compiles makes no pipeline if it has compiled the same words for the same
    /// name before. It then adds the earlier result to the records once more.
    fn compile(&mut self, name: &str, words: &[u32]) -> std::result::Result<(), vk::Result> {
        let device = &self.device;
        device.records.note_shader(size_of_val(words) as u64);
        let shader = short(&blake3::hash(bytemuck::cast_slice(words)));
        if !device.runs()
            && let Some(known) = device.records.find_compiled(name, &shader)
        {
            // The pipeline would have no use but its statistics.
            device.records.note_compiled(known);
            return Ok(());
        }
        let raw = &device.raw;
        // SAFETY: every create-info and what it points to lives through its call, and the layout is alive.
        unsafe {
            let info = vk::ShaderModuleCreateInfo::default().code(words);
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
                .layout(self.layout);
            let start = Instant::now();
            let made = raw.create_compute_pipelines(vk::PipelineCache::null(), &[info], None);
            raw.destroy_shader_module(module, None);
            self.pipeline = made.map_err(|(_, e)| e)?[0];
            device.name(self.pipeline, name);
            device.records.note_compiled(Compiled {
                name: name.to_owned(),
                shader,
                milliseconds: start.elapsed().as_secs_f64() * 1e3,
                report: report(device, self.pipeline).unwrap_or_default(),
            });
        }
        Ok(())
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.device.wait_before_drop();
        // SAFETY: all commands that used these have finished; null handles are ignored.
        unsafe {
            let raw = &self.device.raw;
            raw.destroy_pipeline(self.pipeline, None);
            raw.destroy_pipeline_layout(self.layout, None);
            raw.destroy_descriptor_set_layout(self.set, None);
        }
    }
}

fn descriptor_type(kind: BindingKind) -> vk::DescriptorType {
    match kind {
        BindingKind::Storage { .. } => vk::DescriptorType::STORAGE_BUFFER,
        BindingKind::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
        BindingKind::Texels => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
        BindingKind::Images => vk::DescriptorType::SAMPLED_IMAGE,
        BindingKind::AccelerationStructure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
    }
}

/// Returns an error if `bindings` has more storage buffers than the device allows for one shader, because some drivers crash
/// beyond this limit. `name` is the name of the pass, for the message.
fn check_limit(device: &Device, name: &str, bindings: &[Binding]) -> Result<()> {
    let storage = bindings
        .iter()
        .filter(|b| matches!(b.kind, BindingKind::Storage { .. }));
    let (count, limit) = (storage.count(), device.info.max_storage_buffers);
    if count > limit as usize {
        return Err(Error::failed(format!(
            "pass {name} binds {count} storage buffers, but device '{}' takes at most {limit}; choose another --geometry or simpler settings",
            device.info.name
        )));
    }
    Ok(())
}

/// The report of the driver's compiler about a pipeline, which profiles show. `None` if the device was opened without
/// [`Features::executable_properties`](super::Features::executable_properties), which such reports need, or if the driver
/// fails to report.
fn report(device: &Device, pipeline: vk::Pipeline) -> Option<CompilerReport> {
    let executables = device.executables.as_ref()?;
    let text = |name: std::result::Result<&CStr, _>| -> Option<String> {
        Some(name.ok()?.to_string_lossy().into_owned())
    };
    let mut report = CompilerReport::default();
    // SAFETY: the pipeline was made with the flag for it, and every structure lives through its call; the member of the
    // union is the one that its format names.
    unsafe {
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        let list = executables.get_pipeline_executable_properties(&info).ok()?;
        report.subgroup_size = list
            .first()
            .map_or(0, |properties| properties.subgroup_size);
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
                let name = text(statistic.name_as_c_str())?;
                report.statistics.push((name, value));
            }
        }
    }
    Some(report)
}

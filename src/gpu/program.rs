//! The program of a pass on the device: a pipeline, and its bindings.

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

/// The inputs from which a program is made.
pub(super) struct Source {
    /// The name in debug labels, timings and messages.
    pub name: String,
    /// The shader.
    pub shader: Module,
    /// Specialisation constants: id and word.
    pub constants: Vec<(u32, u32)>,
    /// The size of the push constants, in bytes.
    pub push_constant_size: u32,
    /// Length of the array of images, if the shader has one.
    pub image_count: u32,
}

/// A compute pipeline with its layouts.
pub(super) struct Program {
    device: Arc<Device>,
    /// The bindings that the shader uses with the values of its specialisation constants, in the order of their binding
    /// numbers.
    pub bindings: Vec<Binding>,
    /// The layout of the descriptor set.
    pub set: vk::DescriptorSetLayout,
    /// The layout of the pipeline.
    pub layout: vk::PipelineLayout,
    /// The pipeline.
    pub pipeline: vk::Pipeline,
}

impl Program {
    /// Specialises a shader, removes the code that cannot run then, and has the driver compile the rest.
    ///
    /// # Errors
    /// The shader uses more than the device can bind, or the driver rejects it.
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

    /// Makes the layouts.
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

    /// Makes the pipeline.
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

/// Checks that the device can bind this number of buffers to one shader.
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

/// The report of the driver's compiler about a pipeline, if it was requested; a failure is ignored.
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

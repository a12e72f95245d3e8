//! A recording: a sequence of passes that are recorded, submitted together, and then waited for.

use super::buffer::Buffer;
use super::commands::Commands;
use super::device::Device;
use super::pass::{Bindings, ComputePass, Resource};
use super::recorder::PassTime;
use super::records::Output;
use crate::base::short_hash::short;
use crate::{Error, Result};
use ash::vk;
use std::marker::PhantomData;
use std::sync::Arc;

/// The size (columns, rows, 1) of a dispatch with at least `groups` workgroups. Rows are needed because a device must
/// support only 65,535 workgroups in one dimension. The dispatch can have more workgroups than `groups`; shaders must return
/// early in the excess ones. If `groups` is 0, the dispatch has one workgroup.
pub fn in_rows(groups: u32) -> [u32; 3] {
    let rows = groups.div_ceil(32768).max(1);
    [groups.div_ceil(rows).max(1), rows, 1]
}

/// A sequence of passes, recorded and then submitted together, with a global memory barrier before each pass. Each pass has
/// a debug label and a pair of timestamps. The lifetime `'a` keeps every resource alive until the commands are submitted.
/// From then on, dropping a resource waits for the commands.
pub struct Recording<'a> {
    /// The commands recorded so far. `None` on a device that only compiles, where arguments are checked and nothing is
    /// recorded.
    commands: Option<Commands>,
    /// Times of the passes that have already run. Passes run before the end of the recording only if their outputs are
    /// hashed ([`Device::hash_outputs`]).
    times: Vec<PassTime>,
    resources: PhantomData<&'a ()>,
}

impl<'a> Recording<'a> {
    /// Begins an empty recording on the device, to which passes are added before all of them are submitted
    /// together.
    ///
    /// # Errors
    /// The device is lost or out of memory.
    pub fn new(device: &Arc<Device>) -> Result<Self> {
        Ok(Self {
            commands: device.runs().then(|| Commands::new(device)).transpose()?,
            times: Vec::new(),
            resources: PhantomData,
        })
    }

    /// Records one dispatch of `groups` workgroups (x, y, z), with the push constants `push`. It first waits until the pass
    /// is compiled. If the outputs of passes are hashed ([`Device::hash_outputs`]), it also runs everything recorded so far,
    /// and hashes each buffer that the pass may write.
    ///
    /// # Errors
    /// The bindings or the size of `push` do not match the shader, the driver rejects the shader, or the device is lost or
    /// out of memory.
    pub fn pass<P: bytemuck::Pod>(
        &mut self,
        pass: &'a ComputePass,
        bindings: &dyn Bindings<'a>,
        push: &P,
        groups: [u32; 3],
    ) -> Result<()> {
        let program = pass.compilation.wait()?;
        let resources = pass.resolve(program, bindings)?;
        if size_of::<P>() as u32 != pass.push_constant_size {
            return Err(Error::failed(format!(
                "pass {} takes {} bytes of push constants, {} were given",
                pass.name(),
                pass.push_constant_size,
                size_of::<P>()
            )));
        }
        let Some(commands) = &mut self.commands else {
            return Ok(());
        };
        let set = commands.descriptor_set(pass.name(), program, &resources)?;
        commands.barrier();
        commands.begin(pass.name(), pass.is_first_run());
        let raw = &commands.device.raw;
        // SAFETY: pipeline, layout and set belong together; the resources live as long as 'a.
        unsafe {
            raw.cmd_bind_pipeline(
                commands.raw(),
                vk::PipelineBindPoint::COMPUTE,
                program.pipeline,
            );
            raw.cmd_bind_descriptor_sets(
                commands.raw(),
                vk::PipelineBindPoint::COMPUTE,
                program.layout,
                0,
                &[set],
                &[],
            );
            if size_of::<P>() > 0 {
                raw.cmd_push_constants(
                    commands.raw(),
                    program.layout,
                    vk::ShaderStageFlags::COMPUTE,
                    0,
                    bytemuck::bytes_of(push),
                );
            }
            raw.cmd_dispatch(commands.raw(), groups[0], groups[1], groups[2]);
        }
        commands.end();
        if commands.device.records.hashes_outputs() {
            // What is offered and not bound the shader may have the address of.
            let by_address = (bindings.offered().into_iter())
                .filter(|(name, _)| program.bindings.iter().all(|bound| bound.name != *name));
            let outputs: Vec<Resource> = (resources.iter().copied())
                .chain(by_address.map(|(_, resource)| resource))
                .collect();
            let device = commands.device.clone();
            let recorded = std::mem::replace(commands, Commands::new(&device)?);
            self.times.extend(recorded.finish()?);
            hash_outputs(&device, pass, &outputs)?;
        }
        Ok(())
    }

    /// Records a copy of `value` to the start of a buffer. The bytes of `value` are copied into the commands now, so that
    /// later changes of it have no effect.
    ///
    /// # Errors
    /// The value is larger than the buffer or than 65,536 bytes, or its size is not a multiple of 4 bytes.
    pub fn update<T: bytemuck::Pod>(&mut self, buffer: &'a Buffer, value: &T) -> Result<()> {
        let bytes = bytemuck::bytes_of(value);
        let size = bytes.len() as u64;
        if size > buffer.size().min(65_536) || !size.is_multiple_of(4) {
            return Err(Error::failed(format!(
                "{} of {} bytes cannot be updated with {size} bytes",
                buffer.name(),
                buffer.size()
            )));
        }
        if let Some(commands) = &self.commands {
            commands.barrier();
            let raw = &commands.device.raw;
            // SAFETY: the buffer allows transfers, holds as many bytes, and lives as long as 'a.
            unsafe { raw.cmd_update_buffer(commands.raw(), buffer.raw, 0, bytes) };
        }
        Ok(())
    }

    /// Records a fill of the whole buffer with zeros, which runs after everything that was recorded before.
    pub fn clear(&mut self, buffer: &'a Buffer) {
        if let Some(commands) = &self.commands {
            commands.barrier();
            commands.clear(buffer.raw);
        }
    }

    /// Submits all commands without waiting for them. [`Device::wait_for_running`] waits for them and returns their times;
    /// dropping any resource also waits.
    ///
    /// # Errors
    /// The device is lost or out of memory.
    pub fn submit(self) -> Result<()> {
        let Some(commands) = self.commands else {
            return Ok(());
        };
        let device = commands.device.clone();
        let submission = commands.submit()?;
        match device.running.lock() {
            Ok(mut running) => running.push_back(submission),
            Err(_) => drop(device.wait_for(submission)?),
        }
        Ok(())
    }

    /// Submits all commands, waits for them, and returns the time of each run of a pass in the order of recording. The list
    /// is empty on a device that has no timestamps or only compiles.
    ///
    /// # Errors
    /// The device is lost or out of memory.
    pub fn finish(self) -> Result<Vec<PassTime>> {
        let Self {
            commands,
            mut times,
            ..
        } = self;
        if let Some(commands) = commands {
            let device = commands.device.clone();
            let (last, taken) = device.wait_for(commands.submit()?)?;
            device.records.note_submitted(taken);
            times.extend(last);
        }
        Ok(times)
    }
}

/// Reads back each buffer that a pass may write, and stores a hash of its content in the records of the device, where
/// regression tests find it. The commands of the pass must have finished.
fn hash_outputs(device: &Device, pass: &ComputePass, resources: &[Resource<'_>]) -> Result<()> {
    for resource in resources {
        let Resource::Write(buffer) = resource else {
            continue;
        };
        let bytes: Vec<u8> = buffer.read(buffer.size() as usize)?;
        device.records.note_output(Output {
            pass: pass.name().to_owned(),
            buffer: buffer.name().to_owned(),
            hash: short(&blake3::hash(&bytes)),
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{DeviceInfo, Features, Instance, InstanceOptions, Usage};

    /// Records two writes of a buffer without a barrier between them, and checks that synchronization validation reports
    /// this hazard among the messages of the device. If such reports were lost, no other test would find a missing barrier.
    #[test]
    fn a_planted_hazard_is_caught() {
        let instance = Instance::new(InstanceOptions {
            validation: true,
            ..InstanceOptions::default()
        })
        .unwrap();
        // The same device as all tests use; a machine may have others.
        let info = match std::env::var("HEADWATER_DEVICE") {
            Ok(name) => instance.choose(Some(&name)).unwrap().0,
            Err(_) => {
                let devices = instance.devices().unwrap();
                devices.into_iter().find(DeviceInfo::is_cpu).unwrap()
            }
        };
        let device = Device::open(&instance, info, Features::default()).unwrap();
        let buffer = Buffer::new(&device, "planted", 1024, Usage::default()).unwrap();
        let mut recording = Recording::new(&device).unwrap();
        recording.clear(&buffer);
        recording.clear(&buffer);
        assert_eq!(device.validation_messages(), Vec::<String>::new());
        // SAFETY: as in `clear`; the missing barrier is what the test plants.
        unsafe {
            let commands = recording.commands.as_ref().unwrap().raw();
            (device.raw).cmd_fill_buffer(commands, buffer.raw, 0, vk::WHOLE_SIZE, 1);
        }
        recording.finish().unwrap();
        let messages = device.validation_messages().join("\n");
        assert!(
            messages.contains("SYNC-HAZARD-WRITE-AFTER-WRITE"),
            "{messages}"
        );
    }
}

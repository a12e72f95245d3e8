//! Descriptor sets, which bind the resources of a pass. The sets of one command buffer come from one
//! descriptor pool, or from several if the first one is full.

use super::buffer::Buffer;
use super::commands::Commands;
use super::device::Device;
use super::pass::Resource;
use super::program::Program;
use crate::Result;
use ash::prelude::VkResult;
use ash::vk;

/// Number of descriptor sets, one per pass, for which a new descriptor pool has space. It exceeds the number
/// of passes of a frame, so that a frame uses one or two pools.
const PASSES_PER_POOL: u32 = 32;

/// Makes a descriptor pool with space for [`PASSES_PER_POOL`] descriptor sets. Each set can bind as many
/// buffers of each kind as `resources` has entries, and as many images as `resources` has.
fn make_pool(device: &Device, resources: &[Resource<'_>]) -> VkResult<vk::DescriptorPool> {
    // Passes differ in the kinds of the buffers that they bind, so each kind has space for all.
    let buffers = resources.len().max(1) as u32;
    let images = (resources.iter()).map(|resource| match resource {
        Resource::Images(images) => images.len() as u32,
        _ => 0,
    });
    let mut counts = vec![
        (vk::DescriptorType::STORAGE_BUFFER, buffers),
        (vk::DescriptorType::UNIFORM_BUFFER, buffers),
        (vk::DescriptorType::UNIFORM_TEXEL_BUFFER, buffers),
        (vk::DescriptorType::SAMPLED_IMAGE, images.sum()),
    ];
    if device.features.ray_query {
        counts.push((vk::DescriptorType::ACCELERATION_STRUCTURE_KHR, buffers));
    }
    let sizes: Vec<_> = (counts.into_iter().filter(|(_, count)| *count > 0))
        .map(|(ty, count)| vk::DescriptorPoolSize {
            ty,
            descriptor_count: count * PASSES_PER_POOL,
        })
        .collect();
    let info = vk::DescriptorPoolCreateInfo::default()
        .max_sets(PASSES_PER_POOL)
        .pool_sizes(&sizes);
    // SAFETY: the create-info lives through the call; the recorder of the commands destroys the pool.
    unsafe { device.raw.create_descriptor_pool(&info, None) }
}

/// Allocates a descriptor set with the layout of `program` from `pool`. An error can mean that the pool is
/// full.
fn allocate(
    device: &Device,
    pool: vk::DescriptorPool,
    program: &Program,
) -> VkResult<vk::DescriptorSet> {
    let layouts = [program.set];
    let info = vk::DescriptorSetAllocateInfo::default()
        .descriptor_pool(pool)
        .set_layouts(&layouts);
    // SAFETY: the pool and the layout are alive, and only the thread that records the commands uses the pool.
    let sets = unsafe { device.raw.allocate_descriptor_sets(&info)? };
    Ok(sets[0])
}

impl Commands {
    /// Makes a descriptor set that binds `resources`, which has one entry for each of the program's bindings,
    /// in their order. The set comes from the first descriptor pool of the commands that has space for it, or
    /// from a new one. It is valid until the commands have finished. `name` is the name of the pass, for
    /// error messages.
    pub(super) fn descriptor_set(
        &mut self,
        name: &str,
        program: &Program,
        resources: &[Resource<'_>],
    ) -> Result<vk::DescriptorSet> {
        let fail = |e| self.device.failure(&format!("bind pass {name}"), e);
        let pools = &mut self.recorder.descriptor_pools;
        let is_full = |error: &vk::Result| {
            [
                vk::Result::ERROR_OUT_OF_POOL_MEMORY,
                vk::Result::ERROR_FRAGMENTED_POOL,
            ]
            .contains(error)
        };
        let allocated = (pools.iter())
            .map(|pool| allocate(&self.device, *pool, program))
            .find(|allocated| !allocated.as_ref().is_err_and(is_full));
        let set = match allocated {
            Some(allocated) => allocated,
            None => {
                let pool = make_pool(&self.device, resources).map_err(fail)?;
                pools.push(pool);
                allocate(&self.device, pool, program)
            }
        };
        let set = set.map_err(fail)?;
        let raw = &self.device.raw;
        let whole = |buffer: &Buffer| {
            [vk::DescriptorBufferInfo {
                buffer: buffer.raw,
                offset: 0,
                range: vk::WHOLE_SIZE,
            }]
        };
        for (binding, resource) in program.bindings.iter().zip(resources) {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(binding.number);
            let update = |write| {
                // SAFETY: set, buffers and structures are alive; kinds were checked by `resolve`.
                unsafe { raw.update_descriptor_sets(&[write], &[]) }
            };
            match resource {
                Resource::AccelerationStructure(structure) => {
                    let handles = [structure.raw];
                    let mut chain = vk::WriteDescriptorSetAccelerationStructureKHR::default()
                        .acceleration_structures(&handles);
                    let mut write = write
                        .descriptor_type(vk::DescriptorType::ACCELERATION_STRUCTURE_KHR)
                        .push_next(&mut chain);
                    write.descriptor_count = 1;
                    update(write);
                }
                Resource::Images(images) => {
                    let views: Vec<_> = (images.iter())
                        .map(|image| {
                            vk::DescriptorImageInfo::default()
                                .image_view(image.view)
                                .image_layout(vk::ImageLayout::GENERAL)
                        })
                        .collect();
                    update(
                        write
                            .descriptor_type(vk::DescriptorType::SAMPLED_IMAGE)
                            .image_info(&views),
                    );
                }
                Resource::Uniform(buffer) => update(
                    write
                        .descriptor_type(vk::DescriptorType::UNIFORM_BUFFER)
                        .buffer_info(&whole(buffer)),
                ),
                Resource::Texels(buffer) => update(
                    write
                        .descriptor_type(vk::DescriptorType::UNIFORM_TEXEL_BUFFER)
                        .texel_buffer_view(&[buffer.view]),
                ),
                Resource::Read(buffer) | Resource::Write(buffer) => update(
                    write
                        .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                        .buffer_info(&whole(buffer)),
                ),
            }
        }
        Ok(set)
    }
}

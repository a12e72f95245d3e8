//! Compute passes. A pass is a compute shader with the values of its specialisation constants. For each run, resources are
//! bound to it by the names that the shader gives its bindings.

use super::acceleration::AccelerationStructure;
use super::buffer::Buffer;
use super::compilation::Compilation;
use super::device::Device;
use super::program::{Program, Source};
use super::reflection::{BindingKind, Interface, Reflection};
use super::sampled_image::SampledImage;
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A resource to bind to a shader for one run of a pass. The variant states the kind of the resource, and for a buffer
/// whether the shader may write it. Both must agree with the declaration of the binding in the shader; otherwise
/// [`Recording::pass`](super::Recording::pass) returns an error instead of recording commands that read or write wrong
/// memory.
#[derive(Clone, Copy)]
pub enum Resource<'a> {
    /// The shader only reads this buffer. The declaration in the shader decides how it reads: as a storage buffer, or as
    /// texels of four `uint`s. Only a buffer that was made with [`Usage::texels`](super::Usage::texels) can be read as
    /// texels.
    Read(&'a Buffer),
    /// The shader may read and write this storage buffer. It must not be declared `readonly` in the shader.
    Write(&'a Buffer),
    /// The shader reads this buffer as a uniform block: small data, such as constants, that all invocations
    /// share.
    Uniform(&'a Buffer),
    /// The shader reads this buffer as texels of four `uint`s. The buffer must have been made with
    /// [`Usage::texels`](super::Usage::texels).
    Texels(&'a Buffer),
    /// The shader reads these images through its array of sampled images, in which image i of the slice has the index i. The
    /// number of images must be the one that was given to [`ComputePass::with_images`].
    Images(&'a [SampledImage]),
    /// The shader traces rays in this top-level acceleration structure.
    AccelerationStructure(&'a AccelerationStructure),
}

/// The resources for one run of a pass, each with the name of a binding. [`Recording::pass`](super::Recording::pass) binds a
/// resource to the binding of the same name in the shader. The macro [`bindings!`](crate::bindings) declares structures that
/// implement this trait.
pub trait Bindings<'a> {
    /// The resources that the shader must use, each with the name of its binding. The shader's code, before specialisation,
    /// must use a binding of each of these names; otherwise [`Recording::pass`](super::Recording::pass) returns an error. If
    /// specialisation removes all code that uses a binding, its resource is allowed, but is not bound.
    fn own(&self) -> Vec<(&'static str, Resource<'a>)>;

    /// The resources that the shader may use, each with the name of its binding. A resource is bound only if the specialised
    /// shader uses a binding of its name, so that one list can serve shaders with different settings. In a structure of
    /// [`bindings!`](crate::bindings), these are the resources of `[offers …]` and `[optional …]`; without such entries, the
    /// list is empty.
    fn offered(&self) -> Vec<(&'static str, Resource<'a>)> {
        Vec::new()
    }
}

/// A group of resources that passes have in common, such as the buffers of the scene. Each pass binds only
/// the resources that its shader uses; see `[offers …]` of [`bindings!`](crate::bindings). A group that is
/// `None` has no resources.
pub trait Offers {
    /// The resources, each with the name of its binding in the shaders.
    fn resources(&self) -> Vec<(&'static str, Resource<'_>)>;
}

impl<T: Offers> Offers for Option<T> {
    fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        self.as_ref().map_or_else(Vec::new, T::resources)
    }
}

/// Declares a structure whose fields are the resources for one run of a pass
/// ([`Recording::pass`](crate::gpu::Recording::pass)). `read NAME`, `write NAME` and `uniform NAME` are buffers that the
/// shader must use. `[offers NAME: GROUP]` is a reference to a value of the type `GROUP`, whose trait [`Offers`] returns
/// named resources. Each of them is bound only if the specialised shader uses a binding of its name. `[optional read NAME]`
/// is a buffer that may be `None` if the specialised shader does not use its binding.
#[macro_export]
macro_rules! bindings {
    ($(#[$meta:meta])* pub struct $name:ident {
        $([offers $group:ident: $group_type:ty])*
        $([optional $optional_access:ident $optional:ident])*
        $($access:ident $field:ident,)*
    }) => {
        $(#[$meta])*
        pub struct $name<'a> {
            $(#[allow(missing_docs)] pub $group: &'a $group_type,)*
            $(#[allow(missing_docs)] pub $optional: Option<&'a $crate::gpu::Buffer>,)*
            $(#[allow(missing_docs)] pub $field: &'a $crate::gpu::Buffer,)*
        }
        impl<'a> $crate::gpu::Bindings<'a> for $name<'a> {
            fn own(&self) -> Vec<(&'static str, $crate::gpu::Resource<'a>)> {
                vec![$((stringify!($field), $crate::bindings!(@$access self.$field)),)*]
            }
            fn offered(&self) -> Vec<(&'static str, $crate::gpu::Resource<'a>)> {
                let groups: &[Vec<(&'static str, $crate::gpu::Resource<'a>)>] = &[
                    $($crate::gpu::Offers::resources(self.$group),)*
                    $((self.$optional.into_iter())
                        .map(|buffer| (stringify!($optional), $crate::bindings!(@$optional_access buffer)))
                        .collect(),)*
                ];
                groups.concat()
            }
        }
    };
    (@read $buffer:expr) => { $crate::gpu::Resource::Read($buffer) };
    (@write $buffer:expr) => { $crate::gpu::Resource::Write($buffer) };
    (@uniform $buffer:expr) => { $crate::gpu::Resource::Uniform($buffer) };
}

/// A compute shader, together with the values of its specialisation constants. A background thread compiles it.
/// [`Recording::pass`](super::Recording::pass) binds resources to it by name, and records its dispatch.
pub struct ComputePass {
    pub(super) device: Arc<Device>,
    pub(super) compilation: Compilation,
    /// Names of the bindings that the code of the shader uses, before specialisation removes parts of it.
    /// [`Recording::pass`](super::Recording::pass) returns an error if a resource of [`Bindings::own`] has none of these
    /// names. The specialised shader may use fewer bindings.
    declared: Vec<String>,
    /// Size of the push constants in bytes; 0 if the shader has none. [`Recording::pass`](super::Recording::pass) returns an
    /// error if it is given push constants of another size.
    pub(super) push_constant_size: u32,
    name: String,
    /// Number of images that must be bound to the shader's array of images at each run; 0 for a shader
    /// without one.
    image_count: u32,
    has_run: AtomicBool,
}

impl ComputePass {
    /// Starts to compile `words`, a SPIR-V shader, in a background thread. The first
    /// [`Recording::pass`](super::Recording::pass) waits until the pipeline is made, and returns an error if the driver
    /// rejects the shader. `name` appears in debug labels, times and messages. `constants` has pairs of `constant_id` and
    /// value as a 32-bit word (a boolean is 0 or 1); specialisation constants without a pair keep their defaults.
    ///
    /// # Errors
    /// `words` are not SPIR-V, `constants` has two values for one id, or a binding that the shader's code uses has no name,
    /// no binding number, or another descriptor set than 0.
    pub fn new(
        device: &Arc<Device>,
        name: &str,
        words: &[u32],
        constants: &[(u32, u32)],
    ) -> Result<Self> {
        Self::with_images(device, name, words, constants, 0)
    }

    /// Starts to compile `words`, a SPIR-V shader that may have an array of sampled images, in a background thread.
    /// `image_count` is the number of images that must be bound to the array at each run; it is 0 for a shader without an
    /// array. The other arguments have the same meaning as in [`Self::new`].
    ///
    /// # Errors
    /// `words` are not SPIR-V, `constants` has two values for one id, or a binding that the shader's code uses has no name,
    /// no binding number, or another descriptor set than 0.
    pub fn with_images(
        device: &Arc<Device>,
        name: &str,
        words: &[u32],
        constants: &[(u32, u32)],
        image_count: u32,
    ) -> Result<Self> {
        let repeated = (constants.iter().enumerate())
            .find(|(index, (id, _))| constants[..*index].iter().any(|(other, _)| other == id));
        if let Some((_, (id, _))) = repeated {
            // Which of the values counts is nowhere said.
            return Err(Error::failed(format!(
                "pass {name}: two values for the specialisation constant {id}"
            )));
        }
        let reflection = Reflection::new(words)?;
        let Interface {
            bindings: declared,
            push_constant_size,
        } = reflection.interface()?;
        let source = Source {
            name: name.to_owned(),
            shader: reflection.into_module(),
            constants: constants.to_vec(),
            push_constant_size,
            image_count,
        };
        Ok(Self {
            device: device.clone(),
            compilation: Compilation::start(device, source),
            declared: declared.into_iter().map(|binding| binding.name).collect(),
            push_constant_size,
            name: name.to_owned(),
            image_count,
            has_run: AtomicBool::new(false),
        })
    }

    /// Name of the pass in debug labels, measured times and messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// True if the pass has not run before. The call itself counts as a run, so
    /// [`Recording::pass`](super::Recording::pass) calls this function exactly once per run. The result marks
    /// the time of a first run, because some drivers still compile during a first run.
    pub(super) fn is_first_run(&self) -> bool {
        !self.has_run.swap(true, Ordering::Relaxed)
    }

    /// The resources to bind to `program`, in the order of its bindings. It is an error if a binding has no resource, if the
    /// shader's code does not use a binding for a resource of [`Bindings::own`], or if two resources have the same name. It
    /// is also an error if a storage buffer is larger than the device can bind, or if a resource has another kind or access
    /// (read or write) than the shader declares.
    pub(super) fn resolve<'a>(
        &self,
        program: &Program,
        bindings: &dyn Bindings<'a>,
    ) -> Result<Vec<Resource<'a>>> {
        let own = bindings.own();
        let offered = bindings.offered();
        let wrong = |what: String| Error::failed(format!("pass {}: {what}", self.name));
        if let Some((name, _)) = own
            .iter()
            .find(|(name, _)| !self.declared.iter().any(|declared| declared == name))
        {
            return Err(wrong(format!("the shader does not name '{name}'")));
        }
        // The second of them would never be bound.
        let names = || own.iter().chain(&offered).map(|(name, _)| name);
        if let Some((_, name)) =
            (names().enumerate()).find(|(n, name)| names().take(*n).any(|other| other == *name))
        {
            return Err(wrong(format!("two resources have the name '{name}'")));
        }
        (program.bindings.iter())
            .map(|binding| {
                let (name, resource) = own
                    .iter()
                    .chain(&offered)
                    .find(|(name, _)| *name == binding.name)
                    .ok_or_else(|| wrong(format!("nothing is bound to '{}'", binding.name)))?;
                let fits = match (resource, binding.kind) {
                    (Resource::Read(_), BindingKind::Storage { writes }) => !writes,
                    (Resource::Write(_), BindingKind::Storage { writes }) => writes,
                    (Resource::Uniform(_), BindingKind::Uniform) => true,
                    (Resource::Texels(_), BindingKind::Texels) => true,
                    (Resource::Images(images), BindingKind::Images) => {
                        images.len() == self.image_count as usize
                    }
                    (Resource::Read(buffer), BindingKind::Texels) => buffer.is_texels(),
                    (Resource::AccelerationStructure(_), BindingKind::AccelerationStructure) => {
                        true
                    }
                    _ => false,
                };
                if !fits {
                    return Err(wrong(format!(
                        "'{name}' is {:?} in the shader, bound as something else",
                        binding.kind
                    )));
                }
                let limit = self.device.info.max_storage_buffer_range;
                match resource {
                    Resource::Read(buffer) if binding.kind == BindingKind::Texels => {
                        Ok(Resource::Texels(buffer))
                    }
                    Resource::Read(buffer) | Resource::Write(buffer) if buffer.size() > limit => {
                        Err(wrong(format!(
                            "'{name}' has {} bytes, but device '{}' binds at most {limit}",
                            buffer.size(),
                            self.device.info.name
                        )))
                    }
                    _ => Ok(*resource),
                }
            })
            .collect()
    }
}

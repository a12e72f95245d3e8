//! The interface of a compiled shader, read from its SPIR-V: bindings by name, push constants, specialisation constants, and
//! the layout of structures. Pipelines are made from it, and tests compare it with the declarations in Rust.

use crate::shader_interface::declare::StructLayout;
use crate::{Error, Result};
use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Dim, Op, StorageClass};
use std::collections::HashMap;

/// Kind of resource that a shader's binding needs. [`Recording::pass`](super::Recording::pass) returns an error for a
/// resource of another kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// The binding needs a storage buffer, which the shader reads, writes or both.
    Storage {
        /// False if the shader declares the buffer, or every member of it, `readonly`. Such a buffer must be bound as
        /// [`Resource::Read`](super::Resource::Read), any other one as [`Resource::Write`](super::Resource::Write).
        writes: bool,
    },
    /// The binding needs a uniform buffer, which the shader only reads.
    Uniform,
    /// The binding needs a uniform texel buffer, which the shader reads texel by texel.
    Texels,
    /// The binding needs an array of sampled 2D images. The shader does not declare its length; the argument `image_count`
    /// of [`ComputePass::with_images`](super::ComputePass::with_images) is the number of images that must be bound.
    Images,
    /// The binding needs a top-level acceleration structure, in which the shader traces rays.
    AccelerationStructure,
}

/// One binding of a shader in descriptor set 0, to which one resource must be bound before the shader runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binding {
    /// GLSL instance name of the block or variable, by which resources are bound.
    pub name: String,
    /// Number of the binding in descriptor set 0 (`layout(binding = …)`).
    pub number: u32,
    /// Kind of resource that the shader expects at this binding.
    pub kind: BindingKind,
}

/// The bindings of a shader and the size of its push constants. The layout of its pipeline is made from them, and the
/// resources that are given for a run are checked against them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interface {
    /// The bindings that the shader's code uses, sorted by binding number.
    pub bindings: Vec<Binding>,
    /// Size of the push constants in bytes; 0 if the shader has none.
    pub push_constant_size: u32,
}

/// A specialisation constant as a shader declares it. A test compares its name, type, id and default with the declaration in
/// Rust, because a value that Rust sets reaches the shader by the id alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeclaredConstant {
    /// GLSL name of the constant; empty if the SPIR-V has no name for it.
    pub name: String,
    /// GLSL type of the constant, `uint` or `bool`.
    pub glsl: &'static str,
    /// The `constant_id` of the declaration, by which the constant gets its value.
    pub id: u32,
    /// Default value as a 32-bit word; a `bool` is 0 or 1.
    pub word: u32,
    /// True if the shader's code, another constant or the length of an array uses the constant. A test fails if Rust
    /// declares a constant that no shader uses.
    pub is_used: bool,
}

/// A parsed SPIR-V shader with the names of its ids, from which its interface can be read.
pub struct Reflection {
    module: Module,
    names: HashMap<u32, String>,
}

fn literal(operand: &Operand) -> Option<u32> {
    match operand {
        Operand::LiteralBit32(value) => Some(*value),
        _ => None,
    }
}

/// Parses the words of a SPIR-V binary into a module, whose instructions can be read and changed.
///
/// # Errors
/// The words are not valid SPIR-V.
pub(crate) fn parse(words: &[u32]) -> Result<Module> {
    rspirv::dr::load_words(words)
        .map_err(|e| Error::failed(format!("a shader's SPIR-V cannot be parsed ({e})")))
}

/// True if the instruction declares an image type with the dimension `dim`: `DimBuffer` for a texel buffer,
/// `Dim2D` for a 2D image. The [`BindingKind`] of a binding follows from it.
fn is_image(instruction: &Instruction, dim: Dim) -> bool {
    instruction.class.opcode == Op::TypeImage
        && instruction.operands.get(1) == Some(&Operand::Dim(dim))
}

impl Reflection {
    /// Parses the words of a SPIR-V binary, and collects the names of its ids, so that its interface can be read.
    ///
    /// # Errors
    /// The words are not valid SPIR-V.
    pub fn new(words: &[u32]) -> Result<Self> {
        Ok(Self::of(parse(words)?))
    }

    /// Makes the reflection of a shader that is already parsed, for example after its specialisation.
    pub(super) fn of(module: Module) -> Self {
        let names = module
            .debug_names
            .iter()
            .filter(|i| i.class.opcode == Op::Name)
            .filter_map(|i| match (&i.operands[0], &i.operands[1]) {
                (Operand::IdRef(id), Operand::LiteralString(name)) => Some((*id, name.clone())),
                _ => None,
            })
            .collect();
        Self { module, names }
    }

    /// The parsed shader itself, which is then specialised, or converted back to the words of a SPIR-V binary.
    pub(super) fn into_module(self) -> Module {
        self.module
    }

    /// The bindings that the shader's code uses, sorted by number, and the size of its push constants. A binding counts as
    /// used even if the code that names it cannot run.
    ///
    /// # Errors
    /// A used binding is outside descriptor set 0, or has no name or no binding number.
    pub fn interface(&self) -> Result<Interface> {
        let mut interface = Interface {
            bindings: Vec::new(),
            push_constant_size: 0,
        };
        let variables = self.module.types_global_values.iter().filter_map(|i| {
            match (i.class.opcode, i.operands.first()) {
                (Op::Variable, Some(Operand::StorageClass(class))) => {
                    Some((i.result_id?, i.result_type?, *class))
                }
                _ => None,
            }
        });
        for (variable, pointer, class) in variables {
            let Some(pointee) = self
                .instruction(pointer)
                .and_then(|p| p.operands[1].id_ref_any())
            else {
                continue;
            };
            if class == StorageClass::PushConstant {
                interface.push_constant_size = self.struct_size(pointee);
                continue;
            }
            let kind = match class {
                StorageClass::StorageBuffer => BindingKind::Storage {
                    writes: !self.read_only(variable, pointee),
                },
                StorageClass::Uniform => BindingKind::Uniform,
                StorageClass::UniformConstant => match self.instruction(pointee) {
                    Some(i) if is_image(i, Dim::DimBuffer) => BindingKind::Texels,
                    Some(i) if self.is_array_of_images(i) => BindingKind::Images,
                    _ => BindingKind::AccelerationStructure,
                },
                _ => continue,
            };
            if !self.is_used(variable) {
                continue;
            }
            let name = self.names.get(&variable).cloned().unwrap_or_default();
            if name.is_empty() {
                return Err(Error::failed(
                    "a shader's block has no instance name to bind by; name it",
                ));
            }
            let number = self.decoration(variable, Decoration::Binding);
            let set = self.decoration(variable, Decoration::DescriptorSet);
            match (number, set.unwrap_or(0)) {
                (Some(number), 0) => interface.bindings.push(Binding { name, number, kind }),
                _ => {
                    return Err(Error::failed(format!(
                        "binding '{name}' has no number in set 0"
                    )));
                }
            }
        }
        interface.bindings.sort_by_key(|b| b.number);
        Ok(interface)
    }

    /// Compares the layouts of the structures that Rust and the shader share, because Rust writes these structures to
    /// buffers as bytes. It compares the number, names and offsets of the members, and the strides of arrays of the
    /// structure. `layouts` has the layouts in Rust; those that the shader does not use in buffers are skipped. Returns the
    /// names of the compared structures, in the order of `layouts`.
    ///
    /// # Errors
    /// A structure differs; the error describes the first difference.
    pub fn check_layouts(&self, layouts: &[StructLayout]) -> Result<Vec<&'static str>> {
        let mut found = Vec::new();
        for layout in layouts {
            for (structure, name) in &self.names {
                let is_struct = self
                    .instruction(*structure)
                    .is_some_and(|i| i.class.opcode == Op::TypeStruct);
                // The compiler emits a second copy, without offsets, for local variables.
                if name != layout.name || !is_struct || self.offset(*structure, 0).is_none() {
                    continue;
                }
                found.push(layout.name);
                self.check_struct(*structure, layout)?;
            }
        }
        Ok(found)
    }

    /// The specialisation constants that the shader declares, in the order of declaration. A test compares
    /// them with the declarations in Rust.
    pub fn specialisation_constants(&self) -> Vec<DeclaredConstant> {
        let declared = self.module.types_global_values.iter().filter_map(|i| {
            let word = match i.class.opcode {
                Op::SpecConstantTrue => 1,
                Op::SpecConstantFalse => 0,
                Op::SpecConstant => literal(i.operands.first()?)?,
                _ => return None,
            };
            let result = i.result_id?;
            let is_bool = i.class.opcode != Op::SpecConstant;
            Some(DeclaredConstant {
                name: self.names.get(&result).cloned().unwrap_or_default(),
                glsl: if is_bool { "bool" } else { "uint" },
                id: self.decoration(result, Decoration::SpecId)?,
                word,
                is_used: self.is_used(result) || self.is_part_of_constant(result),
            })
        });
        declared.collect()
    }

    fn check_struct(&self, structure: u32, layout: &StructLayout) -> Result<()> {
        let differs = |what: String| Err(Error::failed(format!("struct {}: {what}", layout.name)));
        let members = self.instruction(structure).map_or(0, |i| i.operands.len());
        if members != layout.members.len() {
            return differs(format!(
                "{members} members in the shader, {} in Rust",
                layout.members.len()
            ));
        }
        for (index, member) in layout.members.iter().enumerate() {
            let name = self.member_name(structure, index as u32).unwrap_or("");
            let offset = self.offset(structure, index as u32);
            if name != member.name || offset != Some(member.offset as u32) {
                return differs(format!(
                    "member {index} is {name} at {offset:?} in the shader, {} at {} in Rust",
                    member.name, member.offset
                ));
            }
        }
        for array in &self.module.types_global_values {
            let is_array = matches!(array.class.opcode, Op::TypeArray | Op::TypeRuntimeArray)
                && array.operands[0].id_ref_any() == Some(structure);
            if let (true, Some(array)) = (is_array, array.result_id) {
                let stride = self.decoration(array, Decoration::ArrayStride);
                if stride.is_some_and(|s| s as usize != layout.size) {
                    return differs(format!(
                        "stride {stride:?} in the shader, {} in Rust",
                        layout.size
                    ));
                }
            }
        }
        Ok(())
    }

    fn instruction(&self, result: u32) -> Option<&Instruction> {
        self.module
            .types_global_values
            .iter()
            .find(|i| i.result_id == Some(result))
    }

    /// True if the instruction declares an array of 2D images whose length the shader does not state. A binding of this type
    /// is [`BindingKind::Images`].
    fn is_array_of_images(&self, instruction: &Instruction) -> bool {
        let element = instruction.operands.first().and_then(Operand::id_ref_any);
        instruction.class.opcode == Op::TypeRuntimeArray
            && (element.and_then(|element| self.instruction(element)))
                .is_some_and(|element| is_image(element, Dim::Dim2D))
    }

    fn decoration(&self, target: u32, wanted: Decoration) -> Option<u32> {
        self.module
            .annotations
            .iter()
            .find(|i| {
                i.class.opcode == Op::Decorate
                    && i.operands[0].id_ref_any() == Some(target)
                    && i.operands[1] == Operand::Decoration(wanted)
            })
            .and_then(|i| i.operands.get(2).map_or(Some(0), literal))
    }

    fn member_decoration(&self, target: u32, member: u32, wanted: Decoration) -> Option<u32> {
        self.module
            .annotations
            .iter()
            .find(|i| {
                i.class.opcode == Op::MemberDecorate
                    && i.operands[0].id_ref_any() == Some(target)
                    && literal(&i.operands[1]) == Some(member)
                    && i.operands[2] == Operand::Decoration(wanted)
            })
            .and_then(|i| i.operands.get(3).map_or(Some(0), literal))
    }

    fn offset(&self, structure: u32, member: u32) -> Option<u32> {
        self.member_decoration(structure, member, Decoration::Offset)
    }

    fn member_name(&self, structure: u32, member: u32) -> Option<&str> {
        self.module.debug_names.iter().find_map(|i| {
            let is_it = i.class.opcode == Op::MemberName
                && i.operands[0].id_ref_any() == Some(structure)
                && literal(&i.operands[1]) == Some(member);
            match (is_it, i.operands.get(2)) {
                (true, Some(Operand::LiteralString(name))) => Some(name.as_str()),
                _ => None,
            }
        })
    }

    fn read_only(&self, variable: u32, block: u32) -> bool {
        let members = self.instruction(block).map_or(0, |i| i.operands.len()) as u32;
        self.decoration(variable, Decoration::NonWritable).is_some()
            || (members > 0
                && (0..members).all(|member| {
                    self.member_decoration(block, member, Decoration::NonWritable)
                        .is_some()
                }))
    }

    fn is_used(&self, variable: u32) -> bool {
        self.module.functions.iter().any(|function| {
            function.blocks.iter().any(|block| {
                block
                    .instructions
                    .iter()
                    .any(|i| i.operands.iter().any(|o| o.id_ref_any() == Some(variable)))
            })
        })
    }

    /// True if another constant or the length of an array uses the constant with the SPIR-V id `constant`. Such a constant
    /// counts as used, even if no function of the shader names it ([`DeclaredConstant::is_used`]).
    fn is_part_of_constant(&self, constant: u32) -> bool {
        let mut all = self.module.types_global_values.iter();
        all.any(|i| i.operands.iter().any(|o| o.id_ref_any() == Some(constant)))
    }

    /// The size in bytes of the type with the SPIR-V id `type_id`, under the scalar layout that push constants have; 0 if
    /// there is no such type. It gives the size of a shader's push constants, from their structure.
    fn struct_size(&self, type_id: u32) -> u32 {
        let Some(instruction) = self.instruction(type_id) else {
            return 0;
        };
        let operand = |index: usize| instruction.operands.get(index);
        match instruction.class.opcode {
            Op::TypeStruct => {
                let last = instruction.operands.len().saturating_sub(1);
                let offset = self.offset(type_id, last as u32).unwrap_or(0);
                offset
                    + operand(last)
                        .and_then(Operand::id_ref_any)
                        .map_or(0, |t| self.struct_size(t))
            }
            Op::TypeVector => operand(1).and_then(literal).unwrap_or(0) * 4,
            Op::TypeArray => {
                let length = operand(1)
                    .and_then(Operand::id_ref_any)
                    .and_then(|c| self.instruction(c))
                    .and_then(|c| c.operands.first())
                    .and_then(literal)
                    .unwrap_or(0);
                length
                    * self
                        .decoration(type_id, Decoration::ArrayStride)
                        .unwrap_or(0)
            }
            _ => 4,
        }
    }
}

//! The macros that declare structures, constants and enumerations once for Rust and GLSL.
//!
//! [`gpu_struct!`](crate::gpu_struct) declares a `#[repr(C)]` structure, [`gpu_constants!`](crate::gpu_constants) constants,
//! [`gpu_enum!`](crate::gpu_enum) an enumeration, and [`gpu_specialisation!`](crate::gpu_specialisation) specialisation
//! constants. Each macro also generates the GLSL text of its declarations. Both languages use the scalar block layout, in
//! which a member is aligned like its components. For the types in this file, `#[repr(C)]` gives the same layout. For SIMD
//! types (`Vec3A`, `Vec4`, matrices) it does not, so they cannot be used.

use std::fmt::Write;

/// A Rust type that a shared structure can contain, because GLSL has a type with the same size and the same alignment under
/// the scalar block layout.
pub trait GlslType: bytemuck::Pod {
    /// The name of the GLSL type with which GLSL text declares a member of this type, such as `vec3`; for an
    /// array, the type of its elements.
    const GLSL: &'static str;
    /// The number of elements if the type is an array, otherwise 0. GLSL text declares an array of this
    /// length.
    const LENGTH: usize = 0;
}

macro_rules! glsl_types {
    ($($rust:ty => $glsl:literal),* $(,)?) => {
        $(impl GlslType for $rust { const GLSL: &'static str = $glsl; })*
    };
}
glsl_types! {
    f32 => "float", u32 => "uint", i32 => "int",
    glam::Vec2 => "vec2", glam::Vec3 => "vec3",
    glam::UVec2 => "uvec2", glam::UVec3 => "uvec3",
}
impl<T: GlslType, const N: usize> GlslType for [T; N]
where
    [T; N]: bytemuck::Pod,
{
    const GLSL: &'static str = T::GLSL;
    const LENGTH: usize = N;
}

/// One member of a structure that Rust and GLSL share. The GLSL text of the structure is generated from its members. Tests
/// check that each member has the same offset in Rust and in the compiled shaders (SPIR-V).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// The name of the member in Rust and GLSL. Tests find the member in compiled shaders by this name.
    pub name: &'static str,
    /// The name of the GLSL type with which GLSL text declares the member, such as `vec3`; for an array, the
    /// type of its elements.
    pub glsl: &'static str,
    /// The number of elements if the member is an array, otherwise 0. GLSL text declares an array of this
    /// length.
    pub length: usize,
    /// The offset of the member from the start of the structure in Rust, in bytes. It must be equal to the
    /// offset in compiled shaders.
    pub offset: usize,
}

/// The layout of a structure that [`gpu_struct!`](crate::gpu_struct) declared. The GLSL text of the structure is generated
/// from it, and tests compare it with the compiled shaders (SPIR-V).
#[derive(Clone, Copy, Debug)]
pub struct StructLayout {
    /// The name of the structure in Rust and GLSL. Tests find the structure in compiled shaders by this name.
    pub name: &'static str,
    /// The size of the structure in bytes. It is also the distance between consecutive elements in an array of the
    /// structure.
    pub size: usize,
    /// The members of the structure in the order of their declaration, which is also their order in memory.
    pub members: &'static [Member],
}

impl StructLayout {
    /// The declaration of the structure as GLSL text: `struct NAME { … };`, with one member per line.
    pub fn glsl(&self) -> String {
        let mut text = format!("struct {} {{\n", self.name);
        for member in self.members {
            let _ = match member.length {
                0 => writeln!(text, "    {} {};", member.glsl, member.name),
                n => writeln!(text, "    {} {}[{n}];", member.glsl, member.name),
            };
        }
        text.push_str("};\n");
        text
    }
}

/// A structure that [`gpu_struct!`](crate::gpu_struct) declared for both Rust and GLSL, so that its bytes can be copied to a
/// buffer that shaders read.
pub trait GpuStruct: bytemuck::Pod {
    /// The name, the size and the members of the structure, from which its GLSL text is generated.
    const LAYOUT: StructLayout;
}

/// Declares a structure for Rust and GLSL: the `#[repr(C)]` Rust type, and a description of its layout. The GLSL text is
/// generated from this description, and tests compare the description with the compiled shaders (SPIR-V).
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$meta:meta])* pub struct $name:ident {
        $($(#[$member_meta:meta])* pub $member:ident: $type:ty,)*
    }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$member_meta])* pub $member: $type,)* }

        impl $crate::declare::GpuStruct for $name {
            const LAYOUT: $crate::declare::StructLayout = $crate::declare::StructLayout {
                name: stringify!($name),
                size: size_of::<$name>(),
                members: &[$($crate::declare::Member {
                    name: stringify!($member),
                    glsl: <$type as $crate::declare::GlslType>::GLSL,
                    length: <$type as $crate::declare::GlslType>::LENGTH,
                    offset: std::mem::offset_of!($name, $member),
                },)*],
            };
        }
        impl $crate::declare::GlslType for $name {
            const GLSL: &'static str = stringify!($name);
        }
    };
}

/// Declares `u32` and `f32` constants for Rust and GLSL, so that both languages have the same values. It also declares the
/// function `constants_glsl`, which returns their GLSL text.
#[macro_export]
macro_rules! gpu_constants {
    ($($(#[$meta:meta])* pub const $name:ident: $type:ident = $value:expr;)*) => {
        $($(#[$meta])* pub const $name: $type = $value;)*

        /// The constants that Rust and GLSL share, as GLSL text: one `const` declaration per line, in the order of
        /// declaration.
        pub fn constants_glsl() -> String {
            let mut text = String::new();
            $(text += &$crate::declare::constant_glsl(
                stringify!($name),
                <$type as $crate::declare::GlslType>::GLSL,
                $crate::declare::Number::from($name),
            );)*
            text
        }
    };
}

/// Declares an enumeration for Rust and GLSL, so that Rust can pass a variant to a shader as its index. In GLSL the variants
/// are `uint` constants named `ENUMERATION_VARIANT`, whose values count from 0 in the order of declaration.
#[macro_export]
macro_rules! gpu_enum {
    ($(#[$meta:meta])* pub enum $name:ident {
        $($(#[$variant_meta:meta])* $variant:ident,)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum $name { $($(#[$variant_meta])* $variant,)* }

        impl $name {
            /// The variants of the enumeration as GLSL text: one `uint` constant per line, in the order of declaration.
            pub fn glsl() -> String {
                let mut text = String::new();
                $(text += &$crate::declare::constant_glsl(
                    &$crate::declare::upper_snake_case(concat!(
                        stringify!($name), stringify!($variant)
                    )),
                    "uint",
                    $crate::declare::Number::from(Self::$variant as u32),
                );)*
                text
            }
        }

        impl $crate::declare::SpecialisationValue for $name {
            const GLSL: &'static str = "uint";
            fn word(self) -> u32 { self as u32 }
        }
    };
}

/// A Rust type whose values can be values of a specialisation constant, such as `bool`. The program sets the
/// value in the SPIR-V of a shader, as one 32-bit word, before the driver compiles the shader.
pub trait SpecialisationValue {
    /// The name of the GLSL type with which the generated GLSL text declares the constant: `uint` or `bool`.
    const GLSL: &'static str;
    /// The value as the 32-bit word that is set in the SPIR-V of a shader: a number as it is, a `bool` as 0
    /// or 1, an enumeration as the index of its variant.
    fn word(self) -> u32;
}

impl SpecialisationValue for u32 {
    const GLSL: &'static str = "uint";
    fn word(self) -> u32 {
        self
    }
}

impl SpecialisationValue for bool {
    const GLSL: &'static str = "bool";
    fn word(self) -> u32 {
        self.into()
    }
}

/// A specialisation constant of a shader, with its value. The program sets the value in the SPIR-V of the
/// shader before the driver compiles it. [`gpu_specialisation!`](crate::gpu_specialisation) makes one such
/// constant for each field of its structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpecialisationConstant {
    /// The name of the constant in GLSL: the name of its field in capitals, such as `STACK_SIZE`.
    pub name: String,
    /// The name of the GLSL type with which GLSL text declares the constant: `uint` or `bool`.
    pub glsl: &'static str,
    /// The `constant_id` of the constant in GLSL, which is the index of its field in the structure, counted
    /// from 0. It identifies the constant in SPIR-V.
    pub id: u32,
    /// The value of the constant as a 32-bit word: a number as it is, a `bool` as 0 or 1, an enumeration as
    /// the index of its variant.
    pub word: u32,
}

impl SpecialisationConstant {
    /// The declaration of the constant as one line of GLSL text. Its current value becomes the default in GLSL.
    pub fn glsl(&self) -> String {
        let value = match (self.glsl, self.word) {
            ("bool", 0) => "false".to_owned(),
            ("bool", _) => "true".to_owned(),
            (_, word) => format!("{word}u"),
        };
        let Self { name, glsl, id, .. } = self;
        format!("layout(constant_id = {id}) const {glsl} {name} = {value};\n")
    }
}

/// Declares all specialisation constants of the shaders as one structure, whose fields have default values. In GLSL each
/// field is a constant, named like the field but in capitals. Its `constant_id` is the index of the field in the structure.
#[macro_export]
macro_rules! gpu_specialisation {
    ($(#[$meta:meta])* pub struct $name:ident {
        $($(#[$field_meta:meta])* pub $field:ident: $type:ty = $default:expr,)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $name { $($(#[$field_meta])* pub $field: $type,)* }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $name {
            /// All specialisation constants with the values of this structure's fields, in the order of the fields.
            pub fn constants(&self) -> Vec<$crate::declare::SpecialisationConstant> {
                let fields = [$((
                    stringify!($field),
                    <$type as $crate::declare::SpecialisationValue>::GLSL,
                    $crate::declare::SpecialisationValue::word(self.$field),
                ),)*];
                (0..).zip(fields).map(|(id, (name, glsl, word))| {
                    let name = name.to_ascii_uppercase();
                    $crate::declare::SpecialisationConstant { name, glsl, id, word }
                }).collect()
            }

            /// The declarations of all specialisation constants with their default values as GLSL text, one per line.
            pub fn glsl() -> String {
                Self::default().constants().iter().map(|constant| constant.glsl()).collect()
            }
        }
    };
}

/// Converts a name from `CamelCase`, as Rust types are named, to `UPPER_SNAKE_CASE`, as GLSL constants are named.
pub fn upper_snake_case(name: &str) -> String {
    let mut text = String::new();
    for (index, letter) in name.char_indices() {
        if index > 0 && letter.is_ascii_uppercase() {
            text.push('_');
        }
        text.push(letter.to_ascii_uppercase());
    }
    text
}

/// The value of a constant that Rust and GLSL share. [`constant_glsl`] writes it as GLSL text.
pub enum Number {
    /// An unsigned integer, which GLSL text marks with the suffix `u`.
    Uint(u32),
    /// A float, written in GLSL text with enough digits that GLSL reads exactly the same value.
    Float(f32),
}

impl From<u32> for Number {
    fn from(value: u32) -> Self {
        Self::Uint(value)
    }
}

impl From<f32> for Number {
    fn from(value: f32) -> Self {
        Self::Float(value)
    }
}

/// The declaration of one constant as one line of GLSL text: `const TYPE NAME = VALUE;`. `glsl` is the name of its GLSL
/// type.
pub fn constant_glsl(name: &str, glsl: &str, value: Number) -> String {
    match value {
        Number::Uint(value) => format!("const {glsl} {name} = {value}u;\n"),
        Number::Float(value) => format!("const {glsl} {name} = {value:e};\n"),
    }
}

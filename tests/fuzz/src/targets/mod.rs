//! The targets: each loads one kind of file.

mod environment;
mod glb;
mod gltf;
mod obj;
mod picture;
mod plan;
mod settings;
mod texture;

/// A kind of file.
pub struct Target {
    /// The name of the target.
    pub name: &'static str,
    /// Loads a file of these bytes, and checks what its loader promises.
    pub run: fn(&[u8]),
    /// Returns true if the file has a readable header. Does not call the loader.
    pub has_header: fn(&[u8]) -> bool,
}

macro_rules! targets {
    ($($name:ident),*) => {
        [$(Target {
            name: stringify!($name),
            run: $name::run,
            has_header: $name::has_header,
        }),*]
    };
}

/// All targets.
pub const TARGETS: [Target; 8] = targets!(
    gltf,
    glb,
    obj,
    texture,
    environment,
    picture,
    settings,
    plan
);

//! The permissions of the user for loading a scene.

/// Permissions of loading a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Load a scene even if image files of textures are missing, without these textures.
    pub allow_missing: bool,
    /// Also open files outside of the scene's folder if the scene names them: buffers, textures and MTL files.
    pub allow_outside: bool,
}

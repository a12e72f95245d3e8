//! What the user permits when a scene is loaded.

/// Permissions of loading a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Load a scene even if image files of textures are missing: without these textures.
    pub allow_missing: bool,
    /// Open files outside of the scene's folder too, where the scene names such: buffers, textures and MTL files.
    pub allow_outside: bool,
}

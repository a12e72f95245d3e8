//! The user's permissions for loading a scene.

/// The user's permissions for loading a scene. By default nothing is permitted: a missing image file is an error, and so is
/// a file outside of the scene's folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// True: if image files of textures are missing, the scene is loaded without these textures, with a notice. False: a
    /// missing image file is an error.
    pub allow_missing: bool,
    /// True: buffers, textures and MTL files that the scene names are also opened outside of the scene's folder. False: such
    /// a file is refused, because a scene from elsewhere must not show other files of this machine.
    pub allow_outside: bool,
}

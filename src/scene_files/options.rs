//! The user's permissions for loading a scene: whether image files may be missing, and whether files outside of the scene's
//! folder may be opened.

/// The user's permissions for loading a scene from a file. By default nothing is permitted: a missing image file is an
/// error, and so is a file outside of the scene's folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// True: if image files of textures are missing, the scene is loaded without these textures, with a notice. An image or
    /// MTL file outside of the scene's folder then counts as missing, unless `allow_outside` is true. False: a missing image
    /// file is an error, and so is an MTL file outside.
    pub allow_missing: bool,
    /// True: the buffers, images and MTL files that a scene names are opened even if they lie outside of the scene's folder.
    /// False: such a file is not opened, so that a scene from another person cannot make other files of this machine
    /// visible.
    pub allow_outside: bool,
}

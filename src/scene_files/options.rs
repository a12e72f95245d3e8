//! The user's choices for loading a scene: whether image files may be missing, whether files outside of the scene's folder may
//! be opened, and the variant of its materials.

/// The user's choices for loading a scene from a file. By default nothing is permitted: a missing image file is an
/// error, and so is a file outside of the scene's folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// True: if image files of textures are missing or damaged, the scene is loaded without these textures, with a notice. An
    /// image or MTL file outside of the scene's folder then counts as missing, unless `allow_outside` is true. Animations
    /// whose buffers are missing are left out too. False: each of these is an error.
    pub allow_missing: bool,
    /// True: the buffers, images and MTL files that a scene names are opened even if they lie outside of the scene's folder.
    /// False: such a file is not opened, so that a scene from another person cannot make other files of this machine
    /// visible.
    pub allow_outside: bool,
    /// The name of the material variant in which the scene is loaded, one of
    /// [`Scene::material_variants`](crate::scene::Scene::material_variants); another name is an error. `None`: surfaces have
    /// their default materials.
    pub material_variant: Option<String>,
}

//! What the user permits when a scene is loaded.

/// What is permitted when a scene is loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::Args)]
pub struct Options {
    /// Render even if image files of textures are missing: without these textures
    #[arg(long)]
    pub allow_missing: bool,
    /// Open files outside of the scene's folder too, where the scene names such: buffers, textures and MTL files
    #[arg(long)]
    pub allow_outside: bool,
}

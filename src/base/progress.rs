//! Progress of long work, reported to a callback that can end the work.

use crate::Result;

/// A callback that receives the fraction of a piece of work that is done, in [0, 1]. An error from it ends the work.
///
/// Rendering and studies use it. Loading a scene reports its steps instead, because the total is known only when all files
/// that the scene names have been found: [`crate::scene_files::progress`].
pub type Watch<'a> = dyn FnMut(f64) -> Result<()> + 'a;

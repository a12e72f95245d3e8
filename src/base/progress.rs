//! Progress of long work. The work reports it to a callback, which can end the work.

use crate::Result;

/// A callback that receives how much of a piece of work is done: a fraction in [0, 1], unless the function that calls it
/// states another unit. If it returns an error, the work ends with this error.
///
/// Rendering and studies use it. Loading a scene reports its steps instead, because the total is known only when all
/// files that the scene names have been found: [`crate::scene_files::progress`].
pub type Watch<'a> = dyn FnMut(f64) -> Result<()> + 'a;

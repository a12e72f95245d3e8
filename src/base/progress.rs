//! Progress of long work, reported to a callback that can end the work.

use crate::Result;

/// Is told now and then which share of a piece of work is done, from 0 to 1. An error ends the work there.
///
/// Rendering and studies speak it. Loading, whose files name further files on the way, tells its steps instead:
/// [`crate::scene_files::progress`].
pub type Watch<'a> = dyn FnMut(f64) -> Result<()> + 'a;

//! The identity of a scene in a study: hashes of everything that its runs and references depend on. Stored runs are found
//! by it without a device, so that results can be computed anywhere.

use super::plan::Resolved;
use super::reference::{SampleBlocks, blocks_of_side};
use crate::Result;
use crate::base::short_hash::short;
use crate::render::Settings;
use serde::{Deserialize, Serialize};

/// Everything that all runs and references of one scene depend on, besides the settings of a configuration,
/// as hashes. A study stores it in its folder ([`Manifest`](super::manifest::Manifest)), and makes the keys
/// of runs and references from it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// The name of the scene in the plan, by which the identity is found.
    pub scene: String,
    /// The width and the height of the pictures, in pixels; all runs and references of the scene have this
    /// size.
    pub size: (u32, u32),
    /// True if the scene has motion. If also the plan has `fps`, each frame shows its own time and is compared with its own
    /// reference; otherwise one reference serves all frames.
    pub moves: bool,
    /// A hash, as 16 hexadecimal digits, of the content of the scene, the view, the variant of the shaders,
    /// the device, its driver, and the commit of the program. Runs and references are rendered again if it
    /// changes.
    pub inputs: String,
    /// A hash, as 16 hexadecimal digits, of the sources of all shaders. Runs are rendered again if it
    /// changes.
    pub shaders: String,
    /// A hash, as 16 hexadecimal digits, of the sources of the path tracing shaders. References are rendered
    /// again if it changes.
    pub path_tracing: String,
}

impl Identity {
    /// The number of blocks in a picture of the scene. Blocks are squares of 8 × 8 pixels whose mean luminance is tested for
    /// bias. A stored run with another number of blocks is damaged, and is rendered again.
    pub fn blocks(&self) -> usize {
        let (width, height) = self.size;
        blocks_of_side(width as usize) * blocks_of_side(height as usize)
    }

    /// A hash, as 16 hexadecimal digits, of everything that the runs of a configuration depend on, except their seeds. The
    /// store finds finished runs by this key and the seed, so runs are rendered again if anything has changed.
    ///
    /// # Errors
    /// The settings have no JSON form, which cannot happen with finite numbers.
    pub fn run_key(&self, configuration: &Resolved, blocks: SampleBlocks) -> Result<String> {
        let Resolved {
            name: _,
            settings,
            frames,
            clock,
            accumulate,
            count: _,
            scenes: _,
            expect: _,
        } = configuration;
        let settings = settings.to_value()?;
        let clock = self.moves.then_some(clock);
        // The errors of a run depend on the halves of its reference.
        let half = blocks.size;
        let more = format!("run {settings} {frames} {accumulate} {clock:?} {half}");
        Ok(self.hash(&self.shaders, &more))
    }

    /// A hash, as 16 hexadecimal digits, of everything that one reference depends on; the files of its blocks
    /// are named by this key. `settings` are those of path tracing, and `time` is the time in the scene that
    /// the reference shows, in seconds.
    ///
    /// # Errors
    /// As for [`Self::run_key`].
    pub fn reference_key(
        &self,
        settings: &Settings,
        time: f64,
        blocks: SampleBlocks,
    ) -> Result<String> {
        let at = if self.moves {
            format!("at {time:?}")
        } else {
            String::new()
        };
        let size = blocks.size;
        let more = format!("reference {size} {} {at}", settings.to_value()?);
        Ok(self.hash(&self.path_tracing, &more))
    }

    /// The times in the scene, in seconds, that the references of a configuration must show: one for each
    /// frame if the frames show different times, otherwise only one.
    pub fn times(&self, configuration: &Resolved) -> Vec<f64> {
        let clock = configuration.clock;
        let frames = match clock.fps {
            Some(_) if self.moves => configuration.frames,
            _ => 1,
        };
        (0..frames).map(|frame| clock.time(frame)).collect()
    }

    fn hash(&self, shaders: &str, more: &str) -> String {
        let text = format!("{} {shaders} {more}", self.inputs);
        short(&blake3::hash(text.as_bytes()))
    }
}

//! Chooses the environment of a scene: the one that the user names, or a neutral one if the scene has no light at all.

use crate::Result;
use crate::scene::{Environment, Scene};

/// The name of no environment: the scene stays without light from infinitely far away.
pub const NO_ENVIRONMENT: &str = "none";

impl Scene {
    /// Gives the scene the environment `name`, as [`Environment::open`] reads it; `none` takes the environment away. Without
    /// a name, the scene keeps its own environment. If it then has no light at all, as most files of single models, it gets
    /// the [neutral](Environment::neutral) one, because its picture would be black; a notice says so.
    ///
    /// # Errors
    /// The environment cannot be read.
    pub fn surround(&mut self, name: Option<&str>) -> Result<()> {
        match name {
            Some(NO_ENVIRONMENT) => self.environment = None,
            Some(name) => self.environment = Some(Environment::open(name, &mut self.notices)?),
            None if self.lacks_light() => {
                self.environment = Some(Environment::neutral());
                self.notices.push(
                    "the scene has no light, so a neutral grey environment lights it; --environment sets another, such as sky:sun=40, and --environment none leaves it dark".to_owned(),
                );
            }
            None => {}
        }
        Ok(())
    }
}

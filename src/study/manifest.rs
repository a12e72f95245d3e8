//! The description of a study: the request of the user, the device, and the identities of the scenes. It is
//! stored in the study's folder, so that results can be computed, and shards merged, without a device.

use super::identity::Identity;
use super::plan::{Plan, Resolved};
use super::planned_scene::PlannedScene;
use super::shard::Shard;
use crate::base::files::write_atomically;
use crate::base::input_files;
use crate::render::settings::EnvironmentSettings;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::Path;

/// The version of the format of the file `study.json`. A file with another version is refused.
const VERSION: u32 = 1;

/// The request of the user: a plan, and the options of the command line that change it. Two studies with the
/// same request render the same runs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The name or the path of the plan, as the user gave it, for messages and pages.
    pub plan: String,
    /// The TOML text of the plan; it is stored here, because the file can change later.
    pub text: String,
    /// The names of the scenes to study instead of those of the plan; if the list is empty, the scenes of the
    /// plan are studied.
    pub scenes: Vec<String>,
    /// The environment of all scenes instead of those of the plan, as `--environment` gives it: a path of an
    /// image, or a sky; `None` keeps those of the plan.
    pub environment: Option<String>,
    /// The maximum number of scattering events of a path instead of that of the plan; `None` keeps that of
    /// the plan.
    pub bounces: Option<u32>,
    /// True for a quick preview (`--quick`), with a quarter of the seeds and a quarter of the samples of
    /// references.
    pub quick: bool,
}

impl Request {
    /// Makes the plan with the changes of the command line, and its configurations with complete settings.
    ///
    /// # Errors
    /// The plan is wrong, a configuration changes the environment of its scene, a scene is listed twice, or a
    /// scene has no configuration.
    pub fn plan(&self) -> Result<(Plan, Vec<Resolved>)> {
        let mut plan = Plan::parse(&self.plan, &self.text)?;
        plan.bounces = self.bounces.unwrap_or(plan.bounces);
        let configurations = plan.resolve()?;
        if !self.scenes.is_empty() {
            let wanted = |name: &String| {
                let planned = plan.scenes.iter().find(|scene| scene.name == *name);
                planned
                    .cloned()
                    .unwrap_or_else(|| PlannedScene::named(name))
            };
            plan.scenes = self.scenes.iter().map(wanted).collect();
        }
        for planned in &mut plan.scenes {
            planned.environment = self.environment.clone().or(planned.environment.take());
        }
        if let Some(one) = (configurations.iter())
            .find(|c| c.settings.environment != EnvironmentSettings::default())
        {
            return Err(Error::input(format!(
                "plan {}: configuration '{}' changes the environment, which all configurations of a scene share; give the scene another environment",
                self.plan, one.name
            )));
        }
        for (index, planned) in plan.scenes.iter().enumerate() {
            let name = &planned.name;
            // Runs are found by the name of their scene.
            if plan.scenes[..index].iter().any(|other| other.name == *name) {
                return Err(Error::input(format!(
                    "plan {}: scene '{name}' is there twice; a study has one view of a scene",
                    self.plan
                )));
            }
            if !configurations.iter().any(|c| c.is_for(name)) {
                return Err(Error::input(format!(
                    "plan {}: none of its configurations is for scene '{name}'; name one of those in their scenes, or write a plan",
                    self.plan
                )));
            }
        }
        if self.quick {
            plan.quicken();
        }
        Ok((plan, configurations))
    }
}

/// The description of a study, which is stored as `study.json` in its folder. With it, finished runs and
/// references are found without a device.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    version: u32,
    /// The request of the user, from which the plan and its configurations are made.
    pub request: Request,
    /// The name of the device that renders the study. Shards from different devices cannot be merged.
    pub device: String,
    /// The name and the version of the driver of the device. Shards from different drivers cannot be merged.
    pub driver: String,
    /// The commit of the program that renders the study. Shards from different commits cannot be merged.
    pub commit: String,
    /// The part of the work whose runs this folder contains.
    pub shard: Shard,
    /// The hashes of the scenes that were loaded so far, from which the keys of their runs and references are
    /// made.
    pub scenes: Vec<Identity>,
}

impl Manifest {
    /// Makes the manifest of a study that has not loaded any scene yet.
    pub fn new(request: Request, device: &str, driver: &str, shard: Shard) -> Self {
        Self {
            version: VERSION,
            request,
            device: device.to_owned(),
            driver: driver.to_owned(),
            commit: env!("HEADWATER_COMMIT").to_owned(),
            shard,
            scenes: Vec::new(),
        }
    }

    /// Reads the manifest from the file at `path`; `None` if there is no such file.
    ///
    /// # Errors
    /// The file cannot be read, or it is not a manifest of this version with a valid shard.
    pub fn read(path: &Path) -> Result<Option<Self>> {
        if !path.exists() {
            return Ok(None);
        }
        let text = input_files::read_text(path, input_files::MAX_TOML_BYTES)?;
        let unusable = |why: String| {
            Error::input(format!(
                "{}: {why}; delete this file, and the study goes on without it",
                path.display()
            ))
        };
        let manifest: Self = serde_json::from_str(&text)
            .map_err(|e| unusable(format!("this describes no study: {e}")))?;
        if manifest.version != VERSION {
            return Err(unusable(format!("its version is {}", manifest.version)));
        }
        if manifest.shard.index >= manifest.shard.count {
            return Err(unusable("its shard is not one of its shards".to_owned()));
        }
        Ok(Some(manifest))
    }

    /// Writes the manifest as JSON to the file at `path`, which it replaces.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)
            .map_err(|e| Error::failed(format!("the description of the study: {e}")))?;
        write_atomically(path, |file| writeln!(file, "{text}"))
    }

    /// The identity of the scene with this name; `None` if it was not loaded yet.
    pub fn identity(&self, scene: &str) -> Option<&Identity> {
        self.scenes.iter().find(|identity| identity.scene == scene)
    }

    /// Stores the identity of a scene that was loaded. Returns true if it is new or has changed, so that the
    /// manifest must be written again.
    pub fn remember(&mut self, identity: &Identity) -> bool {
        let known = self
            .scenes
            .iter()
            .position(|old| old.scene == identity.scene);
        match known {
            Some(index) if self.scenes[index] == *identity => return false,
            Some(index) => self.scenes[index] = identity.clone(),
            None => self.scenes.push(identity.clone()),
        }
        true
    }

    /// True if both studies render scenes under the same conditions: environment, bounces, device, driver and
    /// commit. Then the identities of the scenes in one manifest are also valid for the other.
    pub fn renders_like(&self, other: &Self) -> bool {
        let Request {
            environment,
            bounces,
            ..
        } = &other.request;
        let own = &self.request;
        (&own.environment, &own.bounces) == (environment, bounces)
            && (&self.device, &self.driver, &self.commit)
                == (&other.device, &other.driver, &other.commit)
    }

    /// The reason why the results of two studies cannot be joined, as a clause for a message, such as that
    /// they have different plans; `None` if they can be joined. The shards of the two studies are not
    /// compared.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let Request {
            plan: _,
            text,
            scenes,
            environment,
            bounces,
            quick,
        } = &other.request;
        let own = &self.request;
        let pairs = [
            ("plans", own.text == *text),
            ("scenes", own.scenes == *scenes),
            ("environments", own.environment == *environment),
            ("bounces", own.bounces == *bounces),
            ("values of --quick", own.quick == *quick),
            ("devices", self.device == other.device),
            ("drivers", self.driver == other.driver),
            ("versions of the program", self.commit == other.commit),
        ];
        if let Some((what, _)) = pairs.into_iter().find(|(_, same)| !same) {
            return Some(format!("they have different {what}"));
        }
        let changed = |identity: &&Identity| {
            other
                .identity(&identity.scene)
                .is_some_and(|o| o != *identity)
        };
        (self.scenes.iter().find(changed))
            .map(|identity| format!("scene {} or its shaders have changed", identity.scene))
    }
}

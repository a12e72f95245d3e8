//! The plan of a study: a TOML file that tells `headwater study` what to render. It describes scenes and configurations
//! (presets with changes), and states the numbers of seeds and samples.

use super::planned_scene::PlannedScene;
use super::plans::PLANS;
use super::product::Product;
use super::reference::SampleBlocks;
pub use super::resolved::{Expect, Resolved, rendered_on};
use crate::base::input_files;
use crate::base::nearest::nearest;
use crate::base::toml_text::{Step, TomlText};
use crate::render::presets::Preset;
use crate::render::{Clock, Settings};
use crate::{Error, Result};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

/// A study as the user describes it in a TOML file: what is rendered, how often, and what is expected. Each field except
/// `source` is a key of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// The question that the plan answers, in one sentence, which `study --list` prints.
    #[serde(default)]
    pub purpose: String,
    /// The scenes, each with its camera and environment. A configuration is rendered on all of them, unless it lists the
    /// names of some of them.
    pub scenes: Vec<PlannedScene>,
    /// The width of the pictures in pixels, by default 120. The height follows from the aspect ratio of each scene's camera.
    #[serde(default = "default_width")]
    pub width: u32,
    /// The number of frames that a run renders one after the other, with indices from 0; by default 1. The bias is measured
    /// in the mean of all frames if they show the same time and do not use earlier frames (no history, no accumulation);
    /// otherwise it is measured in the last frame.
    #[serde(default = "one")]
    pub frames: u32,
    /// The number of frames for each second of time in the scene: frame `i` shows the time `start_time` + `i` / `fps`.
    /// `None`: all frames show the time `start_time`.
    #[serde(default)]
    pub fps: Option<f64>,
    /// The time in the scene that frame 0 shows, in seconds; by default 0.
    #[serde(default)]
    pub start_time: f64,
    /// The number of runs of each configuration on each scene, at least 2 and by default 64. Each run has its own seed, so
    /// the noise of different runs is independent, and the mean of more runs has a smaller error.
    #[serde(default = "default_seeds")]
    pub seeds: u32,
    /// The maximum number of runs of a configuration on a scene. After `seeds` runs, more are rendered only if the
    /// configuration is expected to be unbiased and the interval of its bias is too wide for a proof. `None`: four times
    /// `seeds`.
    #[serde(default)]
    pub most_seeds: Option<u32>,
    /// The maximum number of scattering events of a path, by default 1. With 1 there is only direct light, with 2 or more
    /// also indirect light.
    #[serde(default = "one")]
    pub bounces: u32,
    /// The number of samples per pixel of the references (path-traced pictures that runs are compared with), at least 4 and
    /// by default 4096. More samples make the error of a reference smaller. A scene can have a number of its own.
    #[serde(default = "default_spp")]
    pub reference_spp: u32,
    /// The maximum number of samples per pixel of a reference. More than `reference_spp` are rendered only if a configuration
    /// is expected to be unbiased, and the mean of the reference is not known well enough for a proof. `None`: four times as
    /// many.
    #[serde(default)]
    pub most_reference_spp: Option<u32>,
    /// True if one additional run of each configuration on each scene counts rays, lanes in use and merged neighbours, so
    /// that results show the costs; by default false. This run is not timed, because counting takes time.
    #[serde(default)]
    pub count: bool,
    /// The configurations that the plan describes one by one. The list may be empty if there are sweeps.
    #[serde(default)]
    pub configurations: Vec<Configuration>,
    /// The sweeps. Each stands for many configurations: one for every combination of the values that it lists. The list may
    /// be empty if there are configurations that are described one by one.
    #[serde(default)]
    pub sweeps: Vec<Sweep>,
    /// True after [`Self::quicken`]: references get a quarter of their blocks of samples, and no more than
    /// these.
    #[serde(skip)]
    is_quick: bool,
    /// The text of the plan and its origin (a file or plan name), with which an error message can name a line.
    #[serde(skip)]
    pub source: TomlText,
}

/// The largest value that `seeds` and `most_seeds` may have in a plan; a plan with a larger one is refused. Controls (runs
/// of path tracing for comparison), and the runs that decide after a sign of bias, have seeds far above it, so that no seed
/// has two uses.
const MAX_SEEDS: u32 = 1 << 16;

/// The maximum number of samples per pixel of a reference in a plan. Each block of 1,024 samples is a file.
const MAX_REFERENCE_SAMPLES: u32 = 1 << 22;

/// The maximum number of frames of a run in a plan. Each run stores several numbers of each frame.
const MAX_FRAMES: u32 = 1 << 16;

/// The maximum number of configurations in a plan, including all combinations of its sweeps. A plan with more is refused
/// before the combinations take memory.
const MAX_CONFIGURATIONS: usize = 4096;

fn default_width() -> u32 {
    120
}

fn one() -> u32 {
    1
}

fn default_seeds() -> u32 {
    64
}

fn default_spp() -> u32 {
    4096
}

/// A configuration as the plan describes it: a preset with changes of its settings. A study renders it on scenes and judges
/// its error and bias.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Configuration {
    /// The name of the configuration in tables, unique in the plan.
    pub name: String,
    /// The name of the preset (a named set of settings) to which the changes in `set` are applied.
    pub preset: String,
    /// The settings that differ from those of the preset: new values by dotted key, such as `direct.mis`.
    #[serde(default)]
    pub set: Map<String, Value>,
    /// True if the picture that is measured after a frame is the mean of this frame and all frames before it; false (the
    /// default) if it is the frame alone.
    #[serde(default)]
    pub accumulate: bool,
    /// The names of the scenes of the plan on which the configuration is rendered. Empty: all scenes.
    #[serde(default)]
    pub scenes: Vec<String>,
    /// The verdict that the plan expects from the bias check. `None`: `unbiased` for resampling, and `any` for path tracing,
    /// which renders the references too.
    #[serde(default)]
    pub expect: Option<Expect>,
}

/// Describes many configurations: one for every combination of the values that `over` lists. The name of each consists of
/// its values, separated by slashes, such as `balance/temporal`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// The name of the preset (a named set of settings) to which the changes in `set` and `over` are applied.
    pub preset: String,
    /// The settings that differ from those of the preset and are equal in all configurations of the sweep: new values by
    /// dotted key, such as `direct.mis`.
    #[serde(default)]
    pub set: Map<String, Value>,
    /// The settings that differ between the configurations of the sweep: for each dotted key, such as `direct.mis`, the list
    /// of its values.
    pub over: Map<String, Value>,
    /// True if the picture that is measured after a frame is the mean of this frame and all frames before it; false (the
    /// default) if it is the frame alone.
    #[serde(default)]
    pub accumulate: bool,
    /// The names of the scenes of the plan on which the configurations of the sweep are rendered. Empty: all scenes.
    #[serde(default)]
    pub scenes: Vec<String>,
    /// The verdict that the plan expects from the bias check of each configuration of the sweep. `None`: `unbiased` for
    /// resampling, and `any` for path tracing, which renders the references too.
    #[serde(default)]
    pub expect: Option<Expect>,
}

impl Plan {
    /// Reads the plan that is part of the program and has the name `name`. If there is none, reads the plan from the file at
    /// the path `name`.
    ///
    /// # Errors
    /// There is no such plan or file, or as for [`Self::parse`].
    pub fn open(name: &str) -> Result<Self> {
        Self::parse(name, &Self::read(name)?)
    }

    /// The TOML text of the plan that [`Self::open`] reads.
    ///
    /// # Errors
    /// There is no such plan or file, or the file cannot be read.
    pub fn read(name: &str) -> Result<String> {
        if let Some((_, text)) = PLANS.iter().find(|(plan, _)| *plan == name) {
            return Ok((*text).to_owned());
        }
        let path = Path::new(name);
        if path.extension().is_none() && !path.exists() {
            let known = PLANS.iter().map(|(plan, _)| *plan);
            return Err(Error::input(format!(
                "no plan '{name}'{}; there are {}, or name a file",
                nearest(name, known.clone()),
                known.collect::<Vec<_>>().join(", ")
            )));
        }
        input_files::read_text(path, input_files::MAX_TOML_BYTES)
    }

    /// Reads a plan from TOML text. `origin` is the name of the text in error messages. The names and values of settings are
    /// checked only by [`Self::resolve`].
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown or missing, a number is out of range, or the plan has no scenes, or neither
    /// configurations nor sweeps.
    pub fn parse(origin: &str, text: &str) -> Result<Self> {
        let source = TomlText::new(origin, text);
        let plan = Self {
            source: source.clone(),
            ..source.parse()?
        };
        let wrong = |what: &str| Err(Error::input(format!("{origin}: {what}")));
        if plan.scenes.is_empty() {
            return wrong("scenes is empty; name at least one");
        }
        if plan.frames == 0 || plan.width == 0 || plan.seeds < 2 || plan.reference_spp < 4 {
            return wrong("frames and width begin at 1, seeds at 2, and reference_spp at 4");
        }
        if plan
            .scenes
            .iter()
            .any(|s| s.reference_spp.is_some_and(|spp| spp < 4))
        {
            return wrong("a scene's reference_spp begins at 4");
        }
        if plan.seeds.max(plan.most_seeds.unwrap_or(0)) > MAX_SEEDS {
            return wrong(&format!("seeds and most_seeds end at {MAX_SEEDS}"));
        }
        let own = plan.scenes.iter().filter_map(|scene| scene.reference_spp);
        let samples = own
            .chain(plan.most_reference_spp)
            .chain([plan.reference_spp]);
        if samples.max() > Some(MAX_REFERENCE_SAMPLES) {
            return wrong(&format!(
                "samples of references end at {MAX_REFERENCE_SAMPLES}"
            ));
        }
        if plan.frames > MAX_FRAMES {
            return wrong(&format!("frames ends at {MAX_FRAMES}"));
        }
        if plan.configurations.is_empty() && plan.sweeps.is_empty() {
            return wrong("it has neither configurations nor sweeps");
        }
        let named = |key: &str| format!("{origin}: {key}");
        plan.clock().check(&named("start_time"), &named("fps"))?;
        Ok(plan)
    }

    /// The map from the index of a frame to the time in the scene that the frame shows, as `start_time` and `fps` define it.
    pub fn clock(&self) -> Clock {
        Clock {
            start_time: self.start_time,
            fps: self.fps,
        }
    }

    /// Makes all configurations of the plan, with complete settings: first those that are described one by one, then those
    /// of the sweeps, both in the order of the plan.
    ///
    /// # Errors
    /// A preset, a setting or a configuration's scene is unknown; a value is out of range; a sweep has no values; there are
    /// too many configurations; settings of indirect light are changed although there is none; frames of different times
    /// would be accumulated; or two configurations have the same name.
    pub fn resolve(&self) -> Result<Vec<Resolved>> {
        let products = self.sweeps.iter().map(|sweep| Product::of(&sweep.over));
        let products: Vec<Product<'_>> =
            (products.collect::<std::result::Result<_, _>>()).map_err(|what| self.wrong(&what))?;
        let of_sweeps = (products.iter()).fold(0, |sum: usize, one| sum.saturating_add(one.count));
        let count = of_sweeps.saturating_add(self.configurations.len());
        if count > MAX_CONFIGURATIONS {
            return Err(self.wrong(&format!(
                "it has {count} configurations, and at most {MAX_CONFIGURATIONS} are possible; sweep over fewer values"
            )));
        }
        let own = self.configurations.iter().map(|c| &c.scenes);
        let named: BTreeSet<&str> = self.scenes.iter().map(|s| s.name.as_str()).collect();
        for scenes in own.chain(self.sweeps.iter().map(|sweep| &sweep.scenes)) {
            self.check_scenes(scenes, &named)?;
        }
        let mut all = Vec::new();
        for (index, c) in self.configurations.iter().enumerate() {
            let path = [Step::Key("configurations"), Step::Index(index)];
            let settings = self.settings(&path, &c.preset, &[("set", &c.set)])?;
            all.push(Resolved {
                name: c.name.clone(),
                expect: Expect::or_default(c.expect, &settings),
                settings,
                frames: self.frames,
                clock: self.clock(),
                accumulate: c.accumulate,
                count: self.count,
                scenes: c.scenes.clone().into(),
            });
        }
        for (index, (sweep, product)) in self.sweeps.iter().zip(products).enumerate() {
            let path = [Step::Key("sweeps"), Step::Index(index)];
            let scenes: Arc<[String]> = sweep.scenes.clone().into();
            for choice in (0..product.count).map(|index| product.choice(index)) {
                let values = choice
                    .values()
                    .map(|v| v.as_str().map_or(v.to_string(), str::to_owned));
                let name = values.collect::<Vec<_>>().join("/");
                let settings = self.settings(
                    &path,
                    &sweep.preset,
                    &[("set", &sweep.set), ("over", &choice)],
                )?;
                all.push(Resolved {
                    name,
                    expect: Expect::or_default(sweep.expect, &settings),
                    settings,
                    frames: self.frames,
                    clock: self.clock(),
                    accumulate: sweep.accumulate,
                    count: self.count,
                    scenes: Arc::clone(&scenes),
                });
            }
        }
        let accumulating = all.iter().find(|c| c.accumulate);
        if let Some(configuration) = accumulating.filter(|_| self.fps.is_some()) {
            return Err(self.wrong(&format!(
                "configuration '{}' accumulates frames of different times; leave out its accumulate, or fps",
                configuration.name
            )));
        }
        let mut names: Vec<&str> = all.iter().map(|c| c.name.as_str()).collect();
        names.sort_unstable();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(self.wrong(&format!("two configurations are named '{}'", pair[0])));
        }
        Ok(all)
    }

    /// The complete settings of a configuration: those of the preset with the name `preset`, to which all `changes` are
    /// applied in order. Each of `changes` is a pair: the name of a table of the configuration, such as `set`, and the new
    /// values in this table by dotted key. `path` is the place of the configuration in the plan's text, so that an error can
    /// name the line. Fails if the preset or a setting is wrong.
    fn settings(
        &self,
        path: &[Step<'_>],
        preset: &str,
        changes: &[(&str, &Map<String, Value>)],
    ) -> Result<Settings> {
        let preset =
            Preset::named(preset).map_err(|error| self.source.error_for(path, "preset", error))?;
        let mut settings = preset.settings()?;
        for (name, changes) in changes {
            let path = [path, &[Step::Key(name)]].concat();
            // They would all show the same, and pass for what is not there.
            if self.bounces < 2
                && let Some(key) = changes
                    .keys()
                    .find(|key| key.split('.').next() == Some("indirect"))
            {
                let error = Error::input(format!(
                    "the plan sets {key}, but with bounces {} there is no indirect light; it begins with 2",
                    self.bounces
                ));
                return Err(self.source.error_for(&path, key, error));
            }
            let changes = Value::Object((*changes).clone());
            settings = settings.with_toml(&self.source, &path, &changes)?;
        }
        Ok(settings)
    }

    /// Fails unless all names in `scenes`, which a configuration or a sweep lists, are among `named`, the names of the
    /// plan's scenes. A misspelt name would otherwise leave out a scene without notice.
    fn check_scenes(&self, scenes: &[String], named: &BTreeSet<&str>) -> Result<()> {
        let unknown = scenes.iter().find(|scene| !named.contains(scene.as_str()));
        unknown.map_or(Ok(()), |scene| {
            Err(self.wrong(&format!(
                "a configuration is for scene '{scene}', which is none of the plan's{}",
                nearest(scene, named.iter().copied())
            )))
        })
    }

    fn wrong(&self, what: &str) -> Error {
        Error::input(format!("{}: {what}", self.source.origin))
    }

    /// Divides the numbers of seeds by four, with a minimum of 2, and gives references a quarter of their blocks. The option
    /// `--quick` uses this for a preview: the study is faster, but with few seeds and noisy references its results prove
    /// nothing. A study without the option goes on with the same runs and blocks.
    pub fn quicken(&mut self) {
        self.most_seeds = Some(self.most_seeds());
        self.is_quick = true;
        for count in [Some(&mut self.seeds), self.most_seeds.as_mut()] {
            count
                .into_iter()
                .for_each(|count| *count = (*count / 4).max(2));
        }
    }

    /// The division of the samples of the references of `scene` into blocks, by the number of samples that
    /// the scene or the plan states.
    pub fn blocks(&self, scene: &PlannedScene) -> SampleBlocks {
        let samples = scene.reference_spp.unwrap_or(self.reference_spp);
        SampleBlocks::new(samples, self.is_quick)
    }

    /// The maximum number of blocks of a reference that is divided like `blocks`; see [`Self::most_reference_spp`]. With
    /// `--quick`, references get no more blocks.
    pub fn most_blocks(&self, blocks: SampleBlocks) -> u32 {
        let SampleBlocks { size, count } = blocks;
        let most = self
            .most_reference_spp
            .map_or(4 * count, |most| most / size);
        if self.is_quick {
            count
        } else {
            most.max(count)
        }
    }

    /// The dotted keys of all settings that the sweeps of the plan vary, in the order of the plan.
    pub fn swept_keys(&self) -> Vec<String> {
        let mut keys: Vec<String> = Vec::new();
        for key in self.sweeps.iter().flat_map(|sweep| sweep.over.keys()) {
            if !keys.contains(key) {
                keys.push(key.clone());
            }
        }
        keys
    }

    /// The maximum number of runs, on one scene, of a configuration that the plan expects to be unbiased: the plan's
    /// `most_seeds` or, if it is missing, four times `seeds`. It is never less than `seeds`. While the interval of the bias
    /// is too wide, runs are added up to this number.
    pub fn most_seeds(&self) -> u32 {
        self.most_seeds.unwrap_or(4 * self.seeds).max(self.seeds)
    }
}

#[cfg(test)]
mod tests;

//! A configuration that is ready to be rendered, and the verdict that its plan expects.

use crate::render::settings::Integrator;
use crate::render::{Clock, Settings};
use serde::Deserialize;
use std::sync::Arc;

/// A configuration that is ready to be rendered: a study makes its renderer and its runs from this value alone. Its settings
/// are complete, and it has copies of those values of the plan that its runs need.
#[derive(Clone, Debug)]
pub struct Resolved {
    /// The name of the configuration in tables, unique in the plan.
    pub name: String,
    /// All settings: those of the preset, to which the changes of the plan are applied.
    pub settings: Settings,
    /// The number of frames that a run renders one after the other, with indices from 0. The bias is measured in the mean of
    /// all frames if they show the same time and do not use earlier frames (no history, no accumulation); otherwise it is
    /// measured in the last frame.
    pub frames: u32,
    /// The map from the index of a frame to the time in the scene that the frame shows. Each frame is rendered, and compared
    /// with a reference, at its time.
    pub clock: Clock,
    /// True if the picture that is measured after a frame is the mean of this frame and all frames before it; false if it is
    /// the frame alone.
    pub accumulate: bool,
    /// True if one additional run on each scene counts rays, lanes in use and merged neighbours, so that results show the
    /// costs.
    pub count: bool,
    /// The names of the scenes on which the configuration is rendered. Empty: all scenes of the plan.
    pub scenes: Arc<[String]>,
    /// The verdict that the plan expects from the bias check. It decides which verdict makes the study fail, and whether
    /// more seeds are rendered.
    pub expect: Expect,
}

impl Resolved {
    /// True if the configuration is rendered on the scene with the name `scene`: if its list of scenes contains this name or
    /// is empty.
    pub fn is_for(&self, scene: &str) -> bool {
        self.scenes.is_empty() || self.scenes.iter().any(|name| name == scene)
    }
}

#[cfg(test)]
impl Resolved {
    /// A configuration with the name `a` and one frame, about which nothing is expected, for tests.
    pub fn of(settings: Settings) -> Self {
        Self {
            name: "a".into(),
            settings,
            frames: 1,
            clock: Clock {
                start_time: 0.0,
                fps: None,
            },
            accumulate: false,
            count: false,
            scenes: [].into(),
            expect: Expect::Any,
        }
    }
}

/// The configurations that are rendered on the scene with the name `scene`, in the order of the plan.
pub fn rendered_on<'a>(
    configurations: &'a [Resolved],
    scene: &'a str,
) -> impl Iterator<Item = &'a Resolved> {
    (configurations.iter()).filter(move |configuration| configuration.is_for(scene))
}

/// The verdict that a plan expects from the bias check of a configuration. It decides which verdict makes the study fail,
/// and whether more seeds are rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Expect {
    /// The plan expects that the configuration has no bias, and the study fails if the check finds one. If the interval of
    /// the bias is too wide for a proof, the study renders more seeds, up to `most_seeds`.
    Unbiased,
    /// The plan expects that the configuration has a bias. The study measures its size, and no verdict makes the study fail.
    Biased,
    /// The plan expects nothing about a bias of the configuration, and no verdict makes the study fail.
    Any,
}

impl Expect {
    /// The expectation `given` by the plan. Without it, the default of the integrator: `unbiased` for
    /// resampling, and `any` for path tracing, which also renders the references.
    pub(super) fn or_default(given: Option<Self>, settings: &Settings) -> Self {
        given.unwrap_or(match settings.integrator {
            Integrator::PathTracing => Self::Any,
            Integrator::Restir => Self::Unbiased,
        })
    }
}

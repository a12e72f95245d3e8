//! Loads the scenes of a study and uploads them to a device.

use super::kept;
use crate::Result;
use crate::commands::arguments::{parse_look_at, size_for};
use crate::commands::choices::{LoadArgs, TracerArg};
use crate::commands::interrupt::Interrupt;
use crate::commands::{apply_clock, notice};
use crate::device_scene::SceneSizes;
use crate::device_scene::selection::{self, Request};
use crate::gpu::{Device, DeviceInfo, Instance};
use crate::render::View;
use crate::scene::camera::{DEFAULT_ASPECT, framing_camera};
use crate::scene::{Camera, MovingCamera, Scene};
use crate::study::folder::Folder;
use crate::study::plan::{Plan, Resolved};
use crate::study::planned_scene::PlannedScene;
use crate::study::subject::Subject;
use crate::study::work::Site;
use std::sync::Arc;

/// The device on which the scenes of a study are opened, and the options with which they are loaded.
pub(super) struct Machine<'a> {
    pub(super) folder: &'a Folder,
    pub(super) instance: &'a Arc<Instance>,
    pub(super) info: &'a DeviceInfo,
    pub(super) load: &'a LoadArgs,
    pub(super) tracer: TracerArg,
}

impl Machine<'_> {
    /// Loads the scene of `site` with its camera and environment, and uploads it to the device, so that its
    /// runs can be rendered. If `is_first` is true, prints notices about the scene. Returns an error if
    /// loading or the device fails, or after a signal.
    pub(super) fn subject(
        &self,
        plan: &Plan,
        site: &Site<'_>,
        interrupt: &Interrupt,
        is_first: bool,
    ) -> Result<Subject> {
        let planned = site.planned;
        let name = &planned.name;
        let check = || match interrupt.pending() {
            None => Ok(()),
            Some(_) => interrupt.check(&kept(self.folder)),
        };
        let mut scene = Scene::open_watched(name, self.load.options(), &mut |_, _, _| check())?;
        scene.surround(planned.environment.as_deref())?;
        for text in scene.notices.iter().filter(|_| is_first) {
            notice(&format!("{name}: {text}"));
        }
        let clock = plan.clock();
        // As long as the scene moves: what does not shine now may do so at another time.
        if is_first {
            let scatters = |c: &&Resolved| c.settings.scatters_light(plan.bounces);
            let own = site.configurations;
            let frames = own.iter().map(|c| c.frames).max().unwrap_or(1);
            let times = (0..frames).map(|frame| clock.time(frame));
            if let Some(why) = scene.why_black(own.iter().any(scatters), times) {
                notice(&format!("{name}: {why}"));
            }
        }
        let prefix = format!("{name}: ");
        apply_clock(&clock, &mut scene, &prefix)?;
        let wanted = Request {
            tracer: self.tracer.tracer(),
            ..Request::default()
        };
        let selection = selection::select(self.info, wanted, &SceneSizes::of(&scene))?;
        let device = Device::open(self.instance, self.info.clone(), selection.features())?;
        let (camera, moving) = camera(planned, &scene, clock.start_time)?;
        let (width, height) = size_for(&camera, Some(plan.width), None)?;
        let view = View {
            camera,
            width,
            height,
            seed: 0,
            bounces: plan.bounces,
            jitter: false,
        };
        Subject::new(name, &scene, view, moving, &device, selection.variant)
    }
}

/// The camera that the key `look_at` of a scene in the plan (the TOML file of the study) describes; it replaces the
/// cameras of the scene. `None` if the scene has no such key. Returns an error if its text describes no camera.
pub(super) fn camera_override(planned: &PlannedScene) -> Result<Option<Camera>> {
    let origin = format!("{}: look_at", planned.name);
    (planned.look_at.as_deref())
        .map(|text| parse_look_at(&origin, text))
        .transpose()
}

/// The camera of a scene at `time`, in seconds: the one that the plan gives, else the scene's first one, else one that
/// sees the whole scene. The second value is the motion of the scene's first camera; it is `None` for the other two
/// cameras, which do not move.
fn camera(
    planned: &PlannedScene,
    scene: &Scene,
    time: f64,
) -> Result<(Camera, Option<MovingCamera>)> {
    if let Some(camera) = camera_override(planned)? {
        return Ok((camera, None));
    }
    if scene.cameras.is_empty() {
        return Ok((framing_camera(scene, DEFAULT_ASPECT), None));
    }
    let moving = MovingCamera::of(scene, 0);
    Ok((moving.at(time)?, Some(moving)))
}

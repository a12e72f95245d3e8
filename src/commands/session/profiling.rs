//! The functions of a session for the command `profile`: they measure the times and counts of frames, and describe the
//! run.

use super::Session;
use super::cameras::camera_text;
use crate::Result;
use crate::profile::{Circumstances, Frame, Plan, Subject, measure};
use crate::render::counters::Counts;
use crate::render::{Renderer, Tracking};

impl Session {
    /// Renders the frames of `plan`: first those of the warm-up, then those that are timed. Returns the times of all of them
    /// in this order. `watch` is called before each frame, and ends the work if it returns an error.
    ///
    /// # Errors
    /// The device fails, the scene cannot be rendered at a frame's time, or the errors of `watch`.
    pub fn profile(
        &mut self,
        plan: Plan,
        watch: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Vec<Frame>> {
        let (clock, camera) = (self.running_clock(), self.camera.as_ref());
        measure(
            &self.device,
            &mut self.renderer,
            plan,
            &mut |renderer, index| {
                watch()?;
                clock.map_or(Ok(()), |clock| {
                    renderer.set_moment(clock.time(index), camera)
                })
            },
        )
    }

    /// Counts the work of each pass in frame `index`, such as its rays; returns one entry per pass. A separate
    /// renderer, whose shaders count, renders frames 0 to `index` for this, because counting would make the timed
    /// frames slower. `watch` is called before each frame, and ends the work if it returns an error.
    pub fn counts_of(
        &self,
        index: u32,
        watch: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Vec<Counts>> {
        let tracking = Tracking {
            counts: true,
            coverage: self.has_alpha,
            ..Tracking::default()
        };
        let (device, scene) = (&self.device, self.gpu_scene.clone());
        let mut renderer = Renderer::tracking(device, scene, &self.view, &self.settings, tracking)?;
        for earlier in 0..=index {
            watch()?;
            if let Some(clock) = self.running_clock() {
                renderer.set_moment(clock.time(earlier), self.camera.as_ref())?;
            }
            // What was counted before the last frame is dropped.
            renderer.counts()?;
            renderer.single_frame(earlier)?;
        }
        renderer.counts()
    }

    /// The subject of a profile (what it measures): the scene, the settings, the device, the view, the clock, and the
    /// numbers of warm-up frames and of timed frames of `plan`. Two profiles are compared only if their subjects agree in
    /// all but the settings and the number of timed frames.
    ///
    /// # Errors
    /// A setting has no JSON form, which does not happen with finite values.
    pub fn subject(&self, plan: Plan) -> Result<Subject> {
        Ok(Subject {
            scene: self.scene_hash.clone(),
            settings: self.settings.to_value()?,
            device: self.device.info.name.clone(),
            width: self.view.width,
            height: self.view.height,
            bounces: self.view.bounces,
            seed: self.view.seed,
            camera: camera_text(&self.view.camera),
            clock: self.clock.map(|clock| (clock.start_time, clock.fps)),
            warm_up: plan.warm_up,
            frames: plan.frames,
        })
    }

    /// The conditions under which a profile is measured: driver, tracer, access of shaders to the scene, revision of the
    /// program, and number of frames in flight. They can explain why two profiles of the same scene and settings differ.
    /// Profiles are compared only if their numbers of frames in flight are equal; the other conditions may differ.
    pub fn circumstances(&self, plan: Plan) -> Circumstances {
        let variant = self.selection.variant;
        Circumstances {
            driver: self.device.info.driver.clone(),
            tracer: variant.tracer.name().into(),
            geometry: variant.geometry.name().into(),
            commit: env!("HEADWATER_COMMIT").into(),
            in_flight: plan.in_flight,
        }
    }
}

//! Makes the picture of a session, with its metadata, which describe the run so that it can be repeated or resumed, and
//! AOVs (arbitrary output variables: additional channels, such as depth).

use super::Session;
use super::cameras::camera_text;
use crate::commands::arguments::Aov;
use crate::commands::notice;
use crate::image::{Image, Samples};
use crate::render::outputs::Sums;
use crate::render::{Clock, Lighting, Settings};
use crate::shader_interface::{MAX_RADIANCE, ReservoirAov};
use crate::{Error, Result};

impl Session {
    /// Makes the picture from `sums`, the accumulated radiance of `samples` samples per pixel. Its channels `R`, `G`, `B`
    /// are the mean of the samples, or black for `samples` = 0; with `--alpha`, the channel `A` is the fraction of the samples
    /// whose primary ray met a surface. It also has metadata and the requested AOVs. Prints a notice if shaders rejected
    /// values, such as NaN.
    ///
    /// # Errors
    /// The device fails, or its driver ended loops in shaders early, so that the picture is wrong.
    pub fn picture(&mut self, sums: &Sums, samples: u32, aovs: &[Aov]) -> Result<Image> {
        let mut image = Image::new(self.view.width, self.view.height);
        let mean = sums.mean(samples.max(1));
        let values: Vec<_> = mean.iter().map(|p| p.as_vec3().to_array()).collect();
        image.set_vectors("", ["R", "G", "B"], &values);
        if let Some(alpha) = sums.alpha(samples.max(1)) {
            image.channels.insert("A".into(), Samples::F32(alpha));
            let key = "headwater.alpha".to_owned();
            image.metadata.insert(key, "true".to_owned());
        }
        if !aovs.is_empty() {
            self.add_aovs(&mut image, aovs)?;
        }
        self.rejected = self.renderer.rejected_by_pass()?;
        for (pass, count) in &self.rejected {
            notice(&format!(
                "pass {pass}: {count} values were refused because they were NaN, negative or beyond {MAX_RADIANCE:e} times the brightest light"
            ));
        }
        let settings = self.settings.to_value()?.to_string();
        let info = &self.device.info;
        for (key, value) in [
            ("scene", self.scene_hash.clone()),
            ("settings", settings),
            ("device", info.name.clone()),
            ("driver", info.driver.clone()),
            ("tracer", self.selection.variant.tracer.name().into()),
            ("commit", env!("HEADWATER_COMMIT").into()),
            ("seed", self.view.seed.to_string()),
            ("bounces", self.view.bounces.to_string()),
            ("jitter", self.view.jitter.to_string()),
            ("camera", camera_text(&self.view.camera)),
            ("samples", samples.to_string()),
        ] {
            image.metadata.insert(format!("headwater.{key}"), value);
        }
        if let Some(shaders) = &self.edited_shaders {
            (image.metadata).insert("headwater.shaders".to_owned(), shaders.clone());
        }
        if let Some(Clock { start_time, fps }) = self.clock {
            let fps = fps.map(|fps| ("fps", fps));
            for (key, value) in fps.into_iter().chain([("start_time", start_time)]) {
                let (key, value) = (format!("headwater.{key}"), format!("{value:?}"));
                image.metadata.insert(key, value);
            }
        }
        Ok(image)
    }

    fn add_aovs(&mut self, image: &mut Image, aovs: &[Aov]) -> Result<()> {
        let surfaces = if aovs.iter().any(|aov| aov.reservoirs_of().is_none()) {
            self.renderer.primary_surfaces()?
        } else {
            Vec::new()
        };
        for aov in aovs {
            match aov {
                Aov::Direct => self.add_reservoir_aovs(image, Lighting::Direct)?,
                Aov::Indirect => self.add_reservoir_aovs(image, Lighting::Indirect)?,
                Aov::Albedo => {
                    let values: Vec<_> = surfaces.iter().map(|s| s.albedo.to_array()).collect();
                    image.set_vectors("albedo.", ["R", "G", "B"], &values);
                }
                Aov::Normal => {
                    let values: Vec<_> = surfaces.iter().map(|s| s.normal.to_array()).collect();
                    image.set_vectors("normal.", ["X", "Y", "Z"], &values);
                }
                Aov::Depth => {
                    let values = surfaces.iter().map(|s| s.depth).collect();
                    image
                        .channels
                        .insert("depth.Z".into(), Samples::F32(values));
                }
                Aov::Motion => {
                    for (axis, name) in ["motion.X", "motion.Y"].into_iter().enumerate() {
                        let values = surfaces.iter().map(|s| s.motion[axis]).collect();
                        image.channels.insert(name.into(), Samples::F32(values));
                    }
                }
                Aov::Instance => {
                    let values = surfaces.iter().map(|s| s.instance).collect();
                    image
                        .channels
                        .insert("instance.id".into(), Samples::U32(values));
                }
            }
        }
        Ok(())
    }

    fn add_reservoir_aovs(&self, image: &mut Image, lighting: Lighting) -> Result<()> {
        let reservoirs = self.renderer.reservoir_aovs(lighting)?;
        let mut add = |name: &str, samples| {
            let name = format!("{}.{name}", lighting.name());
            image.channels.insert(name, samples);
        };
        let floats =
            |value: fn(&ReservoirAov) -> f32| Samples::F32(reservoirs.iter().map(value).collect());
        add("weight", floats(|r| r.weight));
        add("confidence", floats(|r| r.confidence));
        add("age", floats(|r| r.age as f32));
        add("neighbours", floats(|r| r.neighbours as f32));
        add("source.X", floats(|r| r.source.x));
        add("source.Y", floats(|r| r.source.y));
        add("jacobian", floats(|r| r.jacobian));
        let lights = reservoirs.iter().map(|r| r.light).collect();
        add("light", Samples::U32(lights));
        Ok(())
    }
}

/// Returns an error if one of `aovs` shows reservoirs that do not exist with these settings and with `bounces`, the
/// maximum number of scattering events of a path. It is called before the scene is loaded, so that such a run ends at
/// once.
pub(super) fn check_aovs(aovs: &[Aov], settings: &Settings, bounces: u32) -> Result<()> {
    for (lighting, needed) in [
        (Lighting::Direct, "--bounces of at least 1"),
        (
            Lighting::Indirect,
            "indirect.mode=restir, --bounces of at least 2",
        ),
    ] {
        let shows = |aov: &Aov| aov.reservoirs_of() == Some(lighting);
        if aovs.iter().any(shows) && !settings.has_reservoirs(lighting, bounces) {
            return Err(Error::input(format!(
                "--aov {} shows reservoirs, of which there are none; they come of render with a --preset of integrator=restir, {needed}",
                lighting.name()
            )));
        }
    }
    Ok(())
}

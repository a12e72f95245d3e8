//! Finds the channels that are the picture itself, in pictures that other programs wrote. Such files can have several layers
//! (groups of channels whose names begin with the layer's name and a dot), or only a grey channel.

use super::{Image, Samples};
use crate::{Error, Result};

/// The colour of each pixel of an image, the name of the layer that it comes from, and whether it comes from a grey channel.
/// `headwater compare` compares the colours, and prints a note about a layer or a grey channel, so that the user sees what
/// was compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Colors {
    /// Red, green and blue of each pixel, row by row from the top, in the unit of the file. Grey is repeated in all three.
    pub pixels: Vec<[f32; 3]>,
    /// The name of the layer that holds the channels, which is the part of their names before the last dot; `None` for
    /// channels `R`, `G`, `B` or `Y` without a layer.
    pub layer: Option<String>,
    /// True if the picture comes from a single grey channel `Y`, and false if it comes from `R`, `G` and `B`.
    pub is_grey: bool,
}

impl Image {
    /// Finds the channels that are the picture itself. These are `R`, `G`, `B` without a layer, or else those of a layer
    /// that has all three. If several layers have them, the first layer that is called `Combined`, `beauty` or `rgba` is
    /// taken, and otherwise the first layer. If no layer has them, a grey channel `Y` is found in the same way. A `Y` whose layer also
    /// has `X`, `RY` or `BY` is not grey. Integers become floats.
    ///
    /// # Errors
    /// No layer has these channels; the message lists the channels.
    pub fn colors(&self) -> Result<Colors> {
        let color = self.layer_of(&["R", "G", "B"], &[]);
        // A Y is not grey if its layer also has X (a vector), or RY or BY (colour).
        let grey = || self.layer_of(&["Y"], &["X", "RY", "BY"]);
        let (layer, names) = match color {
            Some(layer) => (layer, ["R", "G", "B"]),
            None => match grey() {
                Some(layer) => (layer, ["Y"; 3]),
                None => {
                    return Err(Error::input(format!(
                        "it has neither channels R, G, B nor Y, but {}",
                        self.listed()
                    )));
                }
            },
        };
        let mut pixels = vec![[0.0; 3]; self.pixels()];
        for (axis, name) in names.iter().enumerate() {
            match self.channels.get(&joined(layer, name)) {
                Some(Samples::F32(values)) => {
                    (pixels.iter_mut().zip(values)).for_each(|(pixel, value)| pixel[axis] = *value);
                }
                Some(Samples::U32(values)) => (pixels.iter_mut().zip(values))
                    .for_each(|(pixel, value)| pixel[axis] = *value as f32),
                None => {}
            }
        }
        Ok(Colors {
            pixels,
            layer: Some(layer.to_owned()).filter(|layer| !layer.is_empty()),
            is_grey: names[0] == "Y",
        })
    }

    /// Finds the layer that has channels with all of `names` and with none of `others`, and returns its name. Channels
    /// without a layer are taken first; the returned name is then empty. Otherwise it is the first layer that fits and whose
    /// name `is_main` accepts or, without one, the first layer that fits. The result is `None` if no layer fits.
    fn layer_of(&self, names: &[&str], others: &[&str]) -> Option<&str> {
        let fitting = || {
            self.channels.keys().filter_map(|channel| {
                let layer = channel.strip_suffix(names[0])?;
                let layer = layer.strip_suffix('.').or(layer.is_empty().then_some(""))?;
                let has = |name: &&str| self.channels.contains_key(&joined(layer, name));
                (names.iter().all(has) && !others.iter().any(has)).then_some(layer)
            })
        };
        (fitting().find(|layer| layer.is_empty()))
            .or_else(|| fitting().find(|layer| is_main(layer)))
            .or_else(|| fitting().next())
    }

    fn listed(&self) -> String {
        let names: Vec<&str> = self.channels.keys().map(String::as_str).collect();
        names.join(", ")
    }
}

/// True if the last part of a layer's name is a usual name of the picture itself, in any letter case: `Combined`, as in
/// Blender's `ViewLayer.Combined`, `beauty` or `rgba`.
pub(super) fn is_main(layer: &str) -> bool {
    let last = layer.rsplit('.').next().unwrap_or_default();
    ["combined", "beauty", "rgba"].contains(&&*last.to_ascii_lowercase())
}

fn joined(layer: &str, name: &str) -> String {
    if layer.is_empty() {
        name.to_owned()
    } else {
        format!("{layer}.{name}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Samples;

    fn image(channels: &[&str]) -> Image {
        let mut image = Image::new(1, 1);
        for (value, name) in channels.iter().enumerate() {
            let samples = Samples::F32(vec![value as f32]);
            image.channels.insert((*name).to_owned(), samples);
        }
        image
    }

    #[test]
    fn the_picture_is_found_among_layers() {
        for (channels, layer, pixel) in [
            (
                &["R", "G", "B", "stderr.R", "stderr.G", "stderr.B"][..],
                None,
                [0.0, 1.0, 2.0],
            ),
            (&["A", "L.R", "L.G", "L.B"], Some("L"), [1.0, 2.0, 3.0]),
            (
                &[
                    "V.Combined.R",
                    "V.Combined.G",
                    "V.Combined.B",
                    "V.Env.R",
                    "V.Env.G",
                    "V.Env.B",
                ],
                Some("V.Combined"),
                [0.0, 1.0, 2.0],
            ),
            (&["A", "Y"], None, [1.0; 3]),
            (
                &["normal.X", "normal.Y", "normal.Z", "V.Y"],
                Some("V"),
                [3.0; 3],
            ),
            // The first of several layers, unless the name of another one says that it is the picture.
            (
                &["A.R", "A.G", "A.B", "C.R", "C.G", "C.B"],
                Some("A"),
                [0.0, 1.0, 2.0],
            ),
            (
                &[
                    "A.R",
                    "A.G",
                    "A.B",
                    "C.Beauty.R",
                    "C.Beauty.G",
                    "C.Beauty.B",
                ],
                Some("C.Beauty"),
                [3.0, 4.0, 5.0],
            ),
        ] {
            let found = image(channels).colors().unwrap();
            assert_eq!(found.pixels, [pixel], "{channels:?}");
            assert_eq!(found.layer.as_deref(), layer, "{channels:?}");
            assert_eq!(found.is_grey, pixel[0] == pixel[1]);
        }
    }

    #[test]
    fn what_is_no_picture_is_listed() {
        for channels in [
            &["depth.Z", "normal.X", "normal.Y", "normal.Z"][..],
            &["Y", "RY", "BY"],
            &["R", "G"],
        ] {
            let error = image(channels).colors().unwrap_err();
            assert_eq!(error.exit_status(), 2);
            for channel in channels {
                assert!(error.to_string().contains(channel), "{error}");
            }
        }
    }
}

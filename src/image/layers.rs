//! Finds the channels that are the picture itself, in pictures that other programs wrote. Such files can have several layers
//! (groups of channels whose names begin with the layer's name and a dot), or only a grey channel.

use super::Image;
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
    /// Finds the channels that are the picture itself. These are `R`, `G`, `B` without a layer, or else those of the only
    /// layer that has all three. If several layers have them, those of the layer Combined are taken, as Blender writes
    /// `ViewLayer.Combined.R`. If no layer has them, a grey channel `Y` is found in the same way. A `Y` whose layer also has
    /// `X`, `RY` or `BY` is not grey.
    ///
    /// # Errors
    /// No layer has these channels, or several layers have them and not exactly one of these is called Combined; the message
    /// lists the channels.
    pub fn colors(&self) -> Result<Colors> {
        let color = self.layer_of(&["R", "G", "B"], &[])?;
        // A Y is not grey if its layer also has X (a vector), or RY or BY (subsampled colour).
        let grey = || self.layer_of(&["Y"], &["X", "RY", "BY"]);
        let (layer, names) = match color {
            Some(layer) => (layer, ["R", "G", "B"]),
            None => match grey()? {
                Some(layer) => (layer, ["Y"; 3]),
                None => {
                    return Err(Error::input(format!(
                        "it has neither channels R, G, B nor Y, but {}",
                        self.listed()
                    )));
                }
            },
        };
        let channel = |name: &str| self.floats(&joined(&layer, name)).unwrap_or_default();
        let [r, g, b] = names.map(channel);
        let pixels = r.iter().zip(g).zip(b);
        Ok(Colors {
            pixels: pixels.map(|((r, g), b)| [*r, *g, *b]).collect(),
            layer: Some(layer).filter(|layer| !layer.is_empty()),
            is_grey: names[0] == "Y",
        })
    }

    /// Finds the layer that has float channels with all of `names` and with none of `others`, and returns its name. Channels
    /// without a layer are taken first; the returned name is then empty. Otherwise the only layer that fits is taken or, if
    /// several fit, the only one of them that is called Combined. The result is `None` if no layer fits, and an error if
    /// several fit and this rule does not decide.
    fn layer_of(&self, names: &[&str], others: &[&str]) -> Result<Option<String>> {
        let layers = self.channels.keys().filter_map(|channel| {
            let layer = channel.strip_suffix(names[0])?;
            let layer = layer.strip_suffix('.').or(layer.is_empty().then_some(""))?;
            let has = |name: &&str| self.floats(&joined(layer, name)).is_some();
            (names.iter().all(has) && !others.iter().any(has)).then_some(layer)
        });
        let layers: Vec<&str> = layers.collect();
        let is_combined = |layer: &&&str| layer.rsplit('.').next() == Some("Combined");
        let combined: Vec<&&str> = layers.iter().filter(is_combined).collect();
        match (layers.as_slice(), combined.as_slice()) {
            ([], _) => Ok(None),
            (all, _) if all.contains(&"") => Ok(Some(String::new())),
            ([only], _) => Ok(Some((*only).to_owned())),
            (_, [only]) => Ok(Some((**only).to_owned())),
            _ => Err(Error::input(format!(
                "it has no channels R, G, B of its own, and which of its layers is the picture cannot be told: it has {}",
                self.listed()
            ))),
        }
    }

    fn listed(&self) -> String {
        let names: Vec<&str> = self.channels.keys().map(String::as_str).collect();
        names.join(", ")
    }
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
            &["A.R", "A.G", "A.B", "C.R", "C.G", "C.B"],
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

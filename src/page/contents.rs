//! The contents of a page, as plain data.

use serde::{Deserialize, Serialize};

/// Linear RGB radiance: one value per pixel, row by row from the top.
pub type Picture = Vec<[f32; 3]>;

/// The contents of a page: the settings that were compared on one scene, and the answer that follows.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Page {
    /// The question that the page answers, as its title.
    pub title: String,
    /// The relative link to the page of all scenes; `None` if there is no such page.
    pub overview: Option<String>,
    /// The answer.
    pub answer: Answer,
    /// The compared settings, the advised ones first.
    pub points: Vec<Point>,
    /// The index of path tracing in [`Self::points`], with which the others are compared.
    pub yardstick: Option<usize>,
    /// The width and the height that the times of the points hold for, in pixels.
    pub timed_size: (u32, u32),
    /// The width and the height of all pictures, in pixels.
    pub size: (u32, u32),
    /// The reference: the picture that all settings approximate.
    pub reference: Picture,
    /// The conditions of the measurement, as names and values.
    pub facts: Vec<(String, String)>,
}

/// The answer in words. Words between backticks are shown as code.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Answer {
    /// True if the first point of the page is advised, and false if too little is known.
    pub is_decided: bool,
    /// The answer.
    pub sentence: String,
    /// The conditions of the numbers in the answer.
    pub details: String,
}

/// The measurements of one choice of settings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Point {
    /// The name of the settings.
    pub name: String,
    /// The settings that differ from those of the default preset, as TOML.
    pub settings: String,
    /// The command that renders with these settings.
    pub command: String,
    /// The time of a frame in milliseconds, > 0.
    pub milliseconds: f64,
    /// True if the time was measured at the size of the pictures that it is for, and does not follow from smaller ones.
    pub is_timed: bool,
    /// The error of a typical frame: the root of its relMSE, ≥ 0.
    pub error: f64,
    /// The lower and the upper end of the 95 % interval of the error, if it is known.
    pub interval: Option<[f64; 2]>,
    /// The bias of the mean as a fraction of the reference, and the half-width of its 95 % interval.
    pub bias: (f64, f64),
    /// The error divided by that of path tracing which had the same time, and the ends of the 95 % interval of this ratio, if
    /// it was measured. If it is `None`, the page computes the ratio from the errors and the times of the two points.
    #[serde(default)]
    pub at_equal_time: Option<(f64, [f64; 2])>,
    /// The number of independent runs from which error and bias were computed.
    pub seeds: usize,
    /// The result of the comparison for these settings.
    pub standing: Standing,
    /// Pictures and further numbers, if they were recorded.
    pub exhibit: Option<Exhibit>,
}

/// The result of a comparison for one choice of settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// These settings are advised.
    Advised,
    /// They were compared until the end.
    Finalist,
    /// They were left out early, so their numbers are less certain.
    LeftOut,
    /// Most lit pixels are dark, so these settings cannot be advised, however small their error is.
    Empty,
    /// The mean is certain to differ from that of the reference, so these settings cannot be advised.
    Biased,
}

/// Pictures and numbers of one choice of settings, all measured at the size of the page's pictures.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Exhibit {
    /// One late frame.
    pub picture: Picture,
    /// The error (root of the relMSE) of each frame, beginning with frame 0, as the geometric mean over [`Self::runs`] runs. Empty if it
    /// was not measured.
    pub errors: Vec<f64>,
    /// The number of independent runs with which this exhibit was measured.
    pub runs: u32,
    /// The time of each pass of a frame, by its name, in milliseconds, in the order of the frame.
    pub passes: Vec<(String, f64)>,
    /// The flicker: the root of the mean squared difference of successive frames of a camera at rest, each divided by
    /// b² + 0.01 where b is the reference, as for relMSE. `None` if the camera moves, or if there is one frame only.
    pub flicker: Option<FrameMap>,
    /// The power of the relative error in each band of spatial frequencies, relative to white noise. The bands divide the
    /// frequencies from 0 to 0.5 cycles per pixel evenly.
    pub spectrum: Vec<f64>,
    /// The power below 0.125 cycles per pixel, relative to white noise: 1 for errors that are independent of each other.
    pub low_frequencies: f64,
    /// The samples that neighbouring pixels share, for each kind of reservoir. Empty if there are none; `None` if it was not
    /// measured.
    pub shared: Option<Vec<Shared>>,
}

/// A quantity of a picture as one number, and as one value per pixel, row by row from the top.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FrameMap {
    /// The number for the whole picture.
    pub value: f64,
    /// The values of the pixels, ≥ 0.
    pub pixels: Vec<f32>,
}

/// Samples that neighbouring pixels share.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Shared {
    /// The name of the light in the reservoirs: `direct` or `indirect`.
    pub lighting: String,
    /// The fraction of the 24 pixels around a pixel that have its sample, in [0, 1].
    pub fraction: FrameMap,
}

impl Page {
    /// For each point, true if it is on the Pareto front: no other point has a smaller or equal error in at most the same time.
    /// Points with an empty picture do not count.
    pub fn front(&self) -> Vec<bool> {
        let counts = |point: &Point| point.standing != Standing::Empty;
        let beats = |a: &Point, b: &Point| {
            let at_most = a.milliseconds <= b.milliseconds && a.error <= b.error;
            at_most && (a.milliseconds < b.milliseconds || a.error < b.error)
        };
        let is_on_front = |point: &Point| {
            counts(point)
                && !self
                    .points
                    .iter()
                    .any(|other| counts(other) && beats(other, point))
        };
        self.points.iter().map(is_on_front).collect()
    }
}

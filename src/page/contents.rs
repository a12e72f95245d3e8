//! The contents of an HTML page that compares settings on one scene, as plain data: texts, numbers and
//! pictures. [`Page::html`] makes the text of the file from them.

use serde::{Deserialize, Serialize};

/// Linear RGB radiance: one value per pixel, row by row from the top.
pub type Picture = Vec<[f32; 3]>;

/// All that an HTML page shows about one scene: the settings that were compared on it with their measurements
/// and pictures, and the answer to the question which settings to use.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Page {
    /// The title of the page: the question that the page answers. Words between backticks are shown as code.
    pub title: String,
    /// The relative link to the page that lists all scenes of a study; `None` if there is no such page.
    pub overview: Option<String>,
    /// The answer to the question, which the page shows first.
    pub answer: Answer,
    /// The compared settings with their measurements, the best first. They are the rows of the page's table.
    /// If the answer is decided, the first point is the advised one.
    pub points: Vec<Point>,
    /// The index in [`Self::points`] of path tracing, with which the page compares the other settings at
    /// equal time. `None` if path tracing is not among them.
    pub yardstick: Option<usize>,
    /// The width and the height, in pixels, of the frames to which the times of the points apply. They can be
    /// larger than [`Self::size`].
    pub timed_size: (u32, u32),
    /// The width and the height of all pictures and maps of the page, in pixels.
    pub size: (u32, u32),
    /// The reference picture, of [`Self::size`] pixels: all settings approximate it, and the page shows how
    /// their pictures differ from it.
    pub reference: Picture,
    /// The conditions of the measurement, such as the device and the driver, as pairs of a name and a value,
    /// which the page lists at its end.
    pub facts: Vec<(String, String)>,
}

/// The answer of a page in words. The page shows words between backticks as code.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Answer {
    /// `true` if the first point of the page is advised; `false` if the measurements are not sufficient to
    /// advise any point. The page then shows "Undecided".
    pub is_decided: bool,
    /// The answer as one or more sentences: the advised settings with their time and error, or the reason why
    /// nothing is advised.
    pub sentence: String,
    /// The definition of the error, and the conditions under which it was measured, such as the size of the
    /// pictures. The page shows them below the answer.
    pub details: String,
}

/// One choice of settings with its measurements: a row of the page's table, and a mark in its plots.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Point {
    /// The name of the settings, which the table and the plots show.
    pub name: String,
    /// The settings that differ from those of the default preset, as TOML text that the option `--config`
    /// reads.
    pub settings: String,
    /// The command line that renders a picture with these settings, which the user can copy.
    pub command: String,
    /// The time of a frame on the device, in milliseconds, > 0, at [`Page::timed_size`].
    pub milliseconds: f64,
    /// True if [`Self::milliseconds`] was measured in frames of [`Page::timed_size`] pixels; false if it was
    /// computed from the time of smaller frames.
    pub is_timed: bool,
    /// The error of a typical frame: the root of its relMSE, ≥ 0.
    pub error: f64,
    /// The lower and the upper end of the 95 % confidence interval of [`Self::error`]; `None` if they are not
    /// known.
    pub interval: Option<[f64; 2]>,
    /// The bias of the mean as a fraction of the reference, positive if the pictures are too bright, and the
    /// half-width of its 95 % interval. The half-width is infinite if the bias is not known.
    pub bias: (f64, f64),
    /// The error divided by the error of path tracing in the same time, and the lower and upper end of the
    /// 95 % interval of this ratio; below 1, these settings are better. If it is `None`, the page computes
    /// the ratio from the errors and the times of the two points.
    #[serde(default)]
    pub at_equal_time: Option<(f64, [f64; 2])>,
    /// The number of independent runs, each with its own seed, from which the error and the bias were
    /// computed.
    pub seeds: usize,
    /// The result of the comparison for these settings: advised, compared to the end, or excluded for a
    /// reason.
    pub standing: Standing,
    /// Pictures and further numbers, which the page shows when the user selects the point; `None` if they
    /// were not recorded.
    pub exhibit: Option<Exhibit>,
}

/// The result of a comparison for one choice of settings. The page shows it in the table, and marks the point
/// by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// The answer of the page advises these settings.
    Advised,
    /// These settings were compared until the end, but they are not the advised ones.
    Finalist,
    /// These settings were left out of the comparison early, because others were better. Their numbers are
    /// less certain.
    LeftOut,
    /// Most pixels that are lit in the reference are too dark, so these settings cannot be advised, even if
    /// their error is small.
    Empty,
    /// The pictures are biased: it is certain that their mean differs from that of the reference. These
    /// settings cannot be advised.
    Biased,
}

/// Pictures and numbers of one choice of settings, which the page shows when the user selects the point. They
/// were measured at the size of the page's pictures; only the times of the passes can be scaled to another
/// size.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Exhibit {
    /// The picture of one frame, the last of its run, or the mean of all frames for settings that accumulate.
    /// It has one RGB value per pixel, row by row from the top.
    pub picture: Picture,
    /// The error (root of the relMSE) of each frame, beginning with frame 0, as the mean over [`Self::runs`]
    /// runs. Empty if it was not measured.
    pub errors: Vec<f64>,
    /// The number of independent runs over which [`Self::errors`] is averaged.
    pub runs: u32,
    /// The passes in the order in which they run: the name of each, and its time in milliseconds. The sum of
    /// all times is the time of the point.
    pub passes: Vec<(String, f64)>,
    /// The flicker: the root of the mean squared difference of successive frames of a camera at rest. Each
    /// difference is divided by the root of b² + 0.01, where b is the reference, as for relMSE. `None` if it
    /// was not measured, for example because the camera moves or there is only one frame.
    pub flicker: Option<FrameMap>,
    /// The power of the relative error in each band of spatial frequencies, relative to white noise. The bands divide the
    /// frequencies from 0 to 0.5 cycles per pixel evenly.
    pub spectrum: Vec<f64>,
    /// The power below 0.125 cycles per pixel, relative to white noise. It is 1 for errors that are
    /// independent from pixel to pixel, and larger for blotches.
    pub low_frequencies: f64,
    /// The fraction of samples that neighbouring pixels have in common, for each kind of reservoir (direct
    /// and indirect). Empty if the settings use no reservoirs; `None` if it was not measured.
    pub shared: Option<Vec<Shared>>,
}

/// A quantity of a picture, such as its flicker: one number for the whole picture, and one value per pixel.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FrameMap {
    /// The number that summarises all pixels: their mean, or for the flicker their root mean square.
    pub value: f64,
    /// The values of the pixels, ≥ 0, row by row from the top; the page shows them as a map.
    pub pixels: Vec<f32>,
}

/// The fraction of samples that neighbouring pixels have in common after reuse, for one kind of light. A
/// large fraction means that the errors of these pixels are correlated.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Shared {
    /// The kind of light in the reservoirs: `direct` or `indirect`.
    pub lighting: String,
    /// The fraction of the 24 pixels around a pixel that have its sample, in [0, 1].
    pub fraction: FrameMap,
}

impl Page {
    /// For each point, true if it is on the Pareto front of time and error: no other point is at least as
    /// good in both and better in one of them. Points with the standing [`Standing::Empty`] are not on the
    /// front and are not compared.
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

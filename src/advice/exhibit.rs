//! Exhibits: the pictures and further numbers of the candidates that an HTML page shows, such as the error of
//! each frame and the flicker. Most of them are recorded from chains that the race renders anyway. Only the
//! samples that pixels share need chains of their own.

use super::candidates::Candidate;
use super::chain::{Course, Observer, Purpose, logarithms};
use super::truth::Truth;
use crate::Result;
use crate::gpu::PassTime;
use crate::metrics::sharing::shared_samples;
use crate::metrics::spectrum::Spectrum;
use crate::metrics::statistics::{Estimate, median};
use crate::page::contents::{Exhibit, FrameMap, Picture, Shared};
use crate::render::{Lighting, Renderer};
use crate::shader_interface::ReservoirAov;

/// Number of chains (sequences of frames with one seed) per candidate that are recorded for the pictures and
/// numbers on a page. Recording more chains would take time without a visible effect.
const RECORDED_CHAINS: u32 = 8;
/// Number of pixels, summed over the pictures of a candidate, after which no further picture is added to the
/// spectrum of its error. The spectrum then has a relative error of about 1 %.
const SPECTRUM_PIXELS: usize = 1 << 20;

/// The exhibits (pictures and further numbers) of all candidates of a race, which a page shows.
#[derive(Default)]
pub struct Gallery {
    /// The mean of the two references: linear RGB radiance, one value per pixel, row by row from the top.
    pub reference: Picture,
    /// The recorded candidates, each with its exhibit (pictures and further numbers); the finalists come
    /// first.
    pub exhibits: Vec<(Candidate, Exhibit)>,
}

impl Gallery {
    /// The exhibit (pictures and further numbers) of `candidate`; `None` if nothing was recorded for this
    /// candidate.
    pub fn of(&self, candidate: &Candidate) -> Option<&Exhibit> {
        let mut all = self.exhibits.iter();
        all.find(|(own, _)| own == candidate)
            .map(|(_, exhibit)| exhibit)
    }
}

/// Records the frames of one candidate's chains, and computes the candidate's [`Exhibit`] from them.
pub struct Recorder {
    purpose: Purpose,
    /// Width and height of the frames, in pixels.
    size: (usize, usize),
    /// Number of chains (sequences of frames with one seed) that were recorded to their last frame.
    chains: u32,
    /// The frame that was recorded last: linear RGB radiance, one value per pixel, row by row from the top.
    /// The flicker is computed from its difference to the next frame.
    last: Picture,
    /// The relMSE of each recorded frame, together with the index of the frame, counted from 0 for each seed.
    /// Empty unless the purpose is [`Purpose::Steady`], because only then the references show the picture of
    /// every frame.
    errors: Vec<(u32, f64)>,
    /// Times on the device for each recorded frame: the name of each pass, and the sum of the times of its
    /// runs in milliseconds. The first of several frames is left out, because it has no history and so less
    /// work.
    passes: Vec<Vec<(String, f64)>>,
    /// The squared relative change of each pixel from one frame to the next, summed over `pairs` pairs of
    /// frames; one value per pixel. The flicker is computed from it.
    changes: Vec<f32>,
    pairs: u32,
    spectrum: Spectrum,
}

impl Recorder {
    /// Makes an empty recorder for the frames of a candidate. `purpose` decides the number of frames per
    /// seed, and `size` is (width, height) of the frames in pixels.
    pub fn new(purpose: Purpose, size: (u32, u32)) -> Self {
        Self {
            purpose,
            size: (size.0 as usize, size.1 as usize),
            chains: 0,
            last: Picture::new(),
            errors: Vec::new(),
            passes: Vec::new(),
            changes: Vec::new(),
            pairs: 0,
            spectrum: Spectrum::default(),
        }
    }

    /// Removes all recorded data, so that the exhibit shows only chains that are recorded later, in the
    /// final.
    pub fn clear(&mut self) {
        *self = Self::new(self.purpose, (self.size.0 as u32, self.size.1 as u32));
    }

    /// True if further frames are to be recorded; false if enough seeds were recorded for the exhibit on the
    /// page.
    pub fn wants_more(&self) -> bool {
        self.chains < RECORDED_CHAINS
    }

    /// Computes the exhibit from the recorded frames; `None` if no chain is complete. The samples that pixels
    /// share are not part of it ([`Exhibit::shared`] is `None`).
    pub fn exhibit(&self) -> Option<Exhibit> {
        (self.chains > 0).then(|| Exhibit {
            picture: self.last.clone(),
            errors: self.errors(),
            runs: self.chains,
            passes: self.passes(),
            flicker: self.flicker(),
            spectrum: self.spectrum.bands(),
            low_frequencies: self.spectrum.low(),
            shared: None,
        })
    }

    /// The error (root of the relMSE) of each frame of a chain, as the geometric mean over the chains. A
    /// candidate without history does not render all frames; each missing frame then has the error of the
    /// last one. Empty unless the purpose is [`Purpose::Steady`].
    fn errors(&self) -> Vec<f64> {
        let mean = |frame: u32| {
            let own = self.errors.iter().filter(|(index, _)| *index == frame);
            let own: Vec<f64> = own.map(|(_, relmse)| *relmse).collect();
            let log = Estimate::of(&logarithms(&own)).mean;
            (!own.is_empty()).then(|| (0.5 * log).exp())
        };
        let frames = self.purpose.frames();
        let Some(last) = mean(frames - 1) else {
            return Vec::new();
        };
        (0..frames)
            .map(|frame| mean(frame).unwrap_or(last))
            .collect()
    }

    fn passes(&self) -> Vec<(String, f64)> {
        let frame = self.passes.iter().max_by_key(|frame| frame.len());
        let of = |name: &str| {
            let all = self.passes.iter().flatten();
            median(
                all.filter(|(own, _)| own == name)
                    .map(|(_, milliseconds)| *milliseconds),
            )
        };
        let names = frame.into_iter().flatten();
        names.map(|(name, _)| (name.clone(), of(name))).collect()
    }

    fn flicker(&self) -> Option<FrameMap> {
        let pairs = f64::from(self.pairs);
        let sum: f64 = self.changes.iter().copied().map(f64::from).sum();
        (self.pairs > 0).then(|| FrameMap {
            value: (sum / (self.changes.len() as f64 * pairs)).sqrt(),
            pixels: (self.changes.iter())
                .map(|change| (f64::from(*change) / pairs).sqrt() as f32)
                .collect(),
        })
    }
}

impl Observer for Recorder {
    fn frame(&mut self, index: u32, passes: &[PassTime], picture: &[[f32; 3]], truth: &Truth) {
        let is_last = index + 1 == self.purpose.frames();
        if index > 0 || is_last {
            self.passes.push(sums(passes));
        }
        // A camera at rest shows the reference in all frames, a moving one only in the last frame.
        let is_steady = self.purpose == Purpose::Steady;
        if is_steady {
            let relmse = truth.observe(picture).relmse;
            self.errors.push((index, relmse));
        }
        // A frame of path tracing is independent of all others, so that of another chain can come before it.
        if is_steady && self.purpose.is_measured(index) && !self.last.is_empty() {
            let changes = truth.relative_squares(picture, &self.last);
            self.changes.resize(picture.len(), 0.0);
            for (sum, change) in self.changes.iter_mut().zip(changes) {
                *sum += change;
            }
            self.pairs += 1;
        }
        if is_last {
            if self.chains as usize * picture.len() < SPECTRUM_PIXELS {
                let [first, second] = truth.relative_differences(picture);
                self.spectrum.add([&first, &second], self.size);
            }
            self.chains += 1;
        }
        self.last = picture.to_vec();
    }
}

/// The times of a frame in milliseconds: one entry per pass name, with the sum over the runs of this pass.
/// The entries are in the order in which the names first occur.
fn sums(passes: &[PassTime]) -> Vec<(String, f64)> {
    let mut sums: Vec<(String, f64)> = Vec::new();
    for pass in passes {
        match sums.iter_mut().find(|(name, _)| *name == pass.name) {
            Some((_, sum)) => *sum += pass.milliseconds,
            None => sums.push((pass.name.clone(), pass.milliseconds)),
        }
    }
    sums
}

/// Renders the frames of a chain with the seed `seed`, and measures which fraction of the neighbouring pixels
/// share a sample in the reservoirs of the last frame. `kinds` selects the reservoirs (direct or indirect
/// light); the result has one entry for each, in this order. `renderer` must store the origins of samples.
/// `width` is the width of the frames in pixels.
///
/// # Errors
/// The device fails, or the scene cannot be rendered at the time of a frame.
pub fn shared(
    renderer: &mut Renderer,
    course: &Course,
    seed: u32,
    kinds: &[Lighting],
    width: u32,
) -> Result<Vec<Shared>> {
    renderer.restart(seed)?;
    for frame in 0..course.purpose.frames() {
        course.set(renderer, frame)?;
        renderer.single_frame(frame)?;
    }
    let of = |lighting: &Lighting| {
        let reservoirs = renderer.reservoir_aovs(*lighting)?;
        // A pixel and the frame in which it drew a sample identify the sample.
        let origin = |r: &ReservoirAov| {
            (r.weight > 0.0 && r.source.x >= 0.0).then_some((
                r.source.x as u32,
                r.source.y as u32,
                r.age,
            ))
        };
        let origins: Vec<_> = reservoirs.iter().map(origin).collect();
        let fractions = shared_samples(&origins, width as usize);
        let known = fractions.iter().flatten();
        let (sum, count) = known.fold((0.0, 0.0), |(s, n), f| (s + f64::from(*f), n + 1.0));
        Ok(Shared {
            lighting: lighting.name().to_owned(),
            fraction: FrameMap {
                value: sum / f64::max(count, 1.0),
                pixels: fractions.iter().map(|f| f.unwrap_or(0.0)).collect(),
            },
        })
    };
    kinds.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Random;

    const SIZE: (u32, u32) = (24, 16);

    /// A grey picture with radiance 1. With `random`, each pixel has an independent error of +20 % or −20 %.
    fn picture(random: Option<&mut Random>) -> Picture {
        let mut picture = vec![[1.0; 3]; (SIZE.0 * SIZE.1) as usize];
        if let Some(random) = random {
            for pixel in &mut picture {
                *pixel = [if random.unit() < 0.5 { 0.8 } else { 1.2 }; 3];
            }
        }
        picture
    }

    fn pass(name: &str, milliseconds: f64) -> PassTime {
        PassTime {
            name: name.to_owned(),
            milliseconds,
            start: 0.0,
            first_run: false,
        }
    }

    /// The exhibit that is recorded from four chains. In each chain, the frames with the indices `frames` are
    /// rendered, with independent errors.
    fn exhibit(purpose: Purpose, frames: std::ops::Range<u32>) -> Exhibit {
        let truth = Truth::new([picture(None), picture(None)], &[vec![], vec![]], 64);
        let mut recorder = Recorder::new(purpose, SIZE);
        let mut random = Random::new(3);
        assert!(recorder.exhibit().is_none());
        for _ in 0..4 {
            for index in frames.clone() {
                let passes = [
                    pass("spatial", 2.0),
                    pass("shade", 1.0),
                    pass("spatial", 3.0),
                ];
                recorder.frame(index, &passes, &picture(Some(&mut random)), &truth);
            }
        }
        recorder.exhibit().unwrap()
    }

    #[test]
    fn independent_frames_flicker_by_the_root_of_two() {
        // A chain of path tracing is its last frame alone.
        for frames in [0..16, 15..16] {
            let exhibit = exhibit(Purpose::Steady, frames);
            assert_eq!((exhibit.runs, exhibit.errors.len()), (4, 16));
            // The square of 0.2, divided by 1.01.
            assert!(exhibit.errors.iter().all(|e| (e - 0.199).abs() < 1e-3));
            let flicker = exhibit.flicker.unwrap();
            assert!(
                (flicker.value / 0.199 - 2_f64.sqrt()).abs() < 0.1,
                "{}",
                flicker.value
            );
            assert_eq!(flicker.pixels.len(), exhibit.picture.len());
            assert_eq!(
                exhibit.passes,
                [("spatial".to_owned(), 5.0), ("shade".to_owned(), 1.0)]
            );
            assert!(
                (exhibit.low_frequencies - 1.0).abs() < 0.5,
                "{}",
                exhibit.low_frequencies
            );
        }
    }

    #[test]
    fn frames_without_a_reference_have_neither_errors_nor_flicker() {
        for purpose in [Purpose::Still, Purpose::Motion] {
            let exhibit = exhibit(purpose, 0..purpose.frames());
            assert!(exhibit.errors.is_empty() && exhibit.flicker.is_none());
            assert_eq!(exhibit.passes.len(), 2);
        }
    }
}

//! `--capture`: the loop over frames that a capture tool watches. Each frame ends with a presented picture.

use super::interrupt::Interrupt;
use super::progress::Progress;
use super::session::Session;
use crate::gpu::Presentation;
use crate::image::png;
use crate::render::outputs::display::Display;
use crate::{Error, Result};
use std::path::Path;
use std::str::FromStr;

/// A range of frames, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    first: u32,
    last: u32,
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let numbers = text.split_once("..").and_then(|(first, last)| {
            let (first, last) = (first.parse().ok()?, last.parse().ok()?);
            (first <= last).then_some(Self { first, last })
        });
        numbers.ok_or_else(|| {
            "frames are given as N..M, both included and counted from 0, such as 2..4".to_owned()
        })
    }
}

impl FrameRange {
    /// Refuses ranges that are not rendered.
    ///
    /// # Errors
    /// There are fewer frames than `frames`.
    pub fn check(&self, frames: u32) -> Result<()> {
        if self.last >= frames {
            return Err(Error::input(format!(
                "--capture {}..{}: --frames {frames} ends with frame {}",
                self.first,
                self.last,
                frames - 1
            )));
        }
        Ok(())
    }

    fn contains(&self, number: u32) -> bool {
        (self.first..=self.last).contains(&number)
    }
}

/// The tool that records the frames.
enum Tool {
    /// RenderDoc, which is notified of the beginning and the end of frames.
    RenderDoc(renderdoc::Watcher),
    /// A layer that records all calls; it finds the frames by the pictures that are presented.
    Layer,
}

/// The state of showing frames to a capture tool.
struct Capture<'a> {
    wanted: &'a CapturePlan<'a>,
    tool: Tool,
    display: Display,
    presentation: Option<Presentation>,
}

impl<'a> Capture<'a> {
    /// Finds the tool.
    ///
    /// # Errors
    /// No tool is loaded, or the tool needs presented pictures, which the device does not support.
    fn new(session: &Session, wanted: &'a CapturePlan<'a>) -> Result<Self> {
        let layers = session.device.tools();
        let tool = match renderdoc::Watcher::find() {
            Some(watcher) => Tool::RenderDoc(watcher),
            None if !layers.is_empty() => Tool::Layer,
            None => {
                return Err(Error::input(
                    "--capture: neither RenderDoc nor the layer of GFXReconstruct is loaded; tools/capture starts Headwater with one of them",
                ));
            }
        };
        log::info!(
            "captured by: {}",
            match &tool {
                Tool::RenderDoc(_) => "RenderDoc".to_owned(),
                Tool::Layer => layers.join(", "),
            }
        );
        let size = (session.view.width, session.view.height);
        let presentation = match Presentation::new(&session.device, size) {
            Ok(presentation) => Some(presentation),
            // It takes its frames without.
            Err(_) if matches!(tool, Tool::RenderDoc(_)) => None,
            Err(error) => {
                return Err(Error::failed(format!(
                    "--capture: {error}; take another driver, or RenderDoc, which needs no presented pictures"
                )));
            }
        };
        Ok(Self {
            wanted,
            tool,
            display: session.renderer.display()?,
            presentation,
        })
    }

    /// Renders and presents a frame.
    ///
    /// # Errors
    /// The device, the tool or the disk fails.
    fn frame(&mut self, session: &mut Session, number: u32) -> Result<()> {
        let CapturePlan {
            range,
            accumulate,
            exposure,
            folder,
            ..
        } = *self.wanted;
        let captured = range.contains(number);
        if let (true, Tool::RenderDoc(watcher)) = (captured, &mut self.tool) {
            watcher.begin();
        }
        let presentation = self.presentation.as_ref();
        let begins_with_blue = presentation.is_some_and(Presentation::begins_with_blue);
        {
            let _label = session.device.label(&format!("frame {number}"));
            session.frame(number, accumulate)?;
            (session.renderer).show(&self.display, exposure, begins_with_blue)?;
            if let Some(presentation) = presentation {
                presentation.present(number, &self.display.pixels)?;
            }
        }
        if !captured {
            return Ok(());
        }
        if let Tool::RenderDoc(watcher) = &mut self.tool {
            let file = watcher.end()?;
            super::print(format_args!("frame {number}: {}", file.display()))?;
        }
        let Some(folder) = folder else {
            return Ok(());
        };
        let (width, height) = (session.view.width, session.view.height);
        let words: Vec<u32> = self.display.pixels.read(width as usize * height as usize)?;
        let rgb: Vec<u8> = (words.iter())
            .flat_map(|word| {
                let [mut red, green, mut blue, _] = word.to_le_bytes();
                if begins_with_blue {
                    std::mem::swap(&mut red, &mut blue);
                }
                [red, green, blue]
            })
            .collect();
        let path = folder.join(format!("frame_{number:04}.png"));
        png::write_bytes(&path, (width, height), &rgb)
    }
}

/// The frames that are rendered under a capture tool.
pub struct CapturePlan<'a> {
    /// The frames that it captures.
    pub range: FrameRange,
    /// Number of frames.
    pub frames: u32,
    /// True if the frames add up.
    pub accumulate: bool,
    /// Exposure of the presented pictures, in stops.
    pub exposure: f32,
    /// The folder for the presented pictures of captured frames.
    pub folder: Option<&'a Path>,
}

/// Renders every frame, one after the other. Afterwards the sums hold the last frame, or with
/// [`accumulate`](CapturePlan::accumulate) all.
///
/// # Errors
/// No tool is loaded, or it needs presented pictures, which the device does not support; a device, tool or disk that fails, or
/// a signal.
pub fn render(
    session: &mut Session,
    wanted: &CapturePlan<'_>,
    interrupt: &Interrupt,
) -> Result<()> {
    let mut capture = Capture::new(session, wanted)?;
    let progress = Progress::new(Some(u64::from(wanted.frames)), "frames");
    for number in 0..wanted.frames {
        interrupt.check("captured frames stay, and no picture was written")?;
        capture.frame(session, number)?;
        progress.at(f64::from(number + 1));
    }
    progress.finish();
    match wanted.accumulate {
        true => Ok(()),
        false => session.renderer.keep_single_frame(),
    }
}

#[cfg(not(any(target_os = "macos", target_os = "ios")))]
mod renderdoc {
    use crate::{Error, Result};
    use renderdoc::{RenderDoc, V120};
    use std::path::PathBuf;

    /// RenderDoc, as it is loaded into this process.
    pub struct Watcher {
        renderdoc: RenderDoc<V120>,
        /// The number of captures before the one that began last.
        before: u32,
    }

    impl Watcher {
        /// RenderDoc, if a layer or the loader has loaded it.
        pub fn find() -> Option<Self> {
            RenderDoc::new().ok().map(|renderdoc| Self {
                renderdoc,
                before: 0,
            })
        }

        /// Starts a capture.
        pub fn begin(&mut self) {
            self.before = self.renderdoc.get_num_captures();
            // Null pointers stand for the only device and any window.
            (self.renderdoc).start_frame_capture(std::ptr::null(), std::ptr::null());
        }

        /// Ends a capture; returns the file.
        ///
        /// # Errors
        /// RenderDoc has captured nothing.
        pub fn end(&mut self) -> Result<PathBuf> {
            (self.renderdoc).end_frame_capture(std::ptr::null(), std::ptr::null());
            // If it failed, the last one is still that of an earlier frame.
            let last = self.renderdoc.get_num_captures().checked_sub(1);
            let last = last.filter(|last| *last >= self.before);
            let capture = last.and_then(|last| self.renderdoc.get_capture(last));
            let captured = capture.map(|(file, _)| file);
            captured.ok_or_else(|| Error::failed("RenderDoc captured nothing; its log says why"))
        }
    }
}

#[cfg(any(target_os = "macos", target_os = "ios"))]
mod renderdoc {
    use crate::Result;
    use std::path::PathBuf;

    /// The watcher on a system without RenderDoc.
    pub enum Watcher {}

    impl Watcher {
        pub fn find() -> Option<Self> {
            None
        }
        pub fn begin(&mut self) {}
        pub fn end(&mut self) -> Result<PathBuf> {
            match *self {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_include_both_ends() {
        let range: FrameRange = "1..3".parse().unwrap();
        let inside: Vec<u32> = (0..6).filter(|number| range.contains(*number)).collect();
        assert_eq!(inside, [1, 2, 3]);
        assert!(range.check(4).is_ok() && range.check(3).is_err());
        for wrong in ["", "3", "3..1", "a..b", "1...3", "-1..2", "..", "1..=3"] {
            assert!(wrong.parse::<FrameRange>().is_err(), "{wrong}");
        }
    }
}

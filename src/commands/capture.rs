//! `--capture`: renders frames for a capture tool, RenderDoc or GFXReconstruct. Each frame is presented to a swapchain
//! without a window, because GFXReconstruct recognises the end of a frame by this. RenderDoc works without it.

use super::interrupt::Interrupt;
use super::progress::Progress;
use super::session::Session;
use crate::gpu::Presentation;
use crate::image::png;
use crate::render::outputs::display::Display;
use crate::{Error, Result};
use std::path::Path;
use std::str::FromStr;

/// The range of frames that a tool captures, parsed from a text such as `2..4`. Indices count from 0, and both ends are
/// included. Frames outside of the range are rendered too, because later frames can reuse their samples.
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
    /// Checks that every frame of this range is rendered, because a frame that is not rendered cannot be captured. `frames`
    /// is the number of frames that the run renders, at least 1.
    ///
    /// # Errors
    /// The range ends after the last rendered frame.
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

    fn contains(&self, index: u32) -> bool {
        (self.first..=self.last).contains(&index)
    }
}

/// The capture tool that is loaded into this process. The kind of tool decides how the program marks where a frame begins
/// and ends.
enum Tool {
    /// RenderDoc is loaded. The program calls its interface at the beginning and at the end of each captured frame.
    RenderDoc(renderdoc::Watcher),
    /// A Vulkan layer that records all calls of the program is loaded, such as that of GFXReconstruct. It recognises the
    /// end of a frame by the presented picture.
    Layer,
}

/// The state of the loop that renders and presents frames for a capture tool: the plan, the tool, and the buffer and
/// swapchain of the presented pictures.
struct Capture<'a> {
    wanted: &'a CapturePlan<'a>,
    tool: Tool,
    display: Display,
    presentation: Option<Presentation>,
}

impl<'a> Capture<'a> {
    /// Finds out which capture tool is loaded, and prepares the presentation of pictures.
    ///
    /// # Errors
    /// No tool is loaded, the tool needs presented pictures and the device cannot present them, or the device fails.
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

    /// Renders frame `index`, counted from 0, and presents its picture. If the tool captures this frame and the plan names a
    /// folder, also writes the picture to a PNG file in the folder.
    ///
    /// # Errors
    /// The device or the tool fails, the scene cannot be rendered at the time of the frame, or the picture cannot be
    /// written.
    fn frame(&mut self, session: &mut Session, index: u32) -> Result<()> {
        let CapturePlan {
            range,
            accumulate,
            exposure,
            folder,
            ..
        } = *self.wanted;
        let captured = range.contains(index);
        if let (true, Tool::RenderDoc(watcher)) = (captured, &mut self.tool) {
            watcher.begin();
        }
        let presentation = self.presentation.as_ref();
        let begins_with_blue = presentation.is_some_and(Presentation::begins_with_blue);
        {
            let _label = session.device.label(&format!("frame {index}"));
            session.frame(index, accumulate)?;
            (session.renderer).show(&self.display, exposure, begins_with_blue)?;
            if let Some(presentation) = presentation {
                presentation.present(index, &self.display.pixels)?;
            }
        }
        if !captured {
            return Ok(());
        }
        if let Tool::RenderDoc(watcher) = &mut self.tool {
            let file = watcher.end()?;
            super::print(format_args!("frame {index}: {}", file.display()))?;
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
        let path = folder.join(format!("frame_{index:04}.png"));
        png::write_bytes(&path, (width, height), &rgb)
    }
}

/// A run for a capture tool: the frames that are rendered and captured, the exposure of the presented
/// pictures, and the folder to which these are written.
pub struct CapturePlan<'a> {
    /// The frames that the tool captures. Frames outside of this range are rendered and presented too.
    pub range: FrameRange,
    /// The number of frames that are rendered, also those that are not captured; their indices begin with 0.
    pub frames: u32,
    /// If true, the radiance of every frame is added to the renderer's sums of radiance, so that the picture is the mean of
    /// all frames. If false, these sums contain only the last frame at the end.
    pub accumulate: bool,
    /// Exposure of the presented pictures, in stops: radiance is multiplied by 2^`exposure`.
    pub exposure: f32,
    /// The path of an existing folder to which the presented picture of each captured frame is written as a PNG file; with
    /// `None`, none is written.
    pub folder: Option<&'a Path>,
}

/// Renders every frame of the plan `wanted`, one after the other. Afterwards the renderer's sums of radiance hold the last
/// frame, or with [`accumulate`](CapturePlan::accumulate) the sum of all frames.
///
/// # Errors
/// No tool is loaded; the tool needs presented pictures and the device cannot present them; the device, the tool or the
/// disk fails; or a signal was received.
pub fn render(
    session: &mut Session,
    wanted: &CapturePlan<'_>,
    interrupt: &Interrupt,
) -> Result<()> {
    let mut capture = Capture::new(session, wanted)?;
    let progress = Progress::new(Some(u64::from(wanted.frames)), "frames");
    for index in 0..wanted.frames {
        interrupt.check("captured frames stay, and no picture was written")?;
        capture.frame(session, index)?;
        progress.at(f64::from(index + 1));
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

    /// RenderDoc's interface in this process. It starts and ends captures of frames.
    pub struct Watcher {
        renderdoc: RenderDoc<V120>,
        /// The number of captures that RenderDoc had made when [`Self::begin`] was last called. If the number is larger at
        /// [`Self::end`], the capture has succeeded.
        before: u32,
    }

    impl Watcher {
        /// Finds RenderDoc's interface; `None` if RenderDoc is not loaded into this process, neither as a Vulkan layer
        /// nor by the system's loader.
        pub fn find() -> Option<Self> {
            RenderDoc::new().ok().map(|renderdoc| Self {
                renderdoc,
                before: 0,
            })
        }

        /// Starts the capture of a frame on the process's only Vulkan device.
        pub fn begin(&mut self) {
            self.before = self.renderdoc.get_num_captures();
            // Null pointers stand for the only device and any window.
            (self.renderdoc).start_frame_capture(std::ptr::null(), std::ptr::null());
        }

        /// Ends the capture of the frame and returns the path of the capture file.
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

    /// Takes the place of RenderDoc's interface on systems that RenderDoc does not support. The type has no values, because
    /// RenderDoc is never found there.
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
        let inside: Vec<u32> = (0..6).filter(|index| range.contains(*index)).collect();
        assert_eq!(inside, [1, 2, 3]);
        assert!(range.check(4).is_ok() && range.check(3).is_err());
        for wrong in ["", "3", "3..1", "a..b", "1...3", "-1..2", "..", "1..=3"] {
            assert!(wrong.parse::<FrameRange>().is_err(), "{wrong}");
        }
    }
}

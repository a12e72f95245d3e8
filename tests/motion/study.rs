//! Tests of studies of scenes that move: each frame is compared with a reference of the same time and camera.

use crate::{playroom, support};
use headwater::metrics::error::Errors;
use headwater::render::{Clock, Settings, View};
use headwater::scene::{MovingCamera, Scene};
use headwater::study::bias;
use headwater::study::library::Library;
use headwater::study::plan::{Expect, Resolved};
use headwater::study::reference::{References, SampleBlocks};
use headwater::study::subject::{Subject, path_tracing};

const FRAMES: u32 = 4;
const FRAMES_A_SECOND: f64 = 4.0;
/// Number of samples per pixel of references and of the control.
const SAMPLES: u32 = 256;

/// The configuration of path tracing with one sample per pixel and frame.
fn configuration() -> Resolved {
    Resolved {
        name: "path tracing".into(),
        settings: Settings::default(),
        frames: FRAMES,
        clock: Clock {
            start_time: 0.25,
            fps: Some(FRAMES_A_SECOND),
        },
        accumulate: false,
        count: false,
        scenes: [].into(),
        expect: Expect::Unbiased,
    }
}

/// A study subject for a scene on the tests' device, and a library of its references in a temporary folder.
fn subject(scene: &Scene, bounces: u32) -> (tempfile::TempDir, Library, Subject) {
    let (device, selection) = support::open_device(None);
    let folder = tempfile::tempdir().unwrap();
    let camera = MovingCamera::of(scene, 0);
    let view = View {
        camera: camera.at(configuration().clock.time(0)).unwrap(),
        width: 48,
        height: 36,
        seed: 0,
        bounces,
        jitter: false,
    };
    let variant = selection.variant;
    let subject = Subject::new("scene", scene, view, Some(camera), &device, variant);
    let library = Library::new(folder.path().to_owned());
    (folder, library, subject.unwrap())
}

/// Renders the references of a configuration with `samples` samples per pixel each.
fn references(
    library: &mut Library,
    subject: &Subject,
    configuration: &Resolved,
    samples: u32,
) -> References {
    let blocks = SampleBlocks::new(samples, false);
    let settings = path_tracing(&configuration.settings);
    let identity = &subject.identity;
    for time in identity.times(configuration) {
        let key = identity.reference_key(&settings, time, blocks).unwrap();
        let files = library.files(&key, blocks, 0..blocks.count);
        let rendered = subject.render_reference(configuration, time, &files, &mut |_| Ok(()));
        rendered.unwrap();
    }
    let found = library.references(identity, configuration, blocks, blocks.count);
    found.unwrap().unwrap()
}

/// A scene with emission alone has no noise, so a frame must equal its own reference, and must differ from the references of
/// other frames.
#[test]
fn each_frame_is_measured_against_its_own_reference() {
    for moving in ["camera", "light", "toggle"] {
        let (_folder, mut library, mut subject) = subject(&playroom(&[moving], 1.0), 0);
        let configuration = configuration();
        let references = references(&mut library, &subject, &configuration, 4);
        let (run, _) = subject.run(&configuration, 7, &references, false).unwrap();
        assert_eq!(run.mse, [0.0; FRAMES as usize], "{moving}");
        for frame in 1..FRAMES {
            let [one, other] = [frame - 1, frame].map(|frame| &references.of(frame).mean);
            let rmse = Errors::between(one, other).rmse;
            assert!(rmse > 0.05, "{moving}: frame {frame} is like the last");
        }
    }
}

#[test]
fn a_control_shows_what_the_last_frame_shows() {
    let (_folder, mut library, mut subject) = subject(&playroom(&["camera", "object"], 4.0), 1);
    let configuration = configuration();
    let control = bias::control(&configuration, SAMPLES);
    let [references, own] = [&configuration, &control]
        .map(|configuration| references(&mut library, &subject, configuration, SAMPLES));
    assert!(references.differ() && !own.differ());
    assert!(std::ptr::eq(own.last(), references.last()));
    let (run, _) = subject.run(&control, 7, &own, false).unwrap();
    let rmse = run.mse[SAMPLES as usize - 1].max(0.0).sqrt();
    for frame in 0..FRAMES - 1 {
        let other = &references.of(frame).mean;
        let wrong = Errors::between(&own.last().mean, other).rmse;
        println!("off by {rmse:.4}, from frame {frame} by {wrong:.4}");
        assert!(wrong > 5.0 * rmse, "frame {frame}: {wrong} and {rmse}");
    }
}

#[test]
fn runs_at_other_times_are_other_runs() {
    let (_folder, _library, subject) = subject(&playroom(&["light"], 1.0), 0);
    let key = |clock: Clock| {
        let configuration = Resolved {
            clock,
            ..configuration()
        };
        let blocks = SampleBlocks::new(SAMPLES, false);
        (subject.identity).run_key(&configuration, blocks).unwrap()
    };
    let clock = configuration().clock;
    let others = [
        Clock { fps: None, ..clock },
        Clock {
            fps: Some(5.0),
            ..clock
        },
        Clock {
            start_time: 0.5,
            ..clock
        },
    ];
    for other in others {
        assert_ne!(key(clock), key(other), "{other:?}");
    }
}

//! Tests of the pages that compare settings, in a headless Chromium, with real clicks and keys.

/// Tests that start a browser, which is set up first.
mod thorough {
    use headwater::page::{Answer, Exhibit, FrameMap, Page, Point, Shared, Standing};
    use std::path::Path;
    use std::process::Command;

    /// The exit status of `tests/page/browse` on a machine that can have no browser.
    const NO_BROWSER: i32 = 77;

    /// A scene name that breaks pages which do not escape it.
    const HOSTILE: &str = "</script><script>document.title = 'broken'</script><b>scene</b>";

    const SIZE: (u32, u32) = (96, 64);

    /// A picture of stripes with errors of the size `error`.
    fn picture(error: f32) -> Vec<[f32; 3]> {
        let pixel = |i: u32| {
            let stripe = [0.1, 0.4, 0.9][(i % SIZE.0 / 32) as usize];
            // Errors of neighbouring pixels differ.
            let noise =
                error * (f32::from((i.wrapping_mul(2_654_435_761) >> 24) as u8) / 128.0 - 1.0);
            [stripe, 0.7 * stripe, 0.5 * stripe].map(|v| v * (1.0 + noise))
        };
        (0..SIZE.0 * SIZE.1).map(pixel).collect()
    }

    fn point(name: &str, milliseconds: f64, error: f64, standing: Standing) -> Point {
        let is_path_tracing = name == "path-tracing";
        let map = |value: f64| FrameMap {
            value,
            pixels: vec![value as f32; (SIZE.0 * SIZE.1) as usize],
        };
        let shared = |lighting: &str| Shared {
            lighting: lighting.to_owned(),
            fraction: map(0.1),
        };
        let exhibit = Exhibit {
            picture: picture(error as f32),
            errors: (0..16)
                .map(|i| error * (1.0 + 1.0 / f64::from(i + 1)))
                .collect(),
            runs: 4,
            passes: (0..10)
                .map(|i| (format!("pass_{i}"), 0.1 * milliseconds))
                .collect(),
            flicker: Some(map(1.4 * error)),
            spectrum: (0..16).map(|i| 1.0 + 1.0 / f64::from(i + 1)).collect(),
            low_frequencies: 1.5,
            shared: Some(match is_path_tracing {
                true => Vec::new(),
                false => vec![shared("direct"), shared("indirect")],
            }),
        };
        Point {
            name: name.to_owned(),
            settings: format!("# {name}\n"),
            command: format!("headwater render scene --preset {name} -o picture.exr"),
            milliseconds,
            is_timed: true,
            error,
            interval: Some([0.95 * error, 1.05 * error]),
            bias: (0.001, 0.002),
            at_equal_time: None,
            seeds: 8,
            standing,
            exhibit: (standing != Standing::LeftOut).then_some(exhibit),
        }
    }

    fn page() -> Page {
        let mut points = vec![
            point("balanced", 40.0, 0.12, Standing::Advised),
            point("path-tracing", 15.0, 0.6, Standing::Finalist),
            point("accurate", 80.0, 0.1, Standing::Finalist),
            point("fast", 30.0, 0.3, Standing::LeftOut),
        ];
        // One for each further colour, at almost one place.
        for (index, name) in ["fifth", "sixth", "seventh", "eighth"].iter().enumerate() {
            let milliseconds = 60.0 + index as f64;
            points.push(point(name, milliseconds, 0.3, Standing::LeftOut));
        }
        Page {
            title: format!("Which preset for `{HOSTILE}`?"),
            overview: None,
            answer: Answer {
                is_decided: true,
                sentence: "Use `balanced`: 40 ms per frame, error 12 % ± 1 %.".to_owned(),
                details: "Measured for a test.".to_owned(),
            },
            points,
            yardstick: Some(1),
            timed_size: (1920, 1080),
            size: SIZE,
            reference: picture(0.0),
            facts: vec![("Scene".to_owned(), HOSTILE.to_owned())],
        }
    }

    /// Runs `tests/page/clicks.py` on the page. It clicks through the page as a user would, and checks the effects. A machine
    /// that can have no browser skips this test with a note.
    #[test]
    fn a_page_does_what_its_user_wants() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("index.html");
        std::fs::write(&file, page().html().unwrap()).unwrap();
        let browse = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/page/browse");
        let status = Command::new(browse)
            .arg("clicks.py")
            .arg(&file)
            .status()
            .unwrap();
        if status.code() == Some(NO_BROWSER) {
            return;
        }
        assert!(status.success(), "the checks that failed are above");
    }
}

//! Writes a page as HTML. The template contains the answer and the table; scripts draw plots and pictures
//! from JSON data in the page.

use super::contents::{Exhibit, FrameMap, Page, Point, Standing};
use super::pictures::{Reduction, bytes, exposure, rgb9e5};
use crate::base::milliseconds;
use crate::metrics::flip::flip;
use crate::{Error, Result};
use minijinja::value::{Serde, Value as Text};
use minijinja::{Environment, HtmlEscape};
use rayon::prelude::*;
use serde_json::{Value, json};

/// The maximum size of all pictures of a page together, in bytes of base64 text. If they are larger, all of
/// them are reduced by one factor.
const MOST_PICTURE_BYTES: f64 = 12e6;

/// The number of bytes of base64 text per pixel of a picture, which is stored as RGB9E5 (4 bytes per pixel).
const PICTURE_BYTES: f64 = 16.0 / 3.0;
/// The number of bytes of base64 text per pixel of a map, which is stored with one byte per pixel.
const MAP_BYTES: f64 = 4.0 / 3.0;

impl Page {
    /// The text of the HTML file, which needs no other file: at most 15 MB. Pictures that are too large for this are
    /// reduced, and the page says so.
    ///
    /// # Errors
    /// A picture does not have the size of the page, or a number is not finite.
    pub fn html(&self) -> Result<String> {
        let mut environment = Environment::new();
        environment.add_filter("code", code);
        let reduction = Reduction::to(self.size, self.most_pixels());
        let (width, height) = reduction.reduced_size();
        let data = self.data(reduction)?.to_string();
        environment
            .render_named_str(
                "page.html",
                include_str!("page.html"),
                Serde(json!({
                    "title": self.title,
                    "overview": self.overview,
                    "answer": self.answer,
                    "facts": self.facts,
                    "name": self.points.first().map(|p| &p.name),
                    "command": self.points.first().map(|p| &p.command),
                    "tiles": self.tiles(),
                    "rows": self.rows(),
                    "timed_size": format!("{} × {}", self.timed_size.0, self.timed_size.1),
                    "size": format!("{} × {}", self.size.0, self.size.1),
                    "reduced_size": (reduction.factor > 1).then(|| format!("{width} × {height}")),
                    "factor": reduction.factor,
                    "style": include_str!("page.css"),
                    "scripts": [
                        include_str!("plots.js"),
                        include_str!("viewer.js"),
                        include_str!("page.js"),
                    ],
                    // No text in the data can end its element.
                    "data": data.replace('<', "\\u003c"),
                })),
            )
            .map_err(|e| Error::failed(format!("the page cannot be written: {e:#}")))
    }

    /// The maximum number of pixels per picture with which all pictures and maps of the page fit into
    /// [`MOST_PICTURE_BYTES`].
    fn most_pixels(&self) -> usize {
        let maps = |exhibit: &Exhibit| {
            let shared = exhibit.shared.as_ref().map_or(0, Vec::len);
            1 + usize::from(exhibit.flicker.is_some()) + shared
        };
        let exhibits = self.points.iter().filter_map(|p| p.exhibit.as_ref());
        let bytes = exhibits.map(|e| PICTURE_BYTES + MAP_BYTES * maps(e) as f64);
        (MOST_PICTURE_BYTES / (PICTURE_BYTES + bytes.sum::<f64>())) as usize
    }

    /// The JSON object from which the scripts of the page draw plots and pictures: the points with their
    /// measurements, and the pictures in base64, reduced by `reduction`. Returns an error if a picture does
    /// not have the size of the page.
    fn data(&self, reduction: Reduction) -> Result<Value> {
        let exposure = exposure(&self.reference);
        let scale = exposure.exp2();
        let picture = |pixels: &[[f32; 3]]| -> Result<String> {
            Ok(rgb9e5(&reduction.apply(pixels)?, scale))
        };
        let map = |map: &FrameMap, most: f32| -> Result<Value> {
            let pixels = bytes(&reduction.apply_to_map(&map.pixels)?, most);
            Ok(json!({ "value": map.value, "most": most, "bytes": pixels }))
        };
        let exhibit = |exhibit: &Exhibit| -> Result<Value> {
            let own = picture(&exhibit.picture)?;
            let flip = flip(
                &exhibit.picture,
                &self.reference,
                self.size,
                exposure as f32,
            );
            let flip = FrameMap {
                value: flip.mean,
                pixels: flip.errors,
            };
            let shared = exhibit.shared.as_ref().map(|shared| -> Result<Vec<Value>> {
                let one = |s: &super::Shared| {
                    Ok(json!({ "lighting": s.lighting, "fraction": map(&s.fraction, 1.0)? }))
                };
                shared.iter().map(one).collect()
            });
            Ok(json!({
                "picture": own,
                "flip": map(&flip, 1.0)?,
                "flicker": exhibit.flicker.as_ref().map(|f| map(f, 1.0)).transpose()?,
                "shared": shared.transpose()?,
                "errors": exhibit.errors,
                "runs": exhibit.runs,
                "passes": exhibit.passes,
                "spectrum": exhibit.spectrum,
                "low": exhibit.low_frequencies,
            }))
        };
        let front = self.front();
        let point = |(index, point): (usize, &Point)| -> Result<Value> {
            Ok(json!({
                "letter": letter(index),
                "name": point.name,
                "settings": point.settings,
                "command": point.command,
                "milliseconds": point.milliseconds,
                "time": time(point),
                "error": point.error,
                "interval": point.interval,
                "bias": point.bias,
                "seeds": point.seeds,
                "standing": point.standing,
                "front": front[index],
                "exhibit": point.exhibit.as_ref().map(exhibit).transpose()?,
            }))
        };
        let points = self.points.par_iter().enumerate().map(point);
        Ok(json!({
            "size": reduction.reduced_size(),
            "exposure": exposure,
            "decided": self.answer.is_decided,
            "yardstick": self.yardstick,
            "reference": picture(&self.reference)?,
            "points": points.collect::<Result<Vec<Value>>>()?,
        }))
    }

    /// The error that path tracing would have in the time of `point`, and the half-width of its 95 % interval
    /// if it is known. The error falls with the square root of the time, because path tracing averages
    /// independent samples. `None` if path tracing is not among the points.
    fn yardstick_error(&self, point: &Point) -> Option<(f64, Option<f64>)> {
        let yardstick = self.points.get(self.yardstick?)?;
        if let Some((ratio, [low, high])) = point.at_equal_time {
            // The interval of the ratio contains the noise of both errors.
            let error = point.error / ratio;
            return Some((error, Some(0.5 * (point.error / low - point.error / high))));
        }
        let factor = (yardstick.milliseconds / point.milliseconds).sqrt();
        Some((
            factor * yardstick.error,
            half_width(yardstick).map(|h| factor * h),
        ))
    }

    /// The most important numbers, which the page shows beside the answer, as pairs of a number and its
    /// meaning: the time and the error of the first point, and their comparison with path tracing. Empty for
    /// a page without points.
    fn tiles(&self) -> Vec<[String; 2]> {
        let Some(best) = self.points.first() else {
            return Vec::new();
        };
        let (width, height) = self.timed_size;
        let mut tiles = vec![
            [
                time(best),
                format!("for one frame of {width} × {height} pixels"),
            ],
            [
                error(best.error, half_width(best)),
                "error of that frame".to_owned(),
            ],
        ];
        let is_other = self.yardstick.is_some_and(|index| index != 0);
        if let Some((value, half_width)) = self.yardstick_error(best).filter(|_| is_other) {
            tiles.push([
                error(value, half_width),
                "error of path tracing (no reuse of samples) in the same time".to_owned(),
            ]);
            let compared = match value / best.error {
                // Both are without error, or one of them is: there is no ratio to state.
                ratio if !ratio.is_normal() => None,
                ratio if ratio >= 1.0 => Some(format!("{ratio:.1} × less")),
                ratio => Some(format!("{:.1} × more", 1.0 / ratio)),
            };
            tiles.extend(
                compared.map(|text| [text, "error than path tracing in the same time".to_owned()]),
            );
        }
        tiles
    }

    /// The rows of the page's table: one per point, in the order of the points.
    fn rows(&self) -> Vec<Row> {
        let front = self.front();
        let row = |(index, point): (usize, &Point)| Row {
            letter: letter(index),
            name: point.name.clone(),
            time: time(point),
            error: error(point.error, half_width(point)),
            relative: match (point.at_equal_time, self.yardstick_error(point)) {
                (Some((ratio, [low, high])), _) => format!("{ratio:.2} × ({low:.2}–{high:.2})"),
                (None, Some((error, _))) if error > 0.0 => {
                    format!("{:.2} ×", point.error / error)
                }
                _ => String::new(),
            },
            bias: bias(point.bias),
            seeds: point.seeds,
            front: front[index],
            standing: match point.standing {
                Standing::Advised => "advised",
                Standing::Finalist => "compared to the end",
                Standing::LeftOut => "left out early",
                Standing::Empty => "too dark to advise",
                Standing::Biased => "biased",
            },
        };
        self.points.iter().enumerate().map(row).collect()
    }
}

/// A row of the page's table: the values of one point as text with units, for the template.
#[derive(serde::Serialize)]
struct Row {
    letter: String,
    name: String,
    time: String,
    error: String,
    relative: String,
    bias: String,
    seeds: usize,
    front: bool,
    standing: &'static str,
}

/// The name of the point with this index in the plots and the table: `A` to `Z`, and from the 27th point on
/// its number.
fn letter(index: usize) -> String {
    let letter = u8::try_from(index).ok().filter(|index| *index < 26);
    letter.map_or((index + 1).to_string(), |i| {
        char::from(b'A' + i).to_string()
    })
}

fn half_width(point: &Point) -> Option<f64> {
    point.interval.map(|[low, high]| 0.5 * (high - low))
}

fn time(point: &Point) -> String {
    milliseconds::text(point.milliseconds, point.is_timed)
}

fn error(value: f64, half_width: Option<f64>) -> String {
    match half_width {
        Some(half_width) => format!("{:.1} % ± {:.1} %", 100.0 * value, 100.0 * half_width),
        None => format!("about {:.1} %", 100.0 * value),
    }
}

fn bias((value, half_width): (f64, f64)) -> String {
    if half_width.is_finite() {
        format!("{:+.1} % ± {:.1} %", 100.0 * value, 100.0 * half_width).replace('-', "−")
    } else {
        "not known".to_owned()
    }
}

/// Converts `text` to HTML: escapes its special characters, and marks words between backticks as code. The
/// templates use it as the filter `code`.
pub(super) fn code(text: &str) -> Text {
    let escaped = HtmlEscape(text).to_string();
    let parts = escaped.split('`').enumerate();
    let html = parts.map(|(index, part)| match index % 2 {
        1 => format!("<code>{part}</code>"),
        _ => part.to_owned(),
    });
    Text::from_safe_string(html.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::contents::{Answer, Shared};
    use std::collections::BTreeMap;

    const HOSTILE: &str = "a</script><script>alert(1)</script>`&\"'";

    /// A point for tests, with a grey picture and maps of `width` × `height` pixels, and with texts that look
    /// like HTML.
    fn point(name: &str, milliseconds: f64, error: f64, (width, height): (u32, u32)) -> Point {
        let pixels = width as usize * height as usize;
        let map = FrameMap {
            value: 0.25,
            pixels: vec![0.25; pixels],
        };
        Point {
            name: name.to_owned(),
            settings: format!("# {HOSTILE}\n"),
            command: format!("headwater render {HOSTILE}"),
            milliseconds,
            is_timed: true,
            error,
            interval: Some([0.9 * error, 1.1 * error]),
            bias: (0.001, f64::INFINITY),
            at_equal_time: None,
            seeds: 4,
            standing: Standing::Finalist,
            exhibit: Some(Exhibit {
                picture: vec![[0.5; 3]; pixels],
                errors: vec![0.4, 0.2],
                runs: 4,
                passes: vec![("trace".to_owned(), milliseconds)],
                flicker: Some(map.clone()),
                spectrum: vec![2.0, 1.0, 0.5],
                low_frequencies: 2.0,
                shared: Some(vec![Shared {
                    lighting: "direct".to_owned(),
                    fraction: map,
                }]),
            }),
        }
    }

    fn page(size: (u32, u32)) -> Page {
        let mut points = vec![
            point("good", 20.0, 0.2, size),
            point("path tracing", 10.0, 0.8, size),
            point("beaten", 21.0, 0.3, size),
            point("empty", 5.0, 0.01, size),
        ];
        points[0].standing = Standing::Advised;
        points[3].standing = Standing::Empty;
        Page {
            title: format!("Which preset for {HOSTILE}?"),
            overview: None,
            answer: Answer {
                is_decided: true,
                sentence: format!("Use `good`, {HOSTILE}"),
                details: String::new(),
            },
            points,
            yardstick: Some(1),
            timed_size: (1920, 1080),
            size,
            reference: vec![[0.25; 3]; size.0 as usize * size.1 as usize],
            facts: vec![("Scene".to_owned(), HOSTILE.to_owned())],
        }
    }

    /// Reads the data of a page from its HTML text, as its scripts do.
    fn data(html: &str) -> Value {
        let start = "<script type=\"application/json\" id=\"data\">";
        let (_, data) = html.split_once(start).unwrap();
        serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap()
    }

    #[test]
    fn hostile_text_stays_text() {
        let html = page((8, 8)).html().unwrap();
        assert!(!html.contains("<script>alert"), "{html}");
        assert_eq!(html.matches("</script>").count(), 2);
        assert!(
            html.contains("<code>good</code>, a&lt;&#x2f;script&gt;"),
            "{html}"
        );
        let point = &data(&html)["points"][0];
        assert_eq!(point["command"], format!("headwater render {HOSTILE}"));
        assert_eq!(point["bias"][1], Value::Null);
    }

    #[test]
    fn nothing_is_loaded_from_outside() {
        let html = page((8, 8)).html().unwrap();
        for request in [
            "src=",
            "href=\"http",
            "url(h",
            "@import",
            "fetch(",
            "XMLHttp",
        ] {
            assert!(!html.contains(request), "{request}");
        }
        // The name space of SVG is no address.
        let addresses: Vec<&str> = html.split("http").skip(1).collect();
        assert!(
            addresses
                .iter()
                .all(|a| a.starts_with("-equiv") || a.starts_with("://www.w3.org/"))
        );
    }

    #[test]
    fn the_front_has_the_points_that_nothing_beats() {
        assert_eq!(page((1, 1)).front(), [true, true, false, false]);
        let mut equal = page((1, 1));
        equal.points = vec![equal.points[0].clone(); 2];
        assert_eq!(equal.front(), [true, true]);
    }

    #[test]
    fn tiles_compare_with_path_tracing_in_the_same_time() {
        let page = page((1, 1));
        let tiles: BTreeMap<String, String> = (page.tiles().into_iter())
            .map(|[value, meaning]| (meaning, value))
            .collect();
        let with = |meaning: &str| {
            let mut found = tiles.iter().filter(|(m, _)| m.contains(meaning));
            found.next().unwrap().1.as_str()
        };
        assert_eq!(with("1920 × 1080"), "20.0 ms");
        assert_eq!(with("that frame"), "20.0 % ± 2.0 %");
        // 0.8 / √2
        assert_eq!(with("no reuse"), "56.6 % ± 5.7 %");
        assert_eq!(with("error than"), "2.8 × less");
        assert_eq!(page.rows()[0].relative, "0.35 ×");
    }

    #[test]
    fn a_measured_ratio_replaces_the_computed_one() {
        let mut page = page((1, 1));
        page.points[0].at_equal_time = Some((0.4, [0.25, 0.5]));
        assert_eq!(page.rows()[0].relative, "0.40 × (0.25–0.50)");
        // 0.2 / 0.4, and half of the difference of 0.2 / 0.25 and 0.2 / 0.5.
        assert_eq!(page.tiles()[2][0], "50.0 % ± 20.0 %");
        assert_eq!(page.tiles()[3][0], "2.5 × less");
    }

    /// A picture may have no error at all, such as that of a black scene.
    #[test]
    fn an_error_of_0_has_no_ratio() {
        let mut page = page((1, 1));
        page.points[0].error = 0.0;
        page.points[0].at_equal_time = None;
        for [value, meaning] in page.tiles() {
            assert!(
                !value.contains("inf") && !value.contains("NaN"),
                "{value} {meaning}"
            );
        }
    }

    #[test]
    fn large_pictures_are_reduced_below_15_megabytes() {
        let size = (800, 600);
        let html = page(size).html().unwrap();
        assert!(
            html.len() < 15_000_000 && html.len() > 3_000_000,
            "{}",
            html.len()
        );
        let data = data(&html);
        assert_eq!(data["size"], json!([400, 300]));
        assert!(html.contains("reduced from 800 × 600 to 400 × 300"));
        assert!(!page((8, 8)).html().unwrap().contains("reduced from"));
    }

    #[test]
    fn a_page_without_points_and_pictures_is_written_too() {
        let mut page = page((1, 1));
        page.points.clear();
        page.yardstick = None;
        page.answer.is_decided = false;
        assert!(page.html().unwrap().contains("Undecided"));
        page.reference.clear();
        assert!(page.html().is_err());
    }
}

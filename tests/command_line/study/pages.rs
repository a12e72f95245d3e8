//! Tests of the pages of a study.

use super::super::{succeed, text};
use super::{rows, table, write};
use serde_json::Value;
use std::path::Path;

/// Two scenes and three configurations, one of which has a name that breaks pages which do not escape it.
const PLAN: &str = r#"
purpose = "Are <b>pages</b> right?"
scenes = ["cornell", "cornell:finish=metal"]
width = 24
frames = 2
seeds = 3
most_seeds = 3
bounces = 2
reference_spp = 16
[[configurations]]
name = "path tracing"
preset = "path-tracing"
accumulate = true
[[configurations]]
name = "</td></script><script>alert(1)</script>&\"'"
preset = "accurate"
expect = "any"
[[configurations]]
name = "fast"
preset = "fast"
set = { "direct.light_samples" = 3 }
expect = "any"
"#;

const PAGES: [&str; 2] = ["pages/cornell.html", "pages/cornell-finish-metal.html"];

/// A text as a page states it.
fn escaped(text: &str) -> String {
    let mut escaped = text.replace('&', "&amp;");
    for (character, code) in [
        ('<', "&lt;"),
        ('>', "&gt;"),
        ('"', "&quot;"),
        ('\'', "&#x27;"),
        ('/', "&#x2f;"),
    ] {
        escaped = escaped.replace(character, code);
    }
    escaped
}

/// The data that the scripts of the page in this file read.
pub fn data(page: &Path) -> Value {
    let html = std::fs::read_to_string(page).unwrap();
    let start = "<script type=\"application/json\" id=\"data\">";
    let (_, data) = html.split_once(start).unwrap();
    serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap()
}

/// Asserts that the folder of a study has an overview that leads to a page for each of its scenes, which lead back, and
/// returns the data of these pages.
pub fn pages(folder: &Path) -> Vec<Value> {
    let html = std::fs::read_to_string(folder.join("index.html")).unwrap();
    assert!(html.ends_with("</html>"), "{html}");
    let links = html.split("<a href=\"").skip(1);
    let links = links.map(|rest| rest.split_once('"').unwrap().0);
    links
        .map(|link| {
            let page = folder.join(link.replace("&#x2f;", "/"));
            let html = std::fs::read_to_string(&page).unwrap();
            assert!(html.contains("href=\"..&#x2f;index.html\""), "{link}");
            data(&page)
        })
        .collect()
}

/// The number of points with pictures on a page.
pub fn pictures(page: &Value) -> usize {
    let points = page["points"].as_array().unwrap().iter();
    points.filter(|point| !point["exhibit"].is_null()).count()
}

#[test]
fn pages_have_the_names_numbers_and_pictures_of_the_study() {
    let folder = tempfile::tempdir().unwrap();
    let plan = write(folder.path(), PLAN);
    let out = folder.path().join("out");
    let study = ["study", "--plan", &plan, "-o", text(&out)];
    succeed(&study);
    let index = std::fs::read_to_string(out.join("index.html")).unwrap();
    assert!(!index.contains("<script") && !index.contains("<b>pages"));
    assert!(index.contains("Are &lt;b&gt;pages"));
    let (rows, costs) = (rows(&out), table(&out, "times.json"));
    assert_eq!(rows.len(), 6);
    let range = |ratio: &Value| {
        let of = |value: &Value| value.as_f64().unwrap();
        let [low, high] = [0, 1].map(|end| of(&ratio["interval"][end]));
        format!("<td>{:.2} ({low:.2}–{high:.2})</td>", of(&ratio["value"]))
    };
    for (scene, file) in PAGES.iter().enumerate() {
        let link = format!("<a href=\"{}\">", escaped(file));
        let (_, section) = index.split_once(&link).unwrap();
        let (section, _) = section.split_once("</section>").unwrap();
        let html = std::fs::read_to_string(out.join(file)).unwrap();
        assert!(!html.contains("<script>alert"), "{html}");
        let page = data(&out.join(file));
        assert_eq!(page["size"][0], 24);
        let points = page["points"].as_array().unwrap();
        assert_eq!(points.len(), 3);
        for (row, cost) in (rows.iter().zip(&costs)).skip(3 * scene).take(3) {
            let name = row["configuration"].as_str().unwrap();
            let (_, line) = section
                .split_once(&format!("\"row\">{}</th>", escaped(name)))
                .unwrap();
            let (line, _) = line.split_once("</tr>").unwrap();
            assert!(line.contains("<td>3</td>"), "{line}");
            assert!(line.contains(row["verdict"].as_str().unwrap()), "{line}");
            let is_base = name == "path tracing";
            for key in ["error_at_equal_time", "time_ratio"] {
                let wanted = match is_base {
                    true => "<td>1</td>".to_owned(),
                    false => range(&cost[key]),
                };
                assert!(line.contains(&wanted), "{key} {wanted}: {line}");
            }
            let point = points.iter().find(|point| point["name"] == name).unwrap();
            let number = |value: &Value| value.as_f64().unwrap();
            let relmse = number(&row["relmse"][1]);
            let error = number(&point["error"]);
            assert!((error * error - relmse).abs() < 1e-9 * relmse, "{name}");
            let passes = cost["milliseconds"].as_array().unwrap().iter();
            let frame: f64 = passes.map(|pass| number(&pass[1])).sum();
            let frames = if is_base { 2.0 } else { 1.0 };
            let time = number(&point["milliseconds"]);
            assert!((time - frames * frame).abs() < 1e-9 * time, "{name}");
            assert_eq!(point["seeds"], 3);
            let exhibit = &point["exhibit"];
            // Four bytes per pixel, as base64.
            let pixels = 24 * page["size"][1].as_u64().unwrap() as usize;
            let length = exhibit["picture"].as_str().unwrap().len();
            assert_eq!(length, (4 * pixels).div_ceil(3) * 4, "{name}");
            assert_eq!(exhibit["errors"].as_array().unwrap().len(), 2);
            // Means of frames do not flicker independently.
            assert_eq!(exhibit["flicker"].is_null(), is_base, "{name}");
        }
        let command = |name: &str| {
            let point = points.iter().find(|point| point["name"] == name).unwrap();
            point["command"].as_str().unwrap().to_owned()
        };
        let wanted = "--preset fast --set direct.light_samples=3 --bounces 2 --width 24 --jitter off --frames 2";
        assert!(command("fast").contains(wanted), "{}", command("fast"));
        assert!(command("path tracing").contains("--preset path-tracing "));
        assert!(command("path tracing").contains("--accumulate"));
    }

    // No result depends on pictures: a study without them has the same ones, and makes no run again.
    let files = ["results.json", "results.csv", "runs.jsonl"];
    let read = || files.map(|name| std::fs::read(out.join(name)).unwrap());
    let before = read();
    let mut pictures: Vec<_> = (std::fs::read_dir(out.join("pictures")).unwrap())
        .map(|entry| entry.unwrap().path())
        .collect();
    assert_eq!(pictures.len(), 6);
    std::fs::write(pictures.pop().unwrap(), "damaged").unwrap();
    std::fs::remove_file(pictures.pop().unwrap()).unwrap();
    succeed(&study);
    assert!(read() == before);
    let shown: usize = pages(&out).iter().map(self::pictures).sum();
    assert_eq!(shown, 4);
}

/// The command of a point renders the picture of the point.
#[test]
fn the_command_of_a_point_renders_its_picture() {
    let folder = tempfile::tempdir().unwrap();
    let plan = write(folder.path(), &PLAN.replace("\"cornell\", ", ""));
    let out = folder.path().join("out");
    succeed(&["study", "--plan", &plan, "-o", text(&out)]);
    let page = data(&out.join(PAGES[1]));
    let wanted: Vec<_> = (std::fs::read_dir(out.join("pictures")).unwrap())
        .map(|entry| headwater::image::Image::read(&entry.unwrap().path()).unwrap())
        .collect();
    let points = page["points"].as_array().unwrap();
    assert_eq!((points.len(), wanted.len()), (3, 3));
    for point in points {
        let command = point["command"].as_str().unwrap();
        let mut arguments: Vec<&str> = command.split(' ').skip(1).collect();
        let picture = folder.path().join("picture.exr");
        *arguments.last_mut().unwrap() = text(&picture);
        succeed(&arguments);
        let rendered = headwater::image::Image::read(&picture).unwrap();
        let same = |other: &&headwater::image::Image| {
            ["R", "G", "B"]
                .iter()
                .all(|c| other.floats(c) == rendered.floats(c))
        };
        assert_eq!(wanted.iter().filter(same).count(), 1, "{command}");
    }
}

//! Writes the overview of the pages of several scenes as HTML: one table per scene, with a link to its page.

use super::html::code;
use crate::{Error, Result};
use minijinja::Environment;
use minijinja::value::Serde;
use serde::Serialize;
use serde_json::json;

/// The contents of an overview, as plain data.
#[derive(Clone, Debug, Serialize)]
pub struct Overview {
    /// The title. Words between backticks are shown as code.
    pub title: String,
    /// The question that all pages answer; it can be empty.
    pub question: String,
    /// The scenes, in the order in which they are listed.
    pub scenes: Vec<OverviewScene>,
    /// The conditions of the measurement, as names and values.
    pub facts: Vec<(String, String)>,
}

/// One scene of an overview.
#[derive(Clone, Debug, Serialize)]
pub struct OverviewScene {
    /// The name of the scene.
    pub name: String,
    /// The address of the page of the scene, relative to the overview; `None` if it has no page yet.
    pub link: Option<String>,
    /// The answer for this scene. Words between backticks are shown as code.
    pub answer: String,
    /// The configurations of the scene, in the order of the table.
    pub rows: Vec<OverviewRow>,
}

/// One configuration on one scene. Values that are not known are `None`.
#[derive(Clone, Debug, Serialize)]
pub struct OverviewRow {
    /// The name of the configuration.
    pub configuration: String,
    /// The error divided by that of path tracing which had the same time, with its interval, as text.
    pub error_at_equal_time: Option<String>,
    /// The time of a frame divided by that of path tracing, as text.
    pub time_ratio: Option<String>,
    /// The error of the last frame, as text.
    pub error: Option<String>,
    /// The number of independent runs.
    pub seeds: usize,
    /// The result of the test for a bias.
    pub verdict: String,
    /// True if these settings are advised for the scene.
    pub is_advised: bool,
}

impl Overview {
    /// The text of the HTML file, which needs no other file but links to the pages of the scenes.
    ///
    /// # Errors
    /// The template is wrong, which a test excludes.
    pub fn html(&self) -> Result<String> {
        let mut environment = Environment::new();
        environment.add_filter("code", code);
        environment
            .render_named_str(
                "overview.html",
                include_str!("overview.html"),
                Serde(json!({
                    "overview": self,
                    "style": include_str!("page.css"),
                })),
            )
            .map_err(|e| Error::failed(format!("the overview cannot be written: {e:#}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOSTILE: &str = "a</td><script>alert(1)</script>\"'&";

    #[test]
    fn hostile_names_stay_text_and_unknown_values_are_dashes() {
        let scene = |link: Option<&str>| OverviewScene {
            name: HOSTILE.to_owned(),
            link: link.map(str::to_owned),
            answer: format!("Use `{HOSTILE}`."),
            rows: vec![OverviewRow {
                configuration: HOSTILE.to_owned(),
                error_at_equal_time: None,
                time_ratio: Some("1.50".to_owned()),
                error: None,
                seeds: 3,
                verdict: "undecided".to_owned(),
                is_advised: link.is_some(),
            }],
        };
        let overview = Overview {
            title: HOSTILE.to_owned(),
            question: HOSTILE.to_owned(),
            scenes: vec![scene(Some("pages/a%20b.html")), scene(None)],
            facts: vec![(HOSTILE.to_owned(), HOSTILE.to_owned())],
        };
        let html = overview.html().unwrap();
        assert!(!html.contains("<script>alert"), "{html}");
        assert_eq!(html.matches("href=\"pages").count(), 1);
        assert_eq!(html.matches("<td>1.50</td>").count(), 2);
        assert_eq!(html.matches("<td>–</td>").count(), 4);
        assert_eq!(html.matches("undecided, advised").count(), 1);
    }
}

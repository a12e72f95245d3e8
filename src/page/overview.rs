//! Writes the overview of the pages of several scenes as HTML: one table per scene, with a link to its page.

use super::html::code;
use crate::{Error, Result};
use minijinja::Environment;
use minijinja::value::Serde;
use serde::Serialize;
use serde_json::json;

/// The contents of an overview page, which summarises the results on several scenes and has links to their
/// pages.
#[derive(Clone, Debug, Serialize)]
pub struct Overview {
    /// The title of the overview. The page shows words between backticks as code.
    pub title: String,
    /// The question that all pages answer, shown below the title; nothing is shown if it is empty.
    pub question: String,
    /// The scenes with their results, in the order in which the page lists them.
    pub scenes: Vec<OverviewScene>,
    /// The conditions of the measurement, such as the device and the driver, as pairs of a name and a value,
    /// which the page lists at its end.
    pub facts: Vec<(String, String)>,
}

/// One scene of an overview: its answer, its table of results, and the link to its page.
#[derive(Clone, Debug, Serialize)]
pub struct OverviewScene {
    /// The name of the scene, which is the heading of its table.
    pub name: String,
    /// The address of the page of the scene, relative to the overview; `None` if it has no page yet.
    pub link: Option<String>,
    /// The answer for this scene in one or more sentences. The page shows words between backticks as code.
    pub answer: String,
    /// The rows of the scene's table, in this order: one per configuration.
    pub rows: Vec<OverviewRow>,
}

/// A row of the table of one scene: the results of one configuration (settings with a name), as text. A value
/// that is not known is `None`, and the page shows a dash for it.
#[derive(Clone, Debug, Serialize)]
pub struct OverviewRow {
    /// The name of the configuration, which is unique in the study.
    pub configuration: String,
    /// The error divided by the error of path tracing in the same time, with its 95 % interval, as text;
    /// below 1, the configuration is better.
    pub error_at_equal_time: Option<String>,
    /// The time of a frame divided by the time of a frame of path tracing, with its 95 % interval, as text.
    pub time_ratio: Option<String>,
    /// The error of the last frame (root of the relMSE) in percent, with half of its 95 % interval, as text.
    pub error: Option<String>,
    /// The number of independent runs, each with its own seed, from which the results of the row were
    /// computed.
    pub seeds: usize,
    /// The result of the test for a bias: `biased`, `unbiased` or `undecided`.
    pub verdict: String,
    /// True if the answer advises this configuration for the scene; the page then highlights the row.
    pub is_advised: bool,
}

impl Overview {
    /// The text of the HTML file of the overview. It needs no other file, but it has links to the pages of
    /// the scenes.
    ///
    /// # Errors
    /// The template is invalid. A test ensures that it is valid, so this does not happen.
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

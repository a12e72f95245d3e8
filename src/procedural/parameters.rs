//! The parameters of procedural scenes: their declaration, and the parsing and checking of the values that a user sets.

use super::Procedural;
use crate::base::nearest::nearest;
use crate::{Error, Result};
use serde::Serialize;
use std::fmt;

/// The set of values that a parameter of a scene accepts. Another value is an error, whose message shows this set.
#[derive(Clone, Copy, Debug)]
pub enum Range {
    /// The value is a whole number between these two bounds, both included.
    Whole(u64, u64),
    /// The value is a real number between these two bounds, both included.
    Real(f64, f64),
    /// The value is one of the words in this list.
    Words(&'static [&'static str]),
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(low, high) => write!(f, "{low} to {high}"),
            Self::Real(low, high) => write!(f, "{} to {}", short(*low), short(*high)),
            Self::Words(words) => write!(f, "{}", words.join(" | ")),
        }
    }
}

/// Formats a number for a message that shows a range. A number whose magnitude is below 0.001 or at least a million is
/// written in scientific notation; all others, and 0, are written as decimals.
fn short(number: f64) -> String {
    match number.abs() {
        0.0 | 1e-3..1e6 => number.to_string(),
        _ => format!("{number:e}"),
    }
}

impl Serialize for Range {
    fn serialize<S: serde::Serializer>(
        &self,
        serializer: S,
    ) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Range {
    fn holds(&self, text: &str) -> bool {
        match self {
            Self::Whole(low, high) => text
                .parse::<u64>()
                .is_ok_and(|v| (*low..=*high).contains(&v)),
            Self::Real(low, high) => text
                .parse::<f64>()
                .is_ok_and(|v| (*low..=*high).contains(&v)),
            Self::Words(words) => words.contains(&text),
        }
    }
}

/// The declaration of one parameter of a procedural scene. The values of users are checked with it, and `headwater scene
/// list` shows it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Parameter {
    /// The name of the parameter on the command line, where `SCENE:NAME=VALUE` sets its value.
    pub name: &'static str,
    /// A description of the parameter's effect in one line, which `headwater scene list` shows.
    pub doc: &'static str,
    /// The value that the parameter has if the user sets none, as text. It must be one of `values`.
    pub default: &'static str,
    /// The set of values that the parameter accepts. A user's value outside of this set is an error.
    pub values: Range,
}

/// The values of all parameters of a scene, as pairs of name and text, from which the scene is generated. Parameters that
/// the user did not set have their defaults, and each value is within its range.
pub(super) struct Values(Vec<(&'static str, String)>);

impl Values {
    pub(super) fn new(scene: &Procedural, settings: &[(String, String)]) -> Result<Self> {
        let mut values: Vec<_> = scene
            .parameters
            .iter()
            .map(|p| (p.name, p.default.to_owned()))
            .collect();
        for (key, value) in settings {
            let index = scene.parameters.iter().position(|p| p.name == key);
            let index = index.ok_or_else(|| {
                Error::input(format!(
                    "scene {} has no parameter '{key}'{}; 'headwater scene list' names them all",
                    scene.name,
                    nearest(key, scene.parameters.iter().map(|p| p.name))
                ))
            })?;
            let range = scene.parameters[index].values;
            if !range.holds(value) {
                return Err(Error::input(format!(
                    "scene {}: {key}={value} is not valid; it takes {range}",
                    scene.name
                )));
            }
            values[index].1.clone_from(value);
        }
        Ok(Self(values))
    }

    pub(super) fn text(&self, name: &str) -> &str {
        let found = self.0.iter().find(|(key, _)| *key == name);
        found.map_or("", |(_, value)| value)
    }

    /// The value of the parameter `name` as a number. 0 if the scene does not declare the parameter, or if its values are
    /// words.
    pub(super) fn real(&self, name: &str) -> f32 {
        self.text(name).parse().unwrap_or(0.0)
    }

    /// The value of the parameter `name` as a whole number. 0 if the scene does not declare the parameter, or if its value
    /// is not a whole number.
    pub(super) fn whole(&self, name: &str) -> u64 {
        self.text(name).parse().unwrap_or(0)
    }
}

//! The known name that is most similar to a mistyped one.

/// ", did you mean 'X'?" for the closest of `names`, or nothing if none is close.
pub fn nearest<'a>(wanted: &str, names: impl Iterator<Item = &'a str>) -> String {
    names
        .map(|name| (strsim::jaro_winkler(wanted, name), name))
        .filter(|(likeness, _)| *likeness > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(String::new(), |(_, name)| {
            format!(", did you mean '{name}'?")
        })
}

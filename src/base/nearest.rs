//! The known name that is most similar to a mistyped one.

/// The longest name that is compared, in bytes.
const LONGEST: usize = 100;

/// ", did you mean 'X'?" for the closest of `names`, or nothing if none is close or `wanted` is too long to be one of them.
pub fn nearest<'a>(wanted: &str, names: impl Iterator<Item = &'a str>) -> String {
    // The comparison takes the product of both lengths, and nothing so long is a name that was mistyped.
    let comparable = wanted.len() <= LONGEST;
    names
        .filter(|_| comparable)
        .map(|name| (strsim::jaro_winkler(wanted, name), name))
        .filter(|(likeness, _)| *likeness > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(String::new(), |(_, name)| {
            format!(", did you mean '{name}'?")
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_found_and_none_for_what_is_too_long() {
        let names = || ["fast", "balanced"].into_iter();
        assert_eq!(nearest("balance", names()), ", did you mean 'balanced'?");
        assert_eq!(nearest("x", names()), "");
        assert_eq!(nearest(&"balanced".repeat(2_000_000), names()), "");
    }
}

//! A suggestion for a mistyped name, such as that of a setting or a scene: the valid name that is most similar to it.
//! Messages about unknown names contain it.

/// The maximum length in bytes of a mistyped name. A longer one gets no suggestion: no valid name is so long, and the
/// time of a comparison grows with the product of both lengths.
const LONGEST: usize = 100;

/// The suggestion ", did you mean 'X'?", where X is the element of `names` that is most similar to the
/// mistyped name `wanted`. The text is empty if no name has a similarity above 0.7, or if `wanted` has more
/// than 100 bytes.
pub fn nearest<'a>(wanted: &str, names: impl Iterator<Item = &'a str>) -> String {
    // The comparison takes the product of both lengths, and nothing so long is a name that was mistyped.
    let comparable = wanted.len() <= LONGEST;
    names
        .filter(|_| comparable)
        .map(|name| (likeness(wanted, name), name))
        .filter(|(likeness, _)| *likeness > 0.7)
        // Of equals the first, so that direct light comes before indirect.
        .reduce(|best, next| if next.0 > best.0 { next } else { best })
        .map_or(String::new(), |(_, name)| {
            format!(", did you mean '{name}'?")
        })
}

/// The similarity of two names, in [0, 1]; 1 means equal. For a dotted name, such as `direct.mode`, the last
/// word counts most, so that a key of the settings is found even if its group (`direct`) is missing or wrong.
fn likeness(wanted: &str, name: &str) -> f64 {
    let whole = strsim::jaro_winkler(wanted, name);
    let Some((group, word)) = name.rsplit_once('.') else {
        return whole;
    };
    let (wanted_group, wanted_word) = wanted.rsplit_once('.').unwrap_or(("", wanted));
    let by_word = strsim::jaro_winkler(wanted_word, word);
    let by_group = strsim::jaro_winkler(wanted_group, group);
    whole.max(0.75 * by_word + 0.25 * by_group)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_found_and_none_for_what_is_too_long() {
        let names = || ["fast", "balanced"].into_iter();
        assert_eq!(nearest("balance", names()), ", did you mean 'balanced'?");
        assert_eq!(nearest("x", names()), "");
        let keys = [
            "direct.mis",
            "direct.spatial.neighbours",
            "indirect.spatial.neighbours",
        ];
        for wanted in ["direct.neighbors", "neighbours", "direct.spatial.neighbour"] {
            let found = nearest(wanted, keys.into_iter());
            assert_eq!(
                found, ", did you mean 'direct.spatial.neighbours'?",
                "{wanted}"
            );
        }
        assert_eq!(nearest(&"balanced".repeat(2_000_000), names()), "");
    }
}

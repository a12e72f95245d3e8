//! Names of the files of a sequence: `-o frame_%04d.png` writes one file per frame, with the index of the frame in its name.

use std::ops::Range;
use std::path::{Path, PathBuf};

/// The largest number of digits that a name may ask for. An index has at most ten.
const MOST_DIGITS: usize = 10;

/// True if `path` is the name of a sequence: its file name contains `%d`, or `%0Nd` with a number N of digits from 1 to 10.
pub fn is_sequence(path: &Path) -> bool {
    place(path).is_some()
}

/// The file of the frame with the index `index`: the pattern in the name is replaced by the index, which gets zeros in front
/// until it has the number of digits that the pattern asks for. A path without a pattern stays as it is.
pub fn file_of_frame(path: &Path, index: u32) -> PathBuf {
    let Some((name, range, digits)) = place(path) else {
        return path.to_owned();
    };
    let (before, after) = (&name[..range.start], &name[range.end..]);
    path.with_file_name(format!("{before}{index:0digits$}{after}"))
}

/// The index of the frame whose file of the sequence `path` has the file name of `other`. `None` if there is no such frame.
/// With it, a sequence is refused whose files would replace an input.
pub fn frame_of(path: &Path, other: &Path) -> Option<u32> {
    let (name, range, _) = place(path)?;
    let digits = (other.file_name()?.to_str()?)
        .strip_prefix(&name[..range.start])?
        .strip_suffix(&name[range.end..])?;
    let index = digits.parse().ok()?;
    (file_of_frame(path, index).file_name() == other.file_name()).then_some(index)
}

/// The file name, the place of the first pattern in it, and the number of digits that the pattern asks for, which is 0 for
/// `%d`. `None` if the name contains no pattern.
fn place(path: &Path) -> Option<(&str, Range<usize>, usize)> {
    let name = path.file_name()?.to_str()?;
    name.match_indices('%').find_map(|(start, _)| {
        let rest = &name[start + 1..];
        let length = rest.find('d')?;
        let digits = match &rest[..length] {
            "" => 0,
            digits => digits.strip_prefix('0')?.parse().ok()?,
        };
        let is_known = length == 0 || (1..=MOST_DIGITS).contains(&digits);
        is_known.then_some((name, start..start + length + 2, digits))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_is_found_in_a_name() {
        let sequence = Path::new("out/sky_%03d.exr");
        for (other, index) in [
            ("in/sky_007.exr", Some(7)),
            ("sky_1234.exr", Some(1234)),
            ("sky_7.exr", None),
            ("sky_+07.exr", None),
            ("sky_.exr", None),
            ("sky_4294967296.exr", None),
            ("sky_007.png", None),
        ] {
            assert_eq!(frame_of(sequence, Path::new(other)), index, "{other}");
        }
        assert_eq!(frame_of(Path::new("a.exr"), Path::new("a.exr")), None);
    }

    #[test]
    fn the_pattern_becomes_the_index() {
        for (name, index, expected) in [
            ("out/frame_%04d.png", 7, "out/frame_0007.png"),
            ("frame_%04d.exr", 12345, "frame_12345.exr"),
            ("%d.png", 0, "0.png"),
            ("100%_%03d.png", 21, "100%_021.png"),
            ("%02d_%02d.png", 3, "03_%02d.png"),
        ] {
            let path = Path::new(name);
            assert!(is_sequence(path), "{name}");
            assert_eq!(file_of_frame(path, index), Path::new(expected));
        }
        for name in [
            "a.png",
            "50%.png",
            "%4d.png",
            "%0d.png",
            "%011d.png",
            "%03x.png",
            "%04d/a.png",
        ] {
            let path = Path::new(name);
            assert!(!is_sequence(path), "{name}");
            assert_eq!(file_of_frame(path, 3), path);
        }
    }
}

//! Parses statements of OBJ that are written in the usual way: `v`, `vn`, `vt` and `f` in lower case with the usual number
//! of words, which spaces or tabs separate, without a comment and on one line. Nearly all lines of large files are plain. They
//! have no error here: a line that could have one is not plain, and [`super::Reader::statement`] reads it.

use glam::{DVec3, Vec2, Vec3};

/// The maximum length of a plain line, in bytes. Longer lines, such as faces with hundreds of corners, are read as text, by
/// the code that checks the memory for them.
const MAX_LINE: usize = 1 << 12;

/// The maximum number of digits of a plain index, so that it fits into 32 bits.
const MAX_DIGITS: usize = 9;

/// The numbers of the plain statements of a block, each list in the order of the file.
#[derive(Default)]
pub struct Statements {
    pub positions: Vec<DVec3>,
    pub normals: Vec<Vec3>,
    pub coordinates: Vec<Vec2>,
    /// For each face, the number of its corners.
    pub faces: Vec<usize>,
    /// The corners of all faces: the indices of position, texture coordinates and normal as the file states them, from 1 or
    /// negative; 0 where the file states none.
    pub corners: Vec<[i32; 3]>,
}

/// The kind of a plain statement.
pub enum Kind {
    Position,
    Normal,
    Coordinates,
    Face,
}

impl Statements {
    /// Reads a line, and adds its numbers. `None`, without a change, if the line is not plain.
    pub fn read(&mut self, line: &str) -> Option<Kind> {
        if line.len() > MAX_LINE {
            return None;
        }
        let mut words = Words(line);
        match words.next()? {
            "v" => {
                let position = DVec3::from(words.three()?);
                self.positions.push(position);
                Some(Kind::Position)
            }
            "vn" => {
                let normal = DVec3::from(words.three()?).as_vec3();
                self.normals.push(normal);
                Some(Kind::Normal)
            }
            "vt" => {
                let mut number = || words.next()?.parse().ok().filter(|n: &f32| n.is_finite());
                let coordinates = Vec2::new(number()?, number()?);
                // A third coordinate has no meaning for images.
                if let Some(word) = words.next() {
                    word.parse::<f32>().ok()?;
                }
                words.end()?;
                self.coordinates.push(coordinates);
                Some(Kind::Coordinates)
            }
            "f" => {
                let first = self.corners.len();
                let are_plain = words.all(|word| match corner(word) {
                    Some(corner) => {
                        self.corners.push(corner);
                        true
                    }
                    None => false,
                });
                if !are_plain {
                    self.corners.truncate(first);
                    return None;
                }
                self.faces.push(self.corners.len() - first);
                Some(Kind::Face)
            }
            _ => None,
        }
    }
}

/// The words of a line, separated by spaces, tabs and line ends.
struct Words<'a>(&'a str);

impl<'a> Iterator for Words<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let is_space = |byte: &u8| matches!(byte, b' ' | b'\t' | b'\r' | b'\n');
        let bytes = self.0.as_bytes();
        let begin = bytes.iter().position(|byte| !is_space(byte))?;
        let length = bytes[begin..].iter().position(is_space);
        let end = length.map_or(bytes.len(), |length| begin + length);
        let word = &self.0[begin..end];
        self.0 = &self.0[end..];
        Some(word)
    }
}

impl Words<'_> {
    /// The next three words as numbers, as [`super::lines::Line::numbers`] reads them. `None` if they are not the last words,
    /// or are no numbers within the range of f32.
    fn three(&mut self) -> Option<[f64; 3]> {
        let mut numbers = [0.0; 3];
        for number in &mut numbers {
            let parsed = self.next()?.parse().ok();
            *number = parsed.filter(|number: &f64| number.abs() <= f64::from(f32::MAX))?;
        }
        self.end()?;
        Some(numbers)
    }

    /// `None` if there are more words.
    fn end(&mut self) -> Option<()> {
        self.next().is_none().then_some(())
    }
}

/// The three indices of a word such as `1`, `1/2`, `1//3` or `1/2/3`, in the order of [`Statements::corners`]. `None` if it
/// has another form.
fn corner(word: &str) -> Option<[i32; 3]> {
    let mut corner = [0; 3];
    let mut rest = word.as_bytes();
    for (i, index) in corner.iter_mut().enumerate() {
        let sign = match rest {
            [b'-', digits @ ..] => {
                rest = digits;
                -1
            }
            _ => 1,
        };
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit());
        let count = digits.clone().count();
        let value = digits
            .take(MAX_DIGITS)
            .fold(0, |value, digit| 10 * value + i32::from(digit - b'0'));
        let is_missing = i > 0 && count == 0 && sign == 1;
        if count > MAX_DIGITS || value == 0 && !is_missing {
            return None;
        }
        *index = sign * value;
        match &rest[count..] {
            [] => return Some(corner),
            [b'/', behind @ ..] => rest = behind,
            _ => return None,
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_have_the_usual_forms_only() {
        for (word, indices) in [
            ("7", [7, 0, 0]),
            ("-7", [-7, 0, 0]),
            ("7/", [7, 0, 0]),
            ("7/8", [7, 8, 0]),
            ("7//9", [7, 0, 9]),
            ("7/8/", [7, 8, 0]),
            ("007/-8/999999999", [7, -8, 999_999_999]),
        ] {
            assert_eq!(corner(word), Some(indices), "{word}");
        }
        for word in [
            "",
            "0",
            "/1",
            "-",
            "1/0",
            "1/-",
            "+1",
            "1.0",
            "1/2/3/4",
            "1x",
            "1000000000",
        ] {
            assert_eq!(corner(word), None, "{word}");
        }
    }

    #[test]
    fn lines_of_another_form_change_nothing() {
        let mut statements = Statements::default();
        for line in [
            "v 1 2",
            "v 1 2 3 4",
            "v 1 2 nan",
            "v 1 2 1e39",
            "v 1 2 3 # comment",
            "V 1 2 3",
            "vn 1 2 3 4",
            "vt 1",
            "vt 1 inf",
            "vt 1 2 \\",
            "f 1 2 x",
            "f 1 2 3 \\",
            "f 1 2 3#",
            "f\u{a0}1 2 3",
            "o name",
            "",
            " \t",
        ] {
            assert!(statements.read(line).is_none(), "{line}");
        }
        let long = "f".to_owned() + &" 1".repeat(MAX_LINE / 2);
        assert!(statements.read(&long).is_none());
        assert!(statements.positions.is_empty() && statements.normals.is_empty());
        assert!(statements.coordinates.is_empty() && statements.faces.is_empty());
        assert!(statements.corners.is_empty());
        assert!(statements.read("\tv  1\t-2.5e1 .5 \r\n").is_some());
        assert_eq!(statements.positions, [DVec3::new(1.0, -25.0, 0.5)]);
    }
}

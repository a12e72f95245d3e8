//! Reads the statements of MTL files that state a texture, such as `map_Kd -s 2 2 wood.png`: options and a file name.

use super::ignored::Ignored;
use super::lines::Line;
use crate::scene::notices::quoted;
use glam::{Affine2, Mat2, Vec2};
use std::path::{Path, PathBuf};

/// A texture of an MTL material: the path of an image file, and how the image lies on the surface. When the image is loaded,
/// the texture of the scene's material is made from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Possible paths of the image file, all relative to the folder of the OBJ file; the first one that exists is used. Some
    /// programs write paths relative to the MTL file (they come first), others relative to the OBJ file.
    pub files: Vec<PathBuf>,
    /// The transform from a vertex's texture coordinates to coordinates in the image, in which the image covers [0, 1]. It
    /// scales (option `-s`), then adds an offset (option `-o`). v points up before and after it, unlike in the scene.
    pub transform: Affine2,
    /// True if the texels at the edge continue beyond the image (option `-clamp on`); false if the image repeats.
    pub clamp: bool,
    /// The factor on the slope of a normal map (option `-bm`), 1 if the file states none. Other textures do not use it.
    pub bump_multiplier: f32,
    /// The line on which the MTL file states the texture, as a text for messages: `line 12`.
    pub location: String,
}

impl Map {
    /// The path of the image file for messages: the one relative to the folder of the OBJ file.
    pub fn name(&self) -> String {
        let file = self.files.last().map(|file| file.to_string_lossy());
        file.unwrap_or_default().into_owned()
    }
}

/// The words that follow an option of a texture.
enum Arguments {
    /// Up to so many numbers. The file may state fewer.
    Numbers(usize),
    /// `on` or `off`. Some programs leave it out.
    Switch,
    /// One word.
    Word,
}

/// The words that follow the option `name`, such as `-s`; `None` if MTL has no such option. Letter case has no meaning.
fn arguments(name: &str) -> Option<Arguments> {
    Some(match name.to_ascii_lowercase().as_str() {
        "-s" | "-o" | "-t" => Arguments::Numbers(3),
        "-mm" => Arguments::Numbers(2),
        "-bm" | "-boost" | "-texres" => Arguments::Numbers(1),
        "-clamp" | "-blendu" | "-blendv" | "-cc" => Arguments::Switch,
        "-imfchan" | "-type" => Arguments::Word,
        _ => return None,
    })
}

/// The words of a statement that are not read yet.
struct Rest<'a>(&'a str);

impl<'a> Rest<'a> {
    /// The next word, which stays unread; empty at the end.
    fn peek(&self) -> &'a str {
        self.0.split_whitespace().next().unwrap_or_default()
    }

    /// Reads the next word.
    fn next(&mut self) -> &'a str {
        let word = self.peek();
        self.0 = self.0.trim_start()[word.len()..].trim_start();
        word
    }

    /// Reads the numbers that follow, at most `most`.
    fn numbers(&mut self, most: usize) -> Vec<f32> {
        let mut numbers = Vec::new();
        while numbers.len() < most
            && let Some(number) = self.peek().parse().ok().filter(|n: &f32| n.is_finite())
        {
            numbers.push(number);
            self.next();
        }
        numbers
    }

    /// Reads the next word if it is `on` or `off`. Returns true for `on`; without such a word an option is on.
    fn switch(&mut self) -> bool {
        match self.peek().to_ascii_lowercase().as_str() {
            "on" => !self.next().is_empty(),
            "off" => self.next().is_empty(),
            _ => true,
        }
    }

    /// Reads a file name, which may contain spaces: everything up to the end or to an option. Some programs write options
    /// behind the name.
    fn file_name(&mut self) -> &'a str {
        let mut words = Rest(self.0);
        words.next();
        while !words.0.is_empty() && arguments(words.peek()).is_none() {
            words.next();
        }
        let (name, rest) = self.0.split_at(self.0.len() - words.0.len());
        self.0 = rest;
        name.trim_end()
    }
}

/// True if `word` looks like an option, such as `-bm`, and not like a number or the start of a file name.
fn is_option(word: &str) -> bool {
    let mut letters = word.chars();
    letters.next() == Some('-')
        && letters.next().is_some_and(char::is_alphabetic)
        && !word.contains('.')
}

/// Reads a statement that states a texture. `folder` is the path of the MTL file's folder relative to that of the OBJ file.
/// `None`, with a notice in `ignored`, if the statement names no file. There is also a notice for each option that is
/// unknown or that would change the picture but is not supported; `library` is the name of the MTL file for them.
pub fn read(line: &Line, folder: &Path, library: &str, ignored: &mut Ignored) -> Option<Map> {
    let mut map = Map {
        files: Vec::new(),
        transform: Affine2::IDENTITY,
        clamp: false,
        bump_multiplier: 1.0,
        location: line.location(),
    };
    let (mut scale, mut offset, mut has_unknown_option) = (Vec2::ONE, Vec2::ZERO, false);
    let mut rest = Rest(line.rest);
    let mut name = "";
    while !rest.0.is_empty() {
        if !is_option(rest.peek()) {
            // A second name cannot occur: a name ends only where an option or nothing follows, except for what follows the
            // words of a later option, which is no name.
            match name {
                "" => name = rest.file_name(),
                _ => {
                    rest.next();
                }
            }
            continue;
        }
        let option = rest.next().to_ascii_lowercase();
        let (mut numbers, mut is_on, mut word) = (Vec::new(), true, String::new());
        match arguments(&option) {
            Some(Arguments::Numbers(most)) => numbers = rest.numbers(most),
            Some(Arguments::Switch) => is_on = rest.switch(),
            Some(Arguments::Word) => word = rest.next().to_ascii_lowercase(),
            None => {
                rest.numbers(usize::MAX);
                rest.switch();
            }
        }
        let pair = |default: f32| {
            let number = |i: usize| numbers.get(i).copied().unwrap_or(default);
            Vec2::new(number(0), number(1))
        };
        let is_followed = match option.as_str() {
            "-s" => {
                scale = pair(1.0);
                true
            }
            "-o" => {
                offset = pair(0.0);
                true
            }
            "-clamp" => {
                map.clamp = is_on;
                true
            }
            "-bm" if ["norm", "bump", "map_bump"].contains(&line.keyword) => {
                map.bump_multiplier = numbers.first().copied().unwrap_or(1.0);
                true
            }
            // Without these the renderer does the same as with them.
            "-blendu" | "-blendv" => is_on,
            "-cc" => !is_on,
            "-mm" => numbers.iter().zip([0.0, 1.0]).all(|(n, usual)| *n == usual),
            "-bm" => numbers.iter().all(|n| *n == 1.0),
            "-boost" | "-t" => numbers.iter().all(|n| *n == 0.0),
            // Roughness and metalness are read from red, opacity from alpha where there is one.
            "-imfchan" => match line.keyword {
                "map_d" => word == "m",
                keyword => word == "r" && keyword.starts_with("map_p"),
            },
            "-type" | "-texres" => false,
            _ => {
                has_unknown_option = true;
                ignored
                    .tally
                    .add("unknown options of textures are ignored", || {
                        format!("{} in {}", quoted(&option), line.location_in(library))
                    });
                true
            }
        };
        if !is_followed {
            let what = format!("the option {option} of textures is ignored");
            ignored.tally.add(&what, || line.location_in(library));
        }
    }
    if name.is_empty() {
        ignored
            .tally
            .add("textures without a file name are ignored", || {
                format!("{} in {}", line.written, line.location_in(library))
            });
        return None;
    }
    let mut names = vec![name];
    // Words before the name may belong to the unknown option.
    names.extend(
        name.split_whitespace()
            .last()
            .filter(|_| has_unknown_option),
    );
    for name in names {
        let file = name.replace('\\', "/");
        map.files.push(folder.join(&file));
        map.files.push(file.into());
    }
    map.files.dedup();
    map.transform = Affine2::from_mat2_translation(Mat2::from_diagonal(scale), offset);
    Some(map)
}

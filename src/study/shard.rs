//! Shards: parts of the work of a study, which different processes or machines do separately.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// A shard: the part `index` of `count` parts into which the work of a study is divided, for example among
/// machines. The indices of its scene, configuration and seed assign each run to exactly one shard; blocks of
/// references are assigned likewise, except for the first ones, which all shards need. The results of all
/// shards are merged later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// The index of the part, from 0. In the option `--shard K/N`, it is K − 1.
    pub index: u64,
    /// The number of parts, at least 1. With 1, the study is whole.
    pub count: u64,
}

impl Shard {
    /// The shard of a study that is not divided: the whole work.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Parses a shard from a text of the form `K/N`, such as `2/3`, with K from 1 to N; its index is K − 1.
    ///
    /// # Errors
    /// The text is not of this form.
    pub fn parse(text: &str) -> Result<Self> {
        let numbers = text.split_once('/').and_then(|(index, count)| {
            let (index, count) = (index.parse::<u64>().ok()?, count.parse::<u64>().ok()?);
            (1..=count).contains(&index).then_some((index - 1, count))
        });
        let (index, count) = numbers.ok_or_else(|| {
            Error::input(format!(
                "'{text}' is no shard; write K/N, with K from 1 to N, such as 2/3"
            ))
        })?;
        Ok(Self { index, count })
    }

    /// True if the study is not divided, so that this shard has all of its results.
    pub fn is_whole(self) -> bool {
        self.count == 1
    }

    /// True if this shard does the item of work with these indices, such as those of a scene, a configuration
    /// and a seed. Neighbouring indices belong to different shards, so that slow items are distributed
    /// evenly.
    pub fn owns(self, indices: &[u64]) -> bool {
        indices.iter().sum::<u64>() % self.count == self.index
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_has_one_owner() {
        let shards = ["1/3", "2/3", "3/3"].map(|text| Shard::parse(text).unwrap());
        for item in 0..60 {
            let indices = [item % 3, item % 4, item % 5];
            let owners = shards.iter().filter(|shard| shard.owns(&indices));
            assert_eq!(owners.count(), 1);
        }
        assert!(Shard::parse("1/1").unwrap().is_whole());
        for wrong in ["", "3", "0/3", "4/3", "-1/3", "1/0", "1/3/5", "a/b"] {
            assert_eq!(Shard::parse(wrong).unwrap_err().exit_status(), 2, "{wrong}");
        }
    }
}

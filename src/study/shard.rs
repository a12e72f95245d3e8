//! The part of a study's work that one process does, if several divide it.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// A shard: the part `index` of `count` parts into which the work of a study is divided. Every run and every block of a
/// reference belongs to exactly one shard, by the indices of its scene, its configuration and its seed, so that the shards
/// of any machine fit together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// The index of the part, from 0.
    pub index: u64,
    /// The number of parts, at least 1. With 1, the study is whole.
    pub count: u64,
}

impl Shard {
    /// The only part of a study that is not divided.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Reads `K/N`, where K from 1 to N counts the shards.
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

    /// True if the study is not divided.
    pub fn is_whole(self) -> bool {
        self.count == 1
    }

    /// True if this shard does the item of work with these indices, such as those of a scene, a configuration and a seed. Items
    /// whose indices differ by one in one place belong to different shards, so that each gets a fair part of slow ones.
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

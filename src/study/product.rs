//! The combinations of values that a sweep of a plan consists of.

use serde_json::{Map, Value};

/// All combinations of one value for each key of a sweep (the part of a plan that lists values for some settings).
/// Combinations are made one by one, so that a wrong setting is reported before the other combinations take memory.
pub struct Product<'a> {
    /// The dotted keys of settings, each with its list of values, which is not empty.
    lists: Vec<(&'a String, &'a [Value])>,
    /// The number of combinations: the product of the numbers of values. It is `usize::MAX` if it would be larger.
    pub count: usize,
}

impl<'a> Product<'a> {
    /// The product of the lists of values in `table`, which maps each dotted key to a list.
    ///
    /// # Errors
    /// A key has no list of values, or an empty one; the text names the key.
    pub fn of(table: &'a Map<String, Value>) -> Result<Self, String> {
        let mut product = Self {
            lists: Vec::new(),
            count: 1,
        };
        for (key, values) in table {
            let values = values.as_array().filter(|values| !values.is_empty());
            let values =
                values.ok_or_else(|| format!("sweeps.over: {key} takes a list of values"))?;
            product.lists.push((key, values));
            product.count = product.count.saturating_mul(values.len());
        }
        Ok(product)
    }

    /// The combination with index `index`, which must be below `count`: one value for each key. The values of the last key
    /// change fastest.
    pub fn choice(&self, mut index: usize) -> Map<String, Value> {
        let mut choice = Vec::new();
        for (key, values) in self.lists.iter().rev() {
            choice.push(((*key).clone(), values[index % values.len()].clone()));
            index /= values.len();
        }
        choice.into_iter().rev().collect()
    }
}

//! Lists the combinations of values that a sweep of a plan stands for. Each combination becomes one configuration.

use serde_json::{Map, Value};

/// All combinations of values in a sweep, which is the part of a plan that lists values for some settings. A combination has
/// one value for each setting, and becomes one configuration of the study. Combinations are made one by one, so that a wrong
/// setting is reported before the other combinations take memory.
pub struct Product<'a> {
    /// The settings that the sweep varies: pairs of a dotted key, such as `direct.mis`, and the list of values of this
    /// setting, which is not empty.
    lists: Vec<(&'a String, &'a [Value])>,
    /// The number of combinations: the product of the lengths of all lists. It is `usize::MAX` if this product is too large
    /// for a `usize`. A plan with too many combinations is refused before they are made.
    pub count: usize,
}

impl<'a> Product<'a> {
    /// Prepares the combinations of the values in `table`, which maps the dotted key of each setting to a list of values.
    ///
    /// # Errors
    /// The value of a key is not a list, or is an empty list. The text names the key.
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

    /// The combination with the index `index`, which must be below `count`, as a map from each dotted key to one value. From
    /// one index to the next, the value of the last key changes first.
    pub fn choice(&self, mut index: usize) -> Map<String, Value> {
        let mut choice = Vec::new();
        for (key, values) in self.lists.iter().rev() {
            choice.push(((*key).clone(), values[index % values.len()].clone()));
            index /= values.len();
        }
        choice.into_iter().rev().collect()
    }
}

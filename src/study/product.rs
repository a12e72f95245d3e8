//! The combinations of values that a sweep goes over.

use serde_json::{Map, Value};

/// All combinations of one value for each key; each is made on demand, so that the first wrong one ends the work.
pub struct Product<'a> {
    /// The values of each key, at least one.
    lists: Vec<(&'a String, &'a [Value])>,
    /// The number of combinations.
    pub count: usize,
}

impl<'a> Product<'a> {
    /// The product of the lists in a table.
    ///
    /// # Errors
    /// A key without a list of values; the text names it.
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

    /// Combination `number`, below `count`. The values of the last key change fastest.
    pub fn choice(&self, mut number: usize) -> Map<String, Value> {
        let mut choice = Vec::new();
        for (key, values) in self.lists.iter().rev() {
            choice.push(((*key).clone(), values[number % values.len()].clone()));
            number /= values.len();
        }
        choice.into_iter().rev().collect()
    }
}

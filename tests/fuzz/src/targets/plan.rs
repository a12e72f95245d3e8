//! Plans of studies, and the configurations in them.

use crate::checked;
use headwater::study::plan::Plan;

/// The most configurations that are resolved twice.
const FEW: usize = 8;

/// Loads the file, and checks what its loader promises; whether it is TOML with a key.
pub fn run(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else {
        return false;
    };
    let Some(mut plan) = checked(Plan::parse("a.toml", text)) else {
        let table = text.parse::<toml::Table>();
        return table.is_ok_and(|table| !table.is_empty());
    };
    let resolved = checked(plan.resolve());
    plan.quicken();
    assert!(plan.most_seeds() >= plan.seeds);
    if resolved.is_some_and(|all| all.len() <= FEW) {
        let again = plan.resolve();
        again.expect("a quick plan has the same configurations");
    }
    true
}

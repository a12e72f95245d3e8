//! Plans of studies, and the configurations in them.

use crate::checked;
use headwater::study::plan::Plan;

/// The most configurations that are resolved twice.
const FEW: usize = 8;

pub fn run(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let Some(mut plan) = checked(Plan::parse("a.toml", text)) else {
        return;
    };
    let resolved = checked(plan.resolve());
    plan.quicken();
    assert!(plan.most_seeds() >= plan.seeds);
    if resolved.is_some_and(|all| all.len() <= FEW) {
        let again = plan.resolve();
        again.expect("a quick plan has the same configurations");
    }
}

pub use crate::has_key as has_header;

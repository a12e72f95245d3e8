//! Plans of studies, and the configurations in them.

use crate::checked;
use headwater::study::plan::Plan;

/// Loads the file, and checks what its loader promises; whether it is TOML.
pub fn run(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else {
        return false;
    };
    let Some(mut plan) = checked(Plan::parse("a.toml", text)) else {
        return text.parse::<toml::Table>().is_ok();
    };
    let resolved = checked(plan.resolve());
    plan.quicken();
    assert!(plan.most_seeds() >= plan.seeds);
    if resolved.is_some() {
        let again = plan.resolve();
        again.expect("a quick plan has the same configurations");
    }
    true
}

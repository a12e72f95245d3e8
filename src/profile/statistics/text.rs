//! The reports of the driver's compiler about pipelines (registers, memory, occupancy), as a table in text for users.

use super::Pipeline;
use std::fmt::Write;

/// The device, the driver, and a table with one line per tracer and pass. If a pass has several pipelines, the line shows
/// the values of the worst one. This is the pipeline with the least occupancy; among equal ones it has the most scratch
/// memory, then the most registers, then the most instructions. `pipelines` must be sorted by tracer and pass. The text is
/// empty if there are no pipelines.
pub fn table(pipelines: &[Pipeline]) -> String {
    let mut text = String::new();
    let Some(first) = pipelines.first() else {
        return text;
    };
    let _ = writeln!(text, "device {}; {}", first.device, first.driver);
    let _ = write!(
        text,
        "{:12} {:18} {:>5} {:>6} {:>6} {:>8} {:>9} {:>7} {:>9} {:>7} {:>6} {:>7}  used by",
        "# tracer",
        "pass",
        "SPIRV",
        "group",
        "VGPRs",
        "spilled",
        "scratch_B",
        "LDS_B",
        "code_B",
        "instr",
        "waves",
        "occup_%"
    );
    let number = |value: Option<u64>| value.map_or_else(|| "-".into(), |n| n.to_string());
    for variants in pipelines.chunk_by(|a, b| (&a.tracer, &a.pass) == (&b.tracer, &b.pass)) {
        let badness = |one: &Pipeline| {
            let occupancy = one.occupancy.map(|part| -(part * 1e4) as i64);
            (occupancy, one.scratch_bytes, one.vgprs, one.instructions)
        };
        let Some(worst) = variants.iter().max_by_key(|one| badness(one)) else {
            continue;
        };
        let occupancy = worst.occupancy.map(|part| format!("{:.1}", 100.0 * part));
        let _ = write!(
            text,
            "\n{:12} {:18} {:>5} {:>6} {:>6} {:>8} {:>9} {:>7} {:>9} {:>7} {:>6} {:>7}  {}; {}",
            worst.tracer,
            worst.pass,
            variants.len(),
            worst.subgroup_size,
            number(worst.vgprs),
            number(worst.spilled_vgprs),
            number(worst.scratch_bytes),
            number(worst.lds_bytes),
            number(worst.code_bytes),
            number(worst.instructions),
            number(worst.waves),
            occupancy.unwrap_or_else(|| "-".into()),
            worst.scenes.join(" "),
            worst.settings.join(" ")
        );
    }
    text
}

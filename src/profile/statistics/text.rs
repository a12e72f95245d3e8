//! Statistics of pipelines (registers, memory, occupancy) as a table in text.

use super::Pipeline;
use std::fmt::Write;

/// A table with one line per tracer and pass, for the worst pipeline of the pass. The worst has the least occupancy; among
/// pipelines with equal occupancy it has the most scratch memory, then the most registers, then the most instructions.
/// `pipelines` must be sorted by tracer and pass. Without any, the text is empty.
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

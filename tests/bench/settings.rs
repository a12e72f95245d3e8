//! Measures the time to read settings: from a file with many keys, and from as many `--set` arguments.
//!
//! `cargo bench --bench settings` prints one line per number of keys: `settings keys=… config=… set=…`, with median times in
//! milliseconds. Each key is set to its default, so the settings stay the same.

use headwater::base::toml_text::TomlText;
use headwater::metrics::statistics::median;
use headwater::render::Settings;
use std::time::Instant;

const ROUNDS: usize = 9;

/// The median time of several runs of `work`, in milliseconds.
fn time(mut work: impl FnMut()) -> f64 {
    median((0..ROUNDS).map(|_| {
        let start = Instant::now();
        work();
        1e3 * start.elapsed().as_secs_f64()
    }))
}

fn main() {
    let settings = Settings::default();
    let all = settings.describe().unwrap();
    for count in [1, 10, 80] {
        let chosen = all.iter().cycle().take(count);
        let lines: Vec<String> = chosen.map(|s| format!("{}={}", s.key, s.value)).collect();
        // A key stands in a file only once.
        let distinct = &lines[..count.min(all.len())];
        let source = TomlText::new("bench.toml", &distinct.join("\n"));
        let config = time(|| {
            let changes = source.parse().unwrap();
            settings.with_toml(&source, &[], &changes).unwrap();
        });
        let set = time(|| {
            lines.iter().fold(settings.clone(), |settings, line| {
                let change = Settings::parse_change(line).unwrap();
                settings.with(&change).unwrap()
            });
        });
        println!(
            "settings keys={} config={config:.2} set={set:.2}",
            distinct.len()
        );
    }
}

//! Tests of world reservoirs. Their table and its prefix sum are compared with twins on the CPU, for random keys and for
//! keys that collide. Their pictures must not depend on the number of threads. `bias.rs` checks their bias.

mod support;

use headwater::device_scene::shaders::spirv;
use headwater::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use headwater::procedural;
use headwater::render::Settings;
use headwater::render::presets::Preset;
use headwater::render::settings::{DirectMode, IndirectMode, Secondary};
use headwater::render::world_reservoirs::prefix_sum::PrefixSum;
use headwater::render::world_reservoirs::table::{TableSize, WorldTable};
use headwater::shader_interface::{
    COUNTER_CELLS, COUNTER_DROPPED, COUNTER_SLOTS, COUNTER_VERTICES, COUNTERS, NONE,
    RestirConstants, Specialisation, Variant, WORLD_VERTEX_BITS,
};
use std::collections::BTreeMap;
use std::process::Command;
use std::sync::Arc;
use support::random::Random;

fn pass(device: &Arc<Device>, variant: Variant, name: &str) -> headwater::Result<ComputePass> {
    let constants = Specialisation {
        counting: true,
        ..Specialisation::default()
    };
    ComputePass::new(device, name, &spirv(name, variant)?, &constants.words())
}

/// The table and the lists that the device makes from keys, and its counters.
#[derive(PartialEq, Debug)]
struct Lists {
    table: Vec<u32>,
    offsets: Vec<u32>,
    list: Vec<u32>,
    vertices: u32,
    cells: u32,
    slots: u32,
    dropped: u32,
}

fn lists(keys: &[u32], size: TableSize, frame: u32) -> Lists {
    let (device, selection) = support::open_device(None);
    let variant = selection.variant;
    let table = WorldTable::new(&device, size, |name| pass(&device, variant, name)).unwrap();
    let mut constants = RestirConstants {
        frame,
        ..RestirConstants::default()
    };
    constants.view.interleave = 2;
    size.write(&mut constants.world);
    let uniform = Usage {
        uniform: true,
        ..Usage::default()
    };
    let restir = Buffer::from_slice(&device, "restir", &[constants], uniform).unwrap();
    let zeros = [0_u32; COUNTERS as usize];
    let counters = Buffer::from_slice(&device, "counters", &zeros, Usage::default()).unwrap();
    table.keys.write(keys).unwrap();
    let mut recording = Recording::new(&device).unwrap();
    table.record(&mut recording, &restir, &counters).unwrap();
    recording.finish().unwrap();
    support::assert_no_messages(&device);
    let slots = size.slots() as usize;
    let cells: Vec<u32> = table.cells.read(2 * slots + 1).unwrap();
    let counted: Vec<u32> = counters.read(COUNTERS as usize).unwrap();
    Lists {
        offsets: cells[slots..=2 * slots].to_vec(),
        table: cells[..slots].to_vec(),
        list: table.list.read(keys.len()).unwrap(),
        vertices: counted[COUNTER_VERTICES as usize],
        cells: counted[COUNTER_CELLS as usize],
        slots: counted[COUNTER_SLOTS as usize],
        dropped: counted[COUNTER_DROPPED as usize],
    }
}

/// Checks the table and the lists of the vertices with these keys against the rules, and returns the fraction of vertices
/// that are in a list. `fraction` is the number of table slots per vertex.
fn check(name: &str, keys: &[u32], fraction: f64) -> f64 {
    let size = TableSize::new(keys.len() as u64, fraction);
    let found = lists(keys, size, 3);
    assert_eq!(found, lists(keys, size, 3), "{name}: two runs differ");

    // A bucket keeps the largest of its keys.
    let mut buckets: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for key in keys.iter().filter(|key| **key != 0) {
        let bucket = buckets.entry(key & (size.buckets as u32 - 1)).or_default();
        bucket.push(*key);
    }
    let mut table = vec![0; size.slots() as usize];
    for (index, bucket) in &mut buckets {
        bucket.sort_unstable_by(|a, b| b.cmp(a));
        bucket.dedup();
        let slots = size.bucket_slots as usize;
        for (slot, key) in bucket.iter().take(slots).enumerate() {
            table[*index as usize * slots + slot] = *key;
        }
    }
    assert_eq!(found.table, table, "{name}: table");

    // Offsets are the sums of the numbers of vertices.
    let slots: BTreeMap<u32, usize> = (table.iter().enumerate())
        .filter(|(_, key)| **key != 0)
        .map(|(slot, key)| (*key, slot))
        .collect();
    let mut offsets = vec![0; table.len() + 1];
    for slot in keys.iter().filter_map(|key| slots.get(key)) {
        offsets[slot + 1] += 1;
    }
    for slot in 0..table.len() {
        offsets[slot + 1] += offsets[slot];
    }
    assert_eq!(found.offsets, offsets, "{name}: offsets");

    // Each vertex is once in the list of its cell, or was dropped.
    let mut is_listed = vec![false; keys.len()];
    for (key, slot) in &slots {
        for entry in &found.list[offsets[*slot] as usize..offsets[slot + 1] as usize] {
            if *entry == 0 {
                continue;
            }
            let vertex = ((entry & ((1 << WORLD_VERTEX_BITS) - 1)) - 1) as usize;
            assert_eq!(
                keys[vertex], *key,
                "{name}: vertex {vertex} is in the list of another cell"
            );
            assert!(
                !is_listed[vertex],
                "{name}: vertex {vertex} is listed twice"
            );
            is_listed[vertex] = true;
        }
    }
    let rest = &found.list[offsets[table.len()] as usize..];
    assert!(
        rest.iter().all(|entry| *entry == 0),
        "{name}: entries beyond all lists"
    );
    let listed = is_listed.iter().filter(|is| **is).count();
    let with_key = keys.iter().filter(|key| **key != 0).count();
    assert_eq!(found.vertices as usize, with_key, "{name}: vertices");
    assert_eq!(found.cells as usize, slots.len(), "{name}: cells");
    assert_eq!(found.slots as usize, table.len(), "{name}: slots");
    assert_eq!(
        found.dropped as usize,
        with_key - listed,
        "{name}: vertices dropped"
    );
    println!(
        "{name}: {listed} of {with_key} vertices, {} cells",
        slots.len()
    );
    listed as f64 / with_key.max(1) as f64
}

#[test]
fn every_vertex_is_in_the_list_of_its_cell_or_counted_as_dropped() {
    let mut random = Random(7);
    let mut draw = |count: usize, cells: u32| -> Vec<u32> {
        // Hashed as the keys of cells are, and a tenth without a cell.
        let key = |n: u32| (n + 1).wrapping_mul(0x9E37_79B1).rotate_left(13).max(1);
        let draws = (0..count).map(|_| (random.unit() * 4_294_967_296.0) as u32);
        draws
            .map(|n| {
                if n % 10 == 0 {
                    0
                } else {
                    key((n >> 4) % cells)
                }
            })
            .collect()
    };
    // Of n vertices that take one of n slots at random, 1 − 1/e stay.
    let stays = 1.0 - (-1.0_f64).exp();
    for (name, count, cells) in [
        ("many in each", 100_000, 500),
        ("few in each", 100_000, 10_000),
        ("more cells than slots", 30_000, 30_000),
        ("one cell", 20_000, 1),
        ("one vertex", 1, 1),
    ] {
        let fraction = check(name, &draw(count, cells), 0.25);
        if cells == 500 {
            assert!(
                (fraction - stays).abs() < 0.01,
                "{fraction} of the vertices are in lists"
            );
        }
    }
    check("a table of one slot", &draw(5000, 300), 1e-9);
    check(
        "a table for 1/100 of the vertices",
        &draw(100_000, 10_000),
        0.01,
    );
    check("none", &[0; 1000], 0.25);
}

#[test]
fn colliding_keys_are_dropped_by_rule() {
    // All in one bucket, in ascending and in descending order, and the largest and the smallest key there are.
    let buckets = TableSize::new(4096, 0.25).buckets as u32;
    let ascending: Vec<u32> = (1..=4096).map(|n| n * buckets).collect();
    let descending: Vec<u32> = ascending.iter().rev().copied().collect();
    check("ascending keys of one bucket", &ascending, 0.25);
    check("descending keys of one bucket", &descending, 0.25);
    let mut extremes = vec![u32::MAX; 2048];
    extremes.extend([1; 2048]);
    check("largest and smallest key", &extremes, 0.25);
}

#[test]
fn prefix_sums_are_exact_at_any_size() {
    let (device, selection) = support::open_device(None);
    let mut random = Random(11);
    let powers = (1..=21).flat_map(|k| [(1 << k) - 1, 1 << k, (1 << k) + 1]);
    for count in [0, 1_u64].into_iter().chain(powers).chain([10_000_000]) {
        // Sums wrap around, as they do on both sides.
        let mut values: Vec<u32> = (0..count)
            .map(|_| (random.unit() * 4_294_967_296.0) as u32)
            .collect();
        let expected: Vec<u32> = (values.iter())
            .scan(0_u32, |sum, value| {
                let before = *sum;
                *sum = sum.wrapping_add(*value);
                Some(before)
            })
            .collect();
        values.resize(PrefixSum::length(count) as usize, NONE);
        // What lies before the first value stays.
        let first = count % 3;
        values.splice(..0, (0..first).map(|_| NONE));
        let buffer = Buffer::from_slice(&device, "values", &values, Usage::default()).unwrap();
        let sum =
            PrefixSum::new(first, count, |name| pass(&device, selection.variant, name)).unwrap();
        let mut recording = Recording::new(&device).unwrap();
        sum.record(&mut recording, &buffer).unwrap();
        recording.finish().unwrap();
        let found: Vec<u32> = buffer.read((first + count) as usize).unwrap();
        let (before, sums) = found.split_at(first as usize);
        assert!(sums == expected, "{count} values");
        assert!(before.iter().all(|value| *value == NONE), "{count} values");
    }
    support::assert_no_messages(&device);
}

/// Settings for light that was scattered at least twice, with one path per pixel.
fn settings(secondary: Secondary) -> Settings {
    let mut settings = Preset::named("accurate").unwrap().settings().unwrap();
    settings.direct.mode = DirectMode::Off;
    settings.indirect.mode = IndirectMode::Path;
    settings.indirect.secondary = secondary;
    settings
}

#[test]
fn few_lights_have_none() {
    let cornell = procedural::generate("cornell", &[]).unwrap();
    let bits = |settings: &Settings| support::frame_bits(&cornell, settings, None);
    let mut world = settings(Secondary::WorldReservoirs);
    assert!(bits(&world) == bits(&settings(Secondary::Ris)));
    world.world_reservoirs.min_lights = 0;
    assert!(bits(&world) != bits(&settings(Secondary::Ris)));
}

mod thorough {
    use super::*;

    /// Atomics decide which vertices are in a cell and which are dropped, but the order of threads must not matter.
    #[test]
    fn pictures_do_not_depend_on_the_number_of_threads() {
        let folder = tempfile::tempdir().unwrap();
        for table in ["0.25", "0.0025"] {
            let picture = |threads: &str| {
                let path = folder.path().join(format!("{threads}.exr"));
                let mut command = Command::new(env!("CARGO_BIN_EXE_headwater"));
                command.args([
                    "render",
                    "colourful-mess",
                    "--preset",
                    "accurate",
                    "--width",
                    "96",
                ]);
                command.args(["--bounces", "4", "--frames", "4"]);
                let table = format!("world_reservoirs.table={table}");
                let sets = [
                    "indirect.secondary=world-reservoirs",
                    "world_reservoirs.depth=3",
                    &table,
                ];
                command.args(sets.iter().flat_map(|set| ["--set", *set]));
                command.arg("-o").arg(&path);
                // Of llvmpipe; other drivers render the same twice.
                command.env("LP_NUM_THREADS", threads);
                let output = command.output().unwrap();
                assert!(output.status.success(), "{output:?}");
                std::fs::read(&path).unwrap()
            };
            assert!(picture("1") == picture("2"), "table={table}");
        }
    }
}

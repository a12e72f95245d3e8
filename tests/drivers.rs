//! What is assumed of a driver, measured on it.

mod support;

use headwater::gpu::compiler::{self, Sources};
use headwater::gpu::{Buffer, ComputePass, Recording, Usage};

headwater::bindings! {
    /// What the pass `loops` is bound to.
    pub struct Loops {
        write turns,
    }
}

const LOOPS: &str = "
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 1) in;
layout(scalar) buffer TurnsBlock { uint at[]; } turns;
layout(push_constant, scalar) uniform CountBlock { uint outer; uint inner; };
void main() {
    uint taken = 0u;
    for (uint i = 0u; i < outer; i++) {
        for (uint j = 0u; j < inner; j++) {
            // Not foreseeable, so that no compiler takes a sum for the loop.
            taken += (taken ^ i ^ j) == 0x12345678u ? 0u : 1u;
        }
    }
    turns.at[0] = taken;
}
";

#[test]
fn loops_end_where_they_should_or_where_the_driver_is_known_to_end_them() {
    let (device, _) = support::open_device(None);
    let words = compiler::compile("loops.comp", LOOPS, &Sources::new(), &[]).unwrap();
    let pass = ComputePass::new(&device, "loops", &words, &[]).unwrap();
    let turns = Buffer::new(&device, "turns", 4, Usage::default()).unwrap();
    let taken = |outer: u32, inner: u32| {
        let mut recording = Recording::new(&device).unwrap();
        let bindings = Loops { turns: &turns };
        recording
            .pass(&pass, &bindings, &[outer, inner], [1, 1, 1])
            .unwrap();
        recording.finish().unwrap();
        turns.read::<u32>(1).unwrap()[0]
    };
    let limit = device.info.loop_turns;
    assert_eq!(taken(1, 65_534), 65_534);
    assert_eq!(taken(100, 640), 64_000);
    for (outer, inner) in [(1, 1_000_000), (1000, 1000)] {
        let turns = taken(outer, inner);
        println!("{outer} × {inner}: {turns}, {limit:?}");
        // The outer loop's turns count too.
        assert!(turns == outer * inner || limit.is_some_and(|limit| turns <= limit));
    }
    support::assert_no_messages(&device);
}

//! Tests that measure properties which the code assumes of drivers.

mod support;

use headwater::gpu::{Bindings, Buffer, ComputePass, Recording, Resource, Usage};
use headwater::shader_interface::compiler::{self, Sources};

headwater::bindings! {
    /// The bindings of the pass `loops`, which counts the turns of its loops.
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
        // The outer loop's turns count too, which are at most as many as the inner one's.
        let ended = |limit: u32| (limit / 2..=limit).contains(&turns);
        assert!(turns == outer * inner || limit.is_some_and(ended));
    }
    support::assert_no_messages(&device);
}

struct Fetches<'a> {
    texels: &'a Buffer,
    sums: &'a Buffer,
}

impl<'a> Bindings<'a> for Fetches<'a> {
    fn own(&self) -> Vec<(&'static str, Resource<'a>)> {
        vec![
            ("texels", Resource::Texels(self.texels)),
            ("sums", Resource::Write(self.sums)),
        ]
    }
}

const FETCHES: &str = "
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 64) in;
uniform utextureBuffer texels;
layout(scalar) buffer SumsBlock { uint at[]; } sums;
layout(push_constant, scalar) uniform LastBlock { uint last; };
void main() {
    // The ends of the buffer and of its halves, quarters and so on.
    uint i = gl_LocalInvocationIndex;
    uvec4 texel = texelFetch(texels, max(int(last >> (i / 2u)) - int(i & 1u), 0));
    sums.at[i] = texel.x ^ texel.y ^ texel.z ^ texel.w;
}
";

#[test]
fn texels_are_read_as_far_as_the_device_says_and_refused_beyond() {
    let (device, _) = support::open_device(None);
    let usage = Usage {
        texels: true,
        ..Usage::default()
    };
    let reach = device.info.max_texel_bytes();
    let error = Buffer::new(&device, "too many", reach + 16, usage);
    let error = error.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(error.contains(&(reach + 16).to_string()), "{error}");
    // Where texels reach further than any buffer, that is the limit which speaks.
    let spoke = if reach + 16 <= device.info.max_buffer_size {
        "as texels"
    } else {
        "in one buffer"
    };
    assert!(error.contains(spoke), "{error}");
    // All of lavapipe's 2 GiB take a while; these are more than it binds otherwise.
    let most = if support::takes_largest() {
        1 << 31
    } else {
        160 << 20
    };
    let bytes = reach.min(device.info.max_buffer_size).min(most) / 16 * 16;
    let words: Vec<u32> = (0..bytes as u32 / 4)
        .map(|i| i.wrapping_mul(2_654_435_761))
        .collect();
    let texels = Buffer::from_slice(&device, "texels", &words, usage).unwrap();
    let sums = Buffer::new(&device, "sums", 256, Usage::default()).unwrap();
    let code = compiler::compile("fetches.comp", FETCHES, &Sources::new(), &[]).unwrap();
    let pass = ComputePass::new(&device, "fetches", &code, &[]).unwrap();
    let mut recording = Recording::new(&device).unwrap();
    let bindings = Fetches {
        texels: &texels,
        sums: &sums,
    };
    let last = (bytes / 16 - 1) as u32;
    recording.pass(&pass, &bindings, &last, [1; 3]).unwrap();
    recording.finish().unwrap();
    let sums: Vec<u32> = sums.read(64).unwrap();
    for (i, sum) in sums.iter().enumerate() {
        let texel = (last as usize >> (i / 2)).saturating_sub(i & 1);
        let expected = words[4 * texel..][..4].iter().fold(0, |a, b| a ^ b);
        assert_eq!(*sum, expected, "texel {texel} of {last}");
    }
    support::assert_no_messages(&device);
}

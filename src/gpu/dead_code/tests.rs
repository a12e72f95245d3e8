//! Tests of the removal of dead code. They use a shader with code that cannot run for some values of a specialisation
//! constant.

use super::*;
use crate::gpu::reflection::{Reflection, parse};
use crate::gpu::specialise::specialise;
use crate::shader_interface::compiler::{self, Sources};
use rspirv::binary::Assemble;

const SHADER: &str = "#version 460
    layout(constant_id = 0) const uint TECHNIQUE = 1u;
    readonly buffer One { uint at[]; } one;
    readonly buffer Two { uint at[]; } two;
    readonly buffer Three { uint at[]; } three;
    readonly buffer Four { uint at[]; } four;
    buffer Results { uint at[]; } results;
    bool is_two() { return TECHNIQUE == 2u && results.at[0] > 7u; }
    uint from_three(uint i) { return three.at[i]; }
    void main() {
        uint sum = 0u;
        bool in_two = is_two();
        for (uint i = 0u; i < results.at[1]; i += 1u) {
            if (in_two) sum += two.at[i];
            if (TECHNIQUE == 3u || in_two) sum += from_three(i);
            switch (TECHNIQUE) {
            case 1u: sum += one.at[i]; break;
            case 4u: sum += four.at[i]; break;
            default: sum += 1u;
            }
            if (TECHNIQUE == 1u && sum > 9u) break;
        }
        results.at[2] = sum;
    }";

fn without_dead_code(technique: u32) -> Module {
    let words = compiler::compile("test.comp", SHADER, &Sources::new(), &[]).unwrap();
    let mut module = parse(&words).unwrap();
    specialise(&mut module, &[(0, technique)]);
    remove_dead_code(&mut module);
    module
}

/// A binding disappears if only code that cannot be reached uses it. Such code is recognised behind conditions, function
/// calls, variables, and the results of `&&` and `||`.
#[test]
fn what_a_technique_does_not_use_is_not_bound() {
    let bound = |technique| {
        let interface = Reflection::of(without_dead_code(technique)).interface();
        let names = interface.unwrap().bindings.into_iter().map(|b| b.name);
        names.collect::<Vec<_>>()
    };
    assert_eq!(bound(1), ["one", "results"]);
    assert_eq!(bound(2), ["two", "three", "results"]);
    assert_eq!(bound(3), ["three", "results"]);
    assert_eq!(bound(4), ["four", "results"]);
    assert_eq!(bound(5), ["results"]);
}

/// A constant that no code reads leaves no trace in the words of the shader. So shaders that differ only in the value of
/// this constant are compiled once.
#[test]
fn a_number_without_a_use_does_not_change_the_words() {
    let declares = "layout(constant_id = 0) const uint TECHNIQUE = 1u;";
    let another = "layout(constant_id = 1) const uint OTHER = 77u;";
    let shader = SHADER.replace(declares, &format!("{declares} {another}"));
    let words = compiler::compile("test.comp", &shader, &Sources::new(), &[]).unwrap();
    let [one, two] = [1001, 1002].map(|other| {
        let mut module = parse(&words).unwrap();
        specialise(&mut module, &[(0, 1), (1, other)]);
        remove_dead_code(&mut module);
        module.assemble()
    });
    assert!(one == two);
}

/// Two runs with the same shader must produce the same words, because drivers cache compiled shaders by a hash of the words.
#[test]
fn the_words_are_always_the_same() {
    for technique in 1..5 {
        let words = without_dead_code(technique).assemble();
        for _ in 0..8 {
            assert!(without_dead_code(technique).assemble() == words);
        }
    }
}

#[test]
fn nothing_names_what_is_gone() {
    let module = without_dead_code(5);
    let there: HashSet<Word> = module.all_inst_iter().filter_map(|i| i.result_id).collect();
    let names = module.all_inst_iter().flat_map(|i| &i.operands);
    let gone: Vec<Word> = names
        .filter_map(Operand::id_ref_any)
        .filter(|id| !there.contains(id))
        .collect();
    assert!(gone.is_empty(), "{gone:?}");
    assert_eq!(module.functions.len(), 2);
}

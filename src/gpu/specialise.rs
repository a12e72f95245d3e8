//! Specialisation of shaders before the driver compiles them. Specialisation constants become ordinary constants, and an
//! expression of constants is replaced by its result if `fold` can compute it.
//!
//! Drivers can specialise shaders themselves. But SwiftShader's optimiser keeps and compiles code even if it can only run
//! when a specialisation constant has another value. Without this module, SwiftShader took 12 minutes to compile the passes
//! of the preset `accurate`; now it takes 6 seconds.

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Op};
use std::collections::{HashMap, HashSet};

/// Replaces the specialisation constants of a shader by ordinary constants. `constants` has pairs of `constant_id` and value
/// as a 32-bit word; a boolean is 0 or 1. A constant of the shader without a pair gets its default value, and a pair whose
/// id the shader does not have is ignored.
pub fn specialise(module: &mut Module, constants: &[(u32, u32)]) {
    let mut given = HashMap::new();
    module.annotations.retain(|i| match &i.operands[..] {
        [
            Operand::IdRef(target),
            Operand::Decoration(Decoration::SpecId),
            Operand::LiteralBit32(id),
        ] => {
            let found = constants.iter().find(|(constant, _)| constant == id);
            given.extend(found.map(|(_, word)| (*target, *word)));
            false
        }
        _ => true,
    });
    let mut booleans = HashSet::new();
    // The words of scalar constants; booleans are 0 or 1.
    let mut values = HashMap::new();
    for instruction in &mut module.types_global_values {
        let Some(result) = instruction.result_id else {
            continue;
        };
        let default = match (instruction.class.opcode, &instruction.operands[..]) {
            (Op::TypeBool, _) => {
                booleans.insert(result);
                None
            }
            (Op::ConstantTrue | Op::SpecConstantTrue, _) => Some(1),
            (Op::ConstantFalse | Op::SpecConstantFalse, _) => Some(0),
            (Op::Constant | Op::SpecConstant, [Operand::LiteralBit32(word)]) => Some(*word),
            (
                Op::SpecConstantOp,
                [
                    Operand::LiteralSpecConstantOpInteger(operation),
                    operands @ ..,
                ],
            ) => words_of(operands, &values).and_then(|words| fold(*operation, &words)),
            _ => None,
        };
        let Some(default) = default else { continue };
        let value = given.get(&result).copied().unwrap_or(default);
        values.insert(result, value);
        let is_boolean = (instruction.result_type).is_some_and(|result| booleans.contains(&result));
        let (opcode, operands) = match (is_boolean, value) {
            (true, 0) => (Op::ConstantFalse, Vec::new()),
            (true, _) => (Op::ConstantTrue, Vec::new()),
            (false, word) => (Op::Constant, vec![Operand::LiteralBit32(word)]),
        };
        *instruction = Instruction::new(
            opcode,
            instruction.result_type,
            instruction.result_id,
            operands,
        );
    }
}

/// The values of the module's scalar constants, by the SPIR-V ids of the constants. Each is a 32-bit word; a boolean is 0 or
/// 1. Removal of dead code computes from them which branches can be taken.
pub(super) fn words_of_constants(module: &Module) -> HashMap<u32, u32> {
    let globals = module.types_global_values.iter();
    globals
        .filter_map(|i| {
            let word = match (i.class.opcode, &i.operands[..]) {
                (Op::ConstantTrue, _) => 1,
                (Op::ConstantFalse, _) => 0,
                (Op::Constant, [Operand::LiteralBit32(word)]) => *word,
                _ => return None,
            };
            Some((i.result_id?, word))
        })
        .collect()
}

/// The values of all operands as 32-bit words, for [`fold`]. `values` maps the SPIR-V ids of constants to their words; the
/// result is `None` if an operand is not one of these ids.
fn words_of(operands: &[Operand], values: &HashMap<u32, u32>) -> Option<Vec<u32>> {
    let words = operands.iter().map(|operand| match operand {
        Operand::IdRef(id) => values.get(id).copied(),
        _ => None,
    });
    words.collect()
}

/// The result of an operation on booleans (0 or 1) or unsigned 32-bit integers, for specialisation and the removal of dead
/// code. It can compute logical operations, comparisons, `OpSelect`, +, − and ×. For any other operation, the result is
/// `None`. Such an operation stays in the shader, and the driver computes it.
pub(super) fn fold(operation: Op, operands: &[u32]) -> Option<u32> {
    let result = match (operation, operands) {
        (Op::LogicalNot, [a]) => u32::from(*a == 0),
        (Op::LogicalAnd, [a, b]) => a & b,
        (Op::LogicalOr, [a, b]) => a | b,
        (Op::IEqual | Op::LogicalEqual, [a, b]) => u32::from(a == b),
        (Op::INotEqual | Op::LogicalNotEqual, [a, b]) => u32::from(a != b),
        (Op::UGreaterThan, [a, b]) => u32::from(a > b),
        (Op::UGreaterThanEqual, [a, b]) => u32::from(a >= b),
        (Op::ULessThan, [a, b]) => u32::from(a < b),
        (Op::ULessThanEqual, [a, b]) => u32::from(a <= b),
        (Op::Select, [condition, a, b]) => *if *condition != 0 { a } else { b },
        (Op::IAdd, [a, b]) => a.wrapping_add(*b),
        (Op::ISub, [a, b]) => a.wrapping_sub(*b),
        (Op::IMul, [a, b]) => a.wrapping_mul(*b),
        _ => return None,
    };
    Some(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::reflection::parse;
    use crate::shader_interface::compiler::{self, Sources};

    const SHADER: &str = "#version 460
        layout(constant_id = 3) const uint COUNT = 5u;
        layout(constant_id = 8) const bool ON = true;
        layout(constant_id = 9) const bool DEFAULT = true;
        const bool BOTH = ON && COUNT > 6u, EITHER = !ON || COUNT == 7u;
        const uint PICKED = ON ? 3u * COUNT - 1u : COUNT + 10u;
        buffer Results { uint at[]; } results;
        void main() {
            results.at[0] = COUNT;
            results.at[1] = PICKED;
            results.at[2] = BOTH ? 1u : 0u;
            results.at[3] = EITHER ? 1u : 0u;
            results.at[4] = DEFAULT ? 1u : 0u;
            results.at[5] = COUNT / 2u;
        }";

    /// Specialises the test shader `SHADER` with `constants`, and returns the values that it stores to `results`, in the
    /// order of the stores. `None` stands for a value that is not a constant, because the driver must still compute it.
    fn stored(constants: &[(u32, u32)]) -> Vec<Option<u32>> {
        let words = compiler::compile("test.comp", SHADER, &Sources::new(), &[]).unwrap();
        let mut module = parse(&words).unwrap();
        specialise(&mut module, constants);
        let constant = |operand: &Operand| {
            let globals = &module.types_global_values;
            let found = globals.iter().find(|i| i.result_id == operand.id_ref_any());
            found.and_then(|i| match (i.class.opcode, &i.operands[..]) {
                (Op::Constant, [Operand::LiteralBit32(word)]) => Some(*word),
                _ => None,
            })
        };
        let instructions = module.all_inst_iter();
        let stores = instructions.filter(|i| i.class.opcode == Op::Store);
        stores.map(|i| constant(&i.operands[1])).collect()
    }

    #[test]
    fn values_and_what_follows_from_them_become_constants() {
        // Division is left to the driver.
        let with = |words: [u32; 5]| [&words.map(Some)[..], &[None]].concat();
        assert_eq!(stored(&[]), with([5, 14, 0, 0, 1]));
        assert_eq!(stored(&[(3, 7)]), with([7, 20, 1, 1, 1]));
        assert_eq!(stored(&[(3, 9), (8, 0)]), with([9, 19, 0, 1, 1]));
        assert_eq!(stored(&[(9, 0), (77, 1)]), with([5, 14, 0, 0, 0]));
    }

    /// If a shader is compiled with `Debug::Lines`, it keeps its source text and its `OpLine` instructions
    /// when it is specialised. Debuggers need both to show the line that runs.
    #[test]
    fn source_lines_stay() {
        let lines = |debug| {
            let words = compiler::compile_with("test.comp", SHADER, &Sources::new(), &[], debug);
            let mut module = parse(&words.unwrap()).unwrap();
            specialise(&mut module, &[(3, 7)]);
            let has_source = module.debug_string_source.iter().any(|instruction| {
                let text = |operand: &Operand| match operand {
                    Operand::LiteralString(text) => text.contains("results.at[1] = PICKED"),
                    _ => false,
                };
                instruction.operands.iter().any(text)
            });
            let blocks = module
                .functions
                .iter()
                .flat_map(|function| &function.blocks);
            let instructions = blocks.flat_map(|block| &block.instructions);
            let lines = instructions.filter(|i| i.class.opcode == Op::Line).count();
            (has_source, lines)
        };
        assert_eq!(lines(compiler::Debug::Names), (false, 0));
        let (has_source, lines) = lines(compiler::Debug::Lines);
        assert!(has_source && lines >= 6, "{has_source}, {lines} lines");
    }

    #[test]
    fn what_is_no_spirv_is_an_error() {
        assert!(parse(&[1, 2, 3]).is_err());
    }
}

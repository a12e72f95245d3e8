//! Removal of code that a specialised shader cannot run, and of the bindings that only such code uses.
//!
//! The source of a shader contains the code of all settings, and every binding that its code names must be bound, even if
//! the code cannot run. But devices limit the number of buffers that one shader can bind: to 30 with SwiftShader, and to 32
//! with lavapipe of Mesa 22. Lavapipe crashes beyond its limit.
//!
//! Conditional constant propagation finds the blocks that can be reached (Wegman and Zadeck, "Constant Propagation with
//! Conditional Branches", 1991). All other blocks are emptied, but not removed, so that the control flow keeps the structure
//! that SPIR-V requires.

use super::specialise::{fold, words_of_constants};
use rspirv::dr::{Block, Function, Instruction, Module, Operand};
use rspirv::spirv::{Op, Word};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Removes the code of `module` that no invocation can reach, and then the functions, variables and scalar constants that
/// nothing uses any more. The specialisation constants of `module` must already be ordinary constants.
pub fn remove_dead_code(module: &mut Module) {
    let mut constants = words_of_constants(module);
    let values = module.all_inst_iter();
    let types: HashMap<Word, Word> = values
        .filter_map(|i| Some((i.result_id?, i.result_type?)))
        .collect();
    let mut nulls = Nulls::new(module);
    let live = reached_blocks(&module.functions, &mut constants);
    for function in &mut module.functions {
        empty_other_blocks(function, &live, &types, &mut nulls);
    }
    nulls.declare(module);
    remove_functions(module);
    remove_variables(module);
    remove_constants(module);
    remove_names(module);
}

fn label_of(block: &Block) -> Option<Word> {
    block.label.as_ref()?.result_id
}

fn instructions_of(function: &Function) -> impl Iterator<Item = &Instruction> {
    function.blocks.iter().flat_map(|block| &block.instructions)
}

fn id_of_function(function: &Function) -> Option<Word> {
    function.def.as_ref()?.result_id
}

/// The labels of all blocks, in all functions of the module, that may run if their function is called; the caller empties
/// all others. `constants` maps the ids of constants to their words. The search adds to this map the id of each function
/// that always returns the same word, together with this word, because fewer blocks may then run in the function's callers.
fn reached_blocks(functions: &[Function], constants: &mut HashMap<Word, u32>) -> HashSet<Word> {
    loop {
        let mut live = HashSet::new();
        let mut returns = HashMap::new();
        for function in functions {
            let reached = Reached::of(function, constants);
            if let (Some(Known::Word(word)), Some(id)) =
                (reached.returned(function), id_of_function(function))
            {
                returns.insert(id, word);
            }
            live.extend(reached.blocks);
        }
        let before = constants.len();
        constants.extend(returns);
        // Who calls these may reach less.
        if constants.len() == before {
            return live;
        }
    }
}

/// Ids of the function's variables that have no initialiser, and that are used only by loads and stores of the whole
/// variable. [`Reached`] tracks the content of these variables only, because other accesses may change a part of a variable.
fn whole_variables(function: &Function) -> HashSet<Word> {
    let mut variables = HashSet::new();
    for instruction in instructions_of(function) {
        let operation = instruction.class.opcode;
        let is_plain = operation == Op::Variable && instruction.operands.len() == 1;
        variables.extend(instruction.result_id.filter(|_| is_plain));
        let whole = matches!(operation, Op::Load | Op::Store);
        for operand in &instruction.operands[usize::from(whole)..] {
            operand.id_ref_any().map(|id| variables.remove(&id));
        }
    }
    variables
}

/// Knowledge about a value or a variable of the shader: either it is one constant word in every invocation,
/// or it may vary. A branch whose condition is a known word reaches only one of its targets.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Known {
    /// The value is known: it is this 32-bit word in every invocation, where booleans are 0 or 1. Code can be removed if a
    /// branch depends on it.
    Word(u32),
    /// The value may differ between invocations, or cannot be computed before the shader runs.
    Varies,
}

/// Knowledge about a value that is always equal to one of several `values`, such as the result of a phi. It
/// is their common word if all have the same one, and otherwise [`Known::Varies`]. `None` if there are no
/// values.
fn common(mut values: impl Iterator<Item = Known>) -> Option<Known> {
    let first = values.next()?;
    Some(match values.all(|other| other == first) {
        true => first,
        false => Known::Varies,
    })
}

/// The blocks of one function that may run if the function is called, and the knowledge about the values in
/// them. All other blocks of the function are emptied.
struct Reached<'a> {
    constants: &'a HashMap<Word, u32>,
    /// Ids of the values that the instructions of the function compute, in all its blocks. Nothing is known about such a
    /// value until the search finds that the block of its instruction may run. Values that are neither in this set nor
    /// constants are always [`Known::Varies`].
    own: HashSet<Word>,
    /// Ids of the function's variables that are only loaded and stored as a whole, as [`whole_variables`] finds them.
    variables: HashSet<Word>,
    /// Knowledge so far about the values in the function, by id: the results of its instructions, and the
    /// content of its `variables`. A result is missing until the search finds that the block of its
    /// instruction may run. A variable is missing until the search finds that a store to it may run.
    known: HashMap<Word, Known>,
    /// Labels of the blocks that may run, as far as the search has found them.
    blocks: HashSet<Word>,
    /// The jumps between blocks that may be taken, as far as the search has found them: pairs of the label of a block and
    /// the label of its successor. A phi takes only values that arrive by such a jump.
    edges: HashSet<(Word, Word)>,
}

impl<'a> Reached<'a> {
    fn of(function: &Function, constants: &'a HashMap<Word, u32>) -> Self {
        let first = function.blocks.first().and_then(label_of);
        let mut reached = Self {
            constants,
            own: instructions_of(function)
                .filter_map(|i| i.result_id)
                .collect(),
            variables: whole_variables(function),
            known: HashMap::new(),
            blocks: first.into_iter().collect(),
            edges: HashSet::new(),
        };
        // A value never gets better known, and no edge is taken back: so it ends.
        loop {
            let mut is_new = false;
            for block in &function.blocks {
                is_new |= reached.visit(block);
            }
            if !is_new {
                return reached;
            }
        }
    }

    /// Evaluates the instructions of a block, and adds the blocks that may follow it to those that were reached. Does
    /// nothing if the block itself was not reached. Returns true if a new edge was reached or the knowledge of a value
    /// changed, so that all blocks must be visited again.
    fn visit(&mut self, block: &Block) -> bool {
        let Some(here) = label_of(block).filter(|label| self.blocks.contains(label)) else {
            return false;
        };
        let mut is_new = false;
        for instruction in &block.instructions {
            let operands = &instruction.operands;
            let (target, now) = match instruction.class.opcode {
                Op::Store => (
                    operands.first().and_then(Operand::id_ref_any),
                    operands.get(1).and_then(|o| self.operand(o)),
                ),
                // What it holds is what is stored in it.
                Op::Variable => continue,
                _ => (instruction.result_id, self.evaluate(instruction, here)),
            };
            let (Some(target), Some(now)) = (target, now) else {
                continue;
            };
            let now = match self.known.get(&target) {
                Some(before) if *before != now => Known::Varies,
                _ => now,
            };
            is_new |= self.known.insert(target, now) != Some(now);
        }
        for next in self.successors(block) {
            self.blocks.insert(next);
            is_new |= self.edges.insert((here, next));
        }
        is_new
    }

    /// Knowledge about an operand of an instruction: the word of a constant, or the result of the search for
    /// a value of this function. It is [`Known::Varies`] for literals, parameters and all other values.
    /// `None` if the search has not yet reached the instruction that computes the value.
    fn operand(&self, operand: &Operand) -> Option<Known> {
        let Operand::IdRef(id) = operand else {
            return Some(Known::Varies);
        };
        match self.constants.get(id) {
            Some(word) => Some(Known::Word(*word)),
            None if self.own.contains(id) => self.known.get(id).copied(),
            None => Some(Known::Varies),
        }
    }

    /// Knowledge about the result of an instruction in the block with the label `here`; `None` if there is
    /// none yet. That is the case for a phi until a value that arrives by a reached edge is known, and for a
    /// load of a tracked variable until a store to the variable is reached.
    fn evaluate(&self, instruction: &Instruction, here: Word) -> Option<Known> {
        let operands = &instruction.operands;
        let operation = instruction.class.opcode;
        if operation == Op::Phi {
            let pairs = operands.chunks_exact(2);
            let taken = pairs.filter(|pair| {
                pair[1]
                    .id_ref_any()
                    .is_some_and(|from| self.edges.contains(&(from, here)))
            });
            return common(taken.filter_map(|pair| self.operand(&pair[0])));
        }
        if operation == Op::Load
            && let Some(variable) = operands
                .first()
                .and_then(Operand::id_ref_any)
                .filter(|v| self.variables.contains(v))
        {
            return self.known.get(&variable).copied();
        }
        if operation == Op::FunctionCall {
            let called = operands.first().and_then(Operand::id_ref_any)?;
            let returned = self.constants.get(&called).copied();
            return Some(returned.map_or(Known::Varies, Known::Word));
        }
        let words: Vec<Option<u32>> = operands
            .iter()
            .map(|operand| match self.operand(operand) {
                Some(Known::Word(word)) => Some(word),
                _ => None,
            })
            .collect();
        let folded = match operation {
            // One operand may decide alone.
            Op::LogicalAnd if words.contains(&Some(0)) => Some(0),
            Op::LogicalOr if words.contains(&Some(1)) => Some(1),
            _ => {
                let words: Option<Vec<u32>> = words.into_iter().collect();
                words.and_then(|words| fold(operation, &words))
            }
        };
        Some(folded.map_or(Known::Varies, Known::Word))
    }

    /// Knowledge about the value that `function` returns. `None` if none of its blocks that may run returns a
    /// value.
    fn returned(&self, function: &Function) -> Option<Known> {
        let blocks = function.blocks.iter();
        let live = blocks.filter(|block| label_of(block).is_some_and(|l| self.blocks.contains(&l)));
        let ends = live.filter_map(|block| block.instructions.last());
        let returns = ends.filter(|i| i.class.opcode == Op::ReturnValue);
        common(returns.filter_map(|i| self.operand(i.operands.first()?)))
    }

    /// Labels of the blocks that may follow `block`. If the condition of its last instruction is a known constant, it is the
    /// label of the selected block only. Empty if the block ends the function.
    fn successors(&self, block: &Block) -> Vec<Word> {
        let Some(last) = block.instructions.last() else {
            return Vec::new();
        };
        let operands = &last.operands;
        let decided = operands.first().and_then(|operand| self.operand(operand));
        let all = |labels: &[Operand]| labels.iter().filter_map(Operand::id_ref_any).collect();
        match (last.class.opcode, decided) {
            (Op::Branch, _) => all(operands),
            (Op::BranchConditional, Some(Known::Word(word))) => {
                let taken = if word != 0 { 1 } else { 2 };
                operands
                    .get(taken)
                    .and_then(Operand::id_ref_any)
                    .into_iter()
                    .collect()
            }
            (Op::Switch, Some(Known::Word(word))) => {
                let cases = operands.get(2..).unwrap_or_default().chunks_exact(2);
                let mut matching = cases.filter(|case| case[0] == Operand::LiteralBit32(word));
                let taken = matching.next().map(|case| &case[1]).or(operands.get(1));
                taken.and_then(Operand::id_ref_any).into_iter().collect()
            }
            // The first operand is what decides.
            (Op::BranchConditional | Op::Switch, _) => all(operands.get(1..).unwrap_or_default()),
            _ => Vec::new(),
        }
    }
}

/// Zero constants (`OpConstantNull`) that replace values whose computation was removed; one for each type of such values.
/// They are sorted by the id of the type, so that a shader has the same words in every run, because drivers cache compiled
/// shaders by a hash of the words.
struct Nulls {
    by_type: BTreeMap<Word, Word>,
    next: Word,
}

impl Nulls {
    fn new(module: &Module) -> Self {
        Self {
            by_type: BTreeMap::new(),
            next: module.header.as_ref().map_or(0, |header| header.bound),
        }
    }

    fn of(&mut self, kind: Word) -> Operand {
        let next = &mut self.next;
        Operand::IdRef(*self.by_type.entry(kind).or_insert_with(|| {
            *next += 1;
            *next - 1
        }))
    }

    fn declare(self, module: &mut Module) {
        let constants = self.by_type.into_iter().map(|(kind, null)| {
            Instruction::new(Op::ConstantNull, Some(kind), Some(null), Vec::new())
        });
        module.types_global_values.extend(constants);
        if let Some(header) = &mut module.header {
            header.bound = self.next;
        }
    }
}

/// Removes all instructions of each block whose label is not in `live`, except its merge instruction and its terminator. If
/// such a terminator uses a removed result, or a phi of a live block uses a value from an emptied block, a zero constant
/// from `nulls` replaces it. `types` maps the id of each value to the id of its type.
fn empty_other_blocks(
    function: &mut Function,
    live: &HashSet<Word>,
    types: &HashMap<Word, Word>,
    nulls: &mut Nulls,
) {
    for block in &mut function.blocks {
        if label_of(block).is_some_and(|label| live.contains(&label)) {
            let selections = block.instructions.iter_mut();
            for selection in selections.filter(|i| i.class.opcode == Op::Phi) {
                let Some(kind) = selection.result_type else {
                    continue;
                };
                for pair in selection.operands.chunks_exact_mut(2) {
                    if pair[1]
                        .id_ref_any()
                        .is_some_and(|from| !live.contains(&from))
                    {
                        pair[0] = nulls.of(kind);
                    }
                }
            }
            continue;
        }
        block.instructions.retain(is_structure);
        if let Some(last) = block.instructions.last_mut()
            && matches!(
                last.class.opcode,
                Op::BranchConditional | Op::Switch | Op::ReturnValue
            )
            && let Some(kind) = last
                .operands
                .first()
                .and_then(Operand::id_ref_any)
                .and_then(|value| types.get(&value))
        {
            last.operands[0] = nulls.of(*kind);
        }
    }
}

/// True for merge instructions and terminators (branches, switches, returns). They make up the control flow, and stay in
/// blocks that cannot be reached.
fn is_structure(instruction: &Instruction) -> bool {
    matches!(
        instruction.class.opcode,
        Op::SelectionMerge
            | Op::LoopMerge
            | Op::Branch
            | Op::BranchConditional
            | Op::Switch
            | Op::Return
            | Op::ReturnValue
            | Op::Kill
            | Op::Unreachable
    )
}

/// Removes the functions that no entry point calls, directly or through other functions. A binding that only removed
/// functions use is then no longer needed.
fn remove_functions(module: &mut Module) {
    let by_id: HashMap<Word, &Function> = (module.functions.iter())
        .filter_map(|function| Some((id_of_function(function)?, function)))
        .collect();
    let entries = module.entry_points.iter();
    let mut waiting: Vec<Word> = entries
        .filter_map(|i| i.operands.get(1).and_then(Operand::id_ref_any))
        .collect();
    let mut called = HashSet::new();
    while let Some(next) = waiting.pop() {
        if called.insert(next)
            && let Some(function) = by_id.get(&next)
        {
            let calls = instructions_of(function).filter(|i| i.class.opcode == Op::FunctionCall);
            waiting.extend(calls.filter_map(|i| i.operands.first().and_then(Operand::id_ref_any)));
        }
    }
    module
        .functions
        .retain(|function| id_of_function(function).is_some_and(|id| called.contains(&id)));
}

/// Removes global variables that no function uses, such as buffers, and their entries in the interfaces of entry points. The
/// bindings of these variables then need no resource.
fn remove_variables(module: &mut Module) {
    let operands = (module.functions.iter())
        .flat_map(instructions_of)
        .flat_map(|i| &i.operands);
    let named: HashSet<Word> = operands.filter_map(Operand::id_ref_any).collect();
    let mut removed = HashSet::new();
    module.types_global_values.retain(|i| {
        let is_unused = |id: &Word| i.class.opcode == Op::Variable && !named.contains(id);
        let unused = i.result_id.filter(is_unused);
        removed.extend(unused);
        unused.is_none()
    });
    for entry in &mut module.entry_points {
        entry
            .operands
            .retain(|o| o.id_ref_any().is_none_or(|id| !removed.contains(&id)));
    }
}

/// Removes scalar constants that nothing uses. Shaders that differ only in the values of unused constants then have equal
/// words, so that a driver compiles them only once.
fn remove_constants(module: &mut Module) {
    let names = [Op::Name, Op::MemberName, Op::Decorate, Op::MemberDecorate];
    let operands = (module.all_inst_iter())
        .filter(|i| !names.contains(&i.class.opcode))
        .flat_map(|i| &i.operands);
    let named: HashSet<Word> = operands.filter_map(Operand::id_ref_any).collect();
    let numbers = [Op::Constant, Op::ConstantTrue, Op::ConstantFalse];
    module.types_global_values.retain(|i| {
        !numbers.contains(&i.class.opcode) || i.result_id.is_some_and(|id| named.contains(&id))
    });
}

/// Removes the names and decorations of ids that no longer exist, because SPIR-V with a name or decoration of a missing id
/// is not valid.
fn remove_names(module: &mut Module) {
    let there: HashSet<Word> = module.all_inst_iter().filter_map(|i| i.result_id).collect();
    let is_of_something = |i: &Instruction| {
        i.operands
            .first()
            .and_then(Operand::id_ref_any)
            .is_none_or(|target| there.contains(&target))
    };
    module.debug_names.retain(is_of_something);
    module.annotations.retain(is_of_something);
}

#[cfg(test)]
mod tests;

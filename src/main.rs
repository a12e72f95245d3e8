//! Arguments → one command.

use headwater::commands;
use headwater::out_of_memory::Allocator;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

fn main() -> ExitCode {
    commands::main()
}

//! The program `headwater`: runs the command that its arguments name, and returns the exit status.

use headwater::base::out_of_memory::Allocator;
use headwater::commands;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

fn main() -> ExitCode {
    commands::main()
}

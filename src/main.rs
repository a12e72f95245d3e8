//! Arguments → one command.

use headwater::base::out_of_memory::Allocator;
use headwater::commands;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

fn main() -> ExitCode {
    commands::main()
}

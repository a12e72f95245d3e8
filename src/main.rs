//! Arguments → one command.

use headwater::commands;
use std::process::ExitCode;

fn main() -> ExitCode {
    commands::main()
}

//! `completions` and `man`: print the completions of all commands for a shell, and write the manual pages of all
//! commands.

use super::{command_line, print_part};
use crate::base::files::write_atomically;
use crate::{Error, Result};
use clap_complete::Shell;
use std::path::PathBuf;

/// The command-line arguments of `headwater completions`, which select the shell.
#[derive(clap::Args)]
pub struct CompletionsArgs {
    /// The shell for which the completion script is printed
    shell: Shell,
}

/// Prints the script with which a shell completes commands, options and values.
///
/// # Errors
/// Stdout rejects the text.
pub fn completions(args: &CompletionsArgs) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command_line(), "headwater", &mut text);
    print_part(String::from_utf8_lossy(&text))
}

/// The command-line arguments of `headwater man`, which select the folder for the manual pages.
#[derive(clap::Args)]
pub struct ManArgs {
    /// The folder to which the manual pages are written; it must exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Writes the manual page `headwater.1`, and one for each command, such as `headwater-render.1`, to the folder of
/// `--output`.
///
/// # Errors
/// A file cannot be written.
pub fn man(args: &ManArgs) -> Result<()> {
    let mut line = command_line();
    // Gives all commands the global options and their whole names.
    line.build();
    let mut commands = vec![line];
    while let Some(command) = commands.pop() {
        let parts = command.get_subcommands();
        commands.extend(parts.filter(|part| part.get_name() != "help").cloned());
        let name = command
            .get_display_name()
            .unwrap_or(command.get_name())
            .to_owned();
        let mut text = Vec::new();
        (clap_mangen::Man::new(command).title(name.to_uppercase()))
            .source(concat!("headwater ", env!("CARGO_PKG_VERSION")))
            .render(&mut text)
            .map_err(|cause| Error::failed(format!("cannot write the page {name}: {cause}")))?;
        write_atomically(&args.output.join(format!("{name}.1")), |file| {
            std::io::Write::write_all(file, &text)
        })?;
    }
    Ok(())
}

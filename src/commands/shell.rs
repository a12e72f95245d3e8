//! `completions` and `man`: what shells and manuals know of the command line.

use super::{command_line, print_part};
use crate::base::files::write_atomically;
use crate::{Error, Result};
use clap_complete::Shell;
use std::path::PathBuf;

/// Arguments of `completions`.
#[derive(clap::Args)]
pub struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Prints what a shell needs to complete commands, options and values.
///
/// # Errors
/// Stdout takes nothing.
pub fn completions(args: &CompletionsArgs) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command_line(), "headwater", &mut text);
    print_part(String::from_utf8_lossy(&text))
}

/// Arguments of `man`.
#[derive(clap::Args)]
pub struct ManArgs {
    /// The folder, which exists
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Writes `headwater.1`, and a page for each command, such as `headwater-render.1`.
///
/// # Errors
/// A file that cannot be written.
pub fn man(args: &ManArgs) -> Result<()> {
    let mut pages = vec![("headwater".to_owned(), command_line())];
    while let Some((name, command)) = pages.pop() {
        let parts = command
            .get_subcommands()
            .filter(|part| part.get_name() != "help");
        pages.extend(parts.map(|part| (format!("{name}-{}", part.get_name()), part.clone())));
        let mut text = Vec::new();
        let page =
            clap_mangen::Man::new(command.display_name(&name).bin_name(name.replace('-', " ")));
        (page.title(name.to_uppercase()).render(&mut text))
            .map_err(|cause| Error::failed(format!("cannot write the page {name}: {cause}")))?;
        write_atomically(&args.output.join(format!("{name}.1")), |file| {
            std::io::Write::write_all(file, &text)
        })?;
    }
    Ok(())
}

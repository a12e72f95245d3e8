//! The command line of the program: one file per command, and the functions that the commands share, such as those that
//! print, load scenes and open Vulkan.

pub mod advise;
pub mod arguments;
pub mod capture;
mod choices;
pub mod compare;
pub mod ignored;
pub mod info;
pub mod interrupt;
mod measuring;
mod needs;
pub mod presets;
pub mod profile;
pub mod progress;
pub mod reference;
pub mod regress;
pub mod render;
mod repetition;
mod resources;
pub mod scene;
mod sequence;
pub mod session;
mod shell;
pub mod statistics;
pub mod study;

use crate::base::environment_variable::is_asked_for;
use crate::base::printable::{printable, printable_lines, shortened};
use crate::gpu::{Instance, InstanceOptions};
use crate::render::Clock;
use crate::scene::Scene;
use crate::scene_files::Options;
use crate::scene_files::Step;
use crate::{Error, Result};
use clap::error::{ContextKind, ContextValue, ErrorKind as ArgumentError};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use interrupt::Interrupt;
use progress::Progress;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;
use std::sync::Arc;

/// A headless Vulkan renderer that measures what its speed costs in accuracy.
#[derive(Parser)]
#[command(name = "headwater", version, about, max_term_width = 100)]
struct Cli {
    /// Print on stderr what the program chooses and why, such as the device and the tracer, what the scene requires, and the
    /// times of loading and of the passes
    #[arg(short, long, global = true)]
    verbose: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// List the devices, their features, and the tracer that each would use, with the reason.
    Info(info::Args),
    /// List or generate procedural scenes, or print the contents of a scene.
    #[command(subcommand)]
    Scene(scene::Command),
    /// Render frames of a scene; write the last frame, or the mean of all.
    Render(Box<render::Args>),
    /// Render a reference by path tracing with multiple importance sampling (MIS), with the standard error of each pixel.
    Reference(Box<reference::Args>),
    /// Compare a picture with a reference: print the errors, and check them against limits.
    Compare(compare::Args),
    /// Measure each pass of a frame: its time, the numbers of rays and other work, and its memory traffic.
    Profile(Box<profile::Args>),
    /// Print registers, memory and occupancy of each pass, as the driver's compiler reports them; no shader runs.
    Statistics(statistics::Args),
    /// Measure which preset to use for a scene on this device, what a frame costs, and how far off it is.
    Advise(Box<advise::Args>),
    /// Compare pictures and hashes of this driver with golden frames (stored results), or make golden frames.
    Regress(regress::Args),
    /// Print the presets, and every setting with its value, its range and its description.
    Presets(presets::Args),
    /// Render the configurations (named settings) of a plan on its scenes with several seeds, compare the frames with
    /// references, and test them for bias.
    Study(study::Args),
    /// Print the script with which a shell completes commands and options.
    Completions(shell::CompletionsArgs),
    /// Write the manual pages of all commands.
    Man(shell::ManArgs),
}

/// Runs the command that the process's arguments name, and returns the exit status. An error is printed as one line on
/// stderr.
pub fn main() -> ExitCode {
    let parsed = command_line()
        .try_get_matches()
        .and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return wrong_arguments(&error),
    };
    let level = if cli.verbose { "headwater=info" } else { "off" };
    env_logger::Builder::from_env(env_logger::Env::default().filter_or("HEADWATER_LOG", level))
        .format(|out, record| writeln!(out, "{}", line(record.args())))
        .init();
    match resources::prepare().and_then(|()| run(cli.command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&error);
            ExitCode::from(error.exit_status())
        }
    }
}

/// The definition of all commands and options. The parser, the shell completions and the manual pages are made from it.
fn command_line() -> clap::Command {
    Cli::command().mut_subcommand("reference", reference::shown)
}

fn run(command: Command) -> Result<()> {
    match command {
        Command::Info(args) => info::run(&args),
        Command::Advise(args) => advise::run(&args),
        Command::Scene(command) => scene::run(&command),
        Command::Render(args) => render::run(&args),
        Command::Reference(args) => reference::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Profile(args) => profile::run(&args),
        Command::Statistics(args) => statistics::run(&args),
        Command::Regress(args) => regress::run(&args),
        Command::Presets(args) => presets::run(&args),
        Command::Study(args) => study::run(&args),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::man(&args),
    }
}

/// Handles arguments from which the parser made no command, and returns the exit status. Help, the version and, if no
/// command is given, the list of commands are printed on stdout, with status 0. An error is printed as one line on
/// stderr, with status 2.
fn wrong_arguments(error: &clap::Error) -> ExitCode {
    // Without a command, the list of commands is what is wanted, not an error.
    let no_command = ArgumentError::DisplayHelpOnMissingArgumentOrSubcommand;
    if !error.use_stderr() || error.kind() == no_command {
        // A closed pipe is no failure of this program.
        let _ = write!(std::io::stdout().lock(), "{}", error.render());
        return ExitCode::SUCCESS;
    }
    let text = error.render().to_string();
    let lines: Vec<&str> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"))
        .filter(|line| !line.is_empty())
        .collect();
    let message = lines.join(" ");
    let message = message.trim_start_matches("error: ");
    let message = match other_name(error) {
        // It is better than the tip of the parser, which compares letters.
        Some(name) => format!(
            "{}; use {name}",
            message.split(" tip: ").next().unwrap_or(message)
        ),
        None => message.to_owned(),
    };
    say(format_args!("{message}; see 'headwater --help'"));
    ExitCode::from(2)
}

/// The text that a message suggests instead of an unknown option, such as `--spp` instead of `--samples` for the command
/// `reference`; `None` if there is no suggestion. Suggestions exist for options that have the same function in other
/// renderers or in other commands of this program.
fn other_name(error: &clap::Error) -> Option<&'static str> {
    if error.kind() != ArgumentError::UnknownArgument {
        return None;
    }
    let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let command = std::env::args().nth(1).unwrap_or_default();
    match (command.as_str(), unknown.as_str()) {
        ("render", "--spp" | "--samples") => Some("--frames, with --accumulate for their mean"),
        ("reference", "--frames" | "--samples") => Some("--spp"),
        ("render" | "reference" | "profile", "--size" | "--resolution") => {
            Some("--width and --height")
        }
        _ => None,
    }
}

/// Prints `text` and a line break on stdout. Control characters other than line breaks are escaped. A caller passes a
/// name from a file through `printable` first, so that the name stays on one line. Unlike `println!`, this function does
/// not panic if stdout fails.
///
/// # Errors
/// Stdout rejects the text, for example because the disk is full. A reader that has closed its pipe needs no more text,
/// which is not an error.
pub fn print(text: impl std::fmt::Display) -> Result<()> {
    print_part(format_args!("{text}\n"))
}

/// Prints `text` on stdout immediately, like [`print()`] but without a line break: the beginning of a line that is completed
/// later.
///
/// # Errors
/// The errors of [`print()`].
pub fn print_part(text: impl std::fmt::Display) -> Result<()> {
    let text = printable_lines(&text.to_string());
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Error::failed(format!("cannot write to stdout: {e}")))
        }
        _ => Ok(()),
    }
}

/// Generates the procedural scene with the name `name`, or loads the file at the path `name` and shows the progress on
/// stderr.
///
/// # Errors
/// The name is neither a procedural scene nor a readable file, or a signal was received.
pub fn open_scene(name: &str, options: Options, interrupt: &Interrupt) -> Result<Scene> {
    let mut shown: Option<(Step, Progress)> = None;
    Scene::open_watched(name, options, &mut |step, done, total| {
        if shown.as_ref().is_none_or(|(before, _)| *before != step) {
            let progress = match step {
                Step::Reading => Progress::new(Some(total >> 20), "MiB read"),
                Step::Decoding => Progress::new(Some(total), "meshes decoded"),
            };
            shown = Some((step, progress));
        }
        if let Some((_, progress)) = &shown {
            progress.at(match step {
                Step::Reading => (done >> 20) as f64,
                Step::Decoding => done as f64,
            });
        }
        interrupt.check(NOTHING_WRITTEN)
    })
}

/// The clause about saved results in [`Error::Interrupted`], for work that has not saved any result yet; the message
/// after a signal ends with it.
pub const NOTHING_WRITTEN: &str = "nothing was written";

/// Loads Vulkan and makes an instance with `options`. If the environment variable `HEADWATER_VALIDATION` is set, and not
/// to `0`, the instance also has the validation layers.
///
/// # Errors
/// Vulkan is not installed or makes no instance, or validation layers are requested and not installed.
pub fn open_vulkan(options: InstanceOptions) -> Result<Arc<Instance>> {
    let asked_for = is_asked_for("HEADWATER_VALIDATION");
    Instance::new(InstanceOptions {
        validation: options.validation || asked_for,
        ..options
    })
}

/// Checks that `messages`, the messages of the Vulkan validation layers, is empty. A message means that the program
/// uses Vulkan wrongly, so the command fails.
///
/// # Errors
/// There are messages; the error contains their number and the first one.
pub fn check_messages(messages: &[String]) -> Result<()> {
    match messages.first() {
        None => Ok(()),
        Some(first) => Err(Error::failed(format!(
            "the validation layers sent {} messages, the first: {first}; HEADWATER_LOG=debug shows all",
            messages.len()
        ))),
    }
}

/// Adapts `scene` to the clock. If the clock is stopped, all frames show its start time; a moving scene is then replaced by
/// its state at this time, which costs less to render. If nothing in the scene moves, but the clock runs or does not start
/// at 0, prints a notice. The notice begins with `whose`: empty, or the name of the scene, a colon and a space.
///
/// # Errors
/// The errors of [`Clock::freeze_if_stopped`].
pub fn apply_clock(clock: &Clock, scene: &mut Scene, whose: &str) -> Result<()> {
    if scene.motion.is_none() && (clock.fps.is_some() || clock.start_time != 0.0) {
        notice(&format!(
            "{whose}nothing in the scene moves, so it is the same at all times"
        ));
    }
    clock.freeze_if_stopped(scene)
}

/// Prints one line on stderr, beginning with `headwater: note:`, about an assumption or an omission of the program.
pub fn notice(text: &str) {
    say(format_args!("note: {text}"));
}

/// The maximum number of characters of a message on stderr, because a value from a file, which the message quotes, can
/// have any length. An ellipsis replaces the middle of a longer message.
const MESSAGE_CHARACTERS: usize = 500;

/// Makes a message of one line from `text`: the program's name, a colon and the text, with control characters escaped,
/// cut to at most [`MESSAGE_CHARACTERS`] characters.
fn line(text: impl std::fmt::Display) -> String {
    shortened(
        &printable(&format!("headwater: {text}")),
        MESSAGE_CHARACTERS,
    )
}

/// Prints `text` as one line on stderr, after the program's name. If stderr cannot be written, the line is lost and the
/// work continues, where `eprintln!` would panic.
fn say(text: impl std::fmt::Display) {
    let line = line(text);
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

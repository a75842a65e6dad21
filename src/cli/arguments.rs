//! What the command line takes.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::time::Duration;

/// Site response from an accelerogram, with its error, its cost and its energy balance.
#[derive(Debug, Parser)]
#[command(
    name = "hati",
    version,
    after_help = "Exit codes: 0 fine, 1 outside the accuracy asked or a failed verify, 2 wrong input, 3 unstable, 4 machine (disk, memory), 5 interrupted."
)]
pub(super) struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub(super) verb: Verb,
    /// Print one JSON value on stdout, everything else on stderr.
    #[arg(long, global = true)]
    pub(super) json: bool,
}

#[derive(Debug, Subcommand)]
pub(super) enum Verb {
    /// Find all mistakes of a scene at once.
    Check(SceneArguments),
    /// Show sizes, step, who limits it, predicted error, memory, disk and time, with reasons; run nothing.
    Plan(SceneArguments),
    /// Plan and run a scene into a folder.
    Run(RunArguments),
    /// Look at motions: what was found in the files, and their measures.
    Record(RecordArguments),
    /// Print the JSON Schema of scene files.
    Schema {
        /// Print the reference page of the book instead.
        #[arg(long)]
        markdown: bool,
    },
    /// Error against cost of a scene over order, size and step, with the point that auto chose.
    Chart(RunArguments),
    /// Run the built-in cases against closed forms and references.
    Verify(VerifyArguments),
}

#[derive(Debug, Args)]
pub(super) struct SceneArguments {
    /// A scene file, or a folder that holds scene.toml.
    pub(super) scene: PathBuf,
    /// Override a value, for instance --set accuracy=1e-3 or --set soil.layer[2].vs=300; repeatable.
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<String>,
}

#[derive(Debug, Args)]
pub(super) struct RunArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// Folder for the results [default: runs/NAME].
    #[arg(long, short)]
    pub(super) out: Option<PathBuf>,
    /// Stop as if interrupted after this wall time: seconds, or with s, min or h.
    #[arg(long, value_parser = wall_time)]
    pub(super) max_wall_time: Option<Duration>,
}

#[derive(Debug, Args)]
pub(super) struct RecordArguments {
    /// Record files.
    #[arg(required = true)]
    pub(super) files: Vec<PathBuf>,
    /// Unit of one sample value, in place of what the file says: m/s2, cm/s2, gal, g, g/10, mm/s2, nm/s2, m/s, …
    #[arg(long)]
    pub(super) unit: Option<String>,
    /// Leave the offset in.
    #[arg(long)]
    pub(super) keep_offset: bool,
}

#[derive(Debug, Args)]
pub(super) struct VerifyArguments {
    /// Cases to run, by part of their name [default: all].
    pub(super) cases: Vec<String>,
    /// Also run the long studies.
    #[arg(long)]
    pub(super) long: bool,
    /// Change one constant of each case by three times its limit and see it fail.
    #[arg(long)]
    pub(super) self_check: bool,
}

fn wall_time(text: &str) -> Result<Duration, String> {
    let (number, factor) = match text {
        t if t.ends_with("min") => (&t[..t.len() - 3], 60.0),
        t if t.ends_with('h') => (&t[..t.len() - 1], 3600.0),
        t if t.ends_with('s') => (&t[..t.len() - 1], 1.0),
        t => (t, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(x) if x > 0.0 && x * factor < 1e9 => Ok(Duration::from_secs_f64(x * factor)),
        _ => Err(format!("`{text}` is no time: give seconds, or a number with s, min or h")),
    }
}

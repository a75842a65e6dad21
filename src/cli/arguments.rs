//! What the command line takes.

use crate::record::Formats;
use clap::{Args, Parser, Subcommand, ValueEnum};
use hati_inputs::records::ResponseMode;
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
    /// Look at records: what was found in the files, their measures, a page, and the processed motion as files.
    Record(RecordArguments),
    /// Turn a run folder into CSV, miniSEED, SAC or VTKHDF.
    Export(ExportArguments),
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
    /// Let a .geo file of the scene run: it is a program, which Gmsh meshes by.
    #[arg(long)]
    pub(super) allow_scripts: bool,
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
    /// Threads of a run in two or three dimensions, 1 to 1024 [default: all of the machine].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Go on from the checkpoint of the folder, bit for bit as if nothing had happened; without one start anew.
    #[arg(long)]
    pub(super) restart: bool,
}

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("format").required(true).multiple(true))]
pub(super) struct ExportArguments {
    /// The folder that `hati run` wrote.
    pub(super) run: PathBuf,
    /// Stations as text: PLACE.csv, SI units, every digit.
    #[arg(long, group = "format")]
    pub(super) csv: bool,
    /// Stations as miniSEED: PLACE.acceleration.mseed, ..., SI units.
    #[arg(long, group = "format")]
    pub(super) mseed: bool,
    /// Stations as SAC: PLACE.acceleration.x.sac, ..., in nm/s², nm/s and nm.
    #[arg(long, group = "format")]
    pub(super) sac: bool,
    /// Fields in 2D and 3D as VTKHDF for ParaView: surface.vtkhdf, volume.vtkhdf, field.vtkhdf.
    #[arg(long, group = "format")]
    pub(super) vtkhdf: bool,
    /// Only this station.
    #[arg(long, value_name = "PLACE")]
    pub(super) place: Option<String>,
    /// Folder for the files [default: RUN/export].
    #[arg(long, short, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

/// What `record --help` ends with.
const RECORD_HELP: &str = "\
Steps of --process, each with an example; a number's unit is that of a scene's motion.process:
  demean     demean first_seconds=5
  detrend    detrend order=1
  baseline   baseline order=2
  taper      taper start=1 end=2
  filter     filter f_min=0.1 f_max=25
  rotate     rotate angle=30
  trim       trim from=5 to=40
  pad        pad before=10 after=20
  resample   resample dt=0.005
  scale      scale pga=2.5
  match      match spectrum.kind=rg160 spectrum.pga=2
  rest       rest
  convert    convert to=velocity

Example:
  hati record E.mseed N.mseed Z.mseed --unit gal --process demean --process 'filter f_min=0.1 f_max=25' --out look";

#[derive(Debug, Args)]
#[command(after_help = RECORD_HELP)]
pub(super) struct RecordArguments {
    /// Record files.
    #[arg(required_unless_present = "from")]
    pub(super) files: Vec<PathBuf>,
    /// Unit of one sample value, in place of what the files say: m/s2, cm/s2, gal, g, g/10, mm/s2, nm/s2, m/s, cm/s, mm/s, nm/s, m, cm, mm, nm.
    #[arg(long, conflicts_with = "metadata")]
    pub(super) unit: Option<String>,
    /// Time step in s, 1e-6 to 100, for files that state none.
    #[arg(long, value_name = "S", value_parser = time_step, allow_negative_numbers = true)]
    pub(super) dt: Option<f64>,
    /// Read only this channel: its full id, or the last part of it.
    #[arg(long, value_name = "ID")]
    pub(super) channel: Option<String>,
    /// Take the instrument's response off by this StationXML, RESP or SAC poles-and-zeros file.
    #[arg(long, value_name = "FILE")]
    pub(super) metadata: Option<PathBuf>,
    /// How the response is taken off.
    #[arg(long, value_name = "HOW", requires = "metadata", default_value = "full")]
    pub(super) response: ResponseArgument,
    /// Four rising corners in Hz within which the full response is taken off, for instance 0.02,0.05,40,48.
    #[arg(long, value_name = "F1,F2,F3,F4", requires = "metadata", value_parser = corners)]
    pub(super) pre_filter: Option<[f64; 4]>,
    /// Let a channel pass that looks clipped, where the plateau is meant.
    #[arg(long)]
    pub(super) accept_clipped: bool,
    /// A step of processing, for instance 'filter f_min=0.1 f_max=25'; repeatable, done in order; `none` for no step at all [default: demean].
    #[arg(long, value_name = "STEP")]
    pub(super) process: Vec<String>,
    /// Folder for the page and the motion.
    #[arg(long, short, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Files of the motion, with commas between them: csv, mseed, sac.
    #[arg(long, value_name = "FORMATS", requires = "out", default_value = "csv")]
    pub(super) write: Formats,
    /// Make a motion again from its own account: a motion.csv or record.json of an earlier --out.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["files", "unit", "dt", "channel", "metadata", "process"])]
    pub(super) from: Option<PathBuf>,
}

/// The words of `--response`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ResponseArgument {
    /// Divide the spectrum by the full response; refused where sensitivity and stages disagree.
    Full,
    /// Divide the samples by the stated sensitivity.
    Sensitivity,
    /// As full, by the stages, whatever the stated sensitivity says.
    Stages,
}

impl From<ResponseArgument> for ResponseMode {
    fn from(argument: ResponseArgument) -> Self {
        match argument {
            ResponseArgument::Full => Self::Full,
            ResponseArgument::Sensitivity => Self::Sensitivity,
            ResponseArgument::Stages => Self::Stages,
        }
    }
}

/// Time steps from 1 MHz to one sample in 100 s; what lies outside is a slip of the pen.
fn time_step(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(dt) if (1e-6..=100.0).contains(&dt) => Ok(dt),
        _ => Err("give the time step in seconds, 1e-6 to 100".to_owned()),
    }
}

fn corners(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    match numbers.map(<[f64; 4]>::try_from) {
        Ok(Ok(corners)) if corners.windows(2).all(|pair| pair[0] < pair[1]) => Ok(corners),
        _ => Err(format!("`{text}`: give four rising frequencies in Hz with commas between them")),
    }
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
    /// Folder for the figures of the cases that have one, SVG with CSV beside it.
    #[arg(long, short, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
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

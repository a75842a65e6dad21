//! The files that grow during a run, and what feeds them.

use super::plan::VolumePlan;
use super::sampling::Rows;
use super::stations::Stations;
use crate::outputs::decimate::Decimator;
use crate::outputs::thread::Background;
use crate::outputs::wave::{Peaks, WaveLayout, WaveLedgerWriter, WaveWriter};
use crate::outputs::{OutputError, Provenance};
use hati_sem::solid::{Real, Solid, Watch};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Rows of every file at a checkpoint.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct RowCounts {
    pub(super) stations: usize,
    pub(super) ledger: usize,
    /// Surface, volume, grid: those that the scene has, in this order.
    pub(super) fields: Vec<usize>,
}

/// How rows are made.
enum Maker {
    Picked(usize),
    Filtered(Box<Decimator>),
    /// All rows are written.
    Ended,
}

/// Weights that take the values of watched points to those of a grid.
struct Interpolation {
    /// First entry of each point of the grid.
    starts: Vec<u32>,
    entries: Vec<(u32, f32)>,
}

/// One field: its points, its rows, its place among the sinks.
struct Stream {
    watch: Watch,
    interpolation: Option<Interpolation>,
    motions: Vec<usize>,
    points: usize,
    maker: Maker,
    /// `None` where the file is finished already.
    sink: Option<usize>,
    sent: usize,
    /// Largest motions, of the surface.
    peaks: Option<Peaks>,
}

/// All files of a run that grow.
pub(super) struct Streams {
    axes: Vec<usize>,
    stations: Option<Stations>,
    ledger: Option<WaveLedgerWriter>,
    fields: Vec<Stream>,
    background: Option<Background<WaveWriter>>,
    buffer: Vec<f32>,
    /// Samples that were not finite, if one was met.
    pub(super) broken: bool,
}

/// Components that can move: y does in a section only where a source pushes along it.
pub(super) fn axes(plan: &VolumePlan) -> Vec<usize> {
    if plan.moves_y { vec![0, 1, 2] } else { vec![0, 2] }
}

/// Whether a file is one that a finished run left.
fn is_finished(path: &Path) -> bool {
    use std::io::Read as _;
    let mut head = [0; 4];
    std::fs::File::open(path).and_then(|mut f| f.read_exact(&mut head)).is_ok() && head == *b"\x89HDF"
}

/// Opens a file new, at its rows, or, where the loop had ended, not at all if it is finished.
pub(super) fn open<W>(
    path: &Path,
    resume: Option<usize>,
    complete: bool,
    make: impl FnOnce(Option<usize>) -> Result<W, OutputError>,
) -> Result<Option<W>, OutputError> {
    if complete && is_finished(path) { Ok(None) } else { make(resume).map(Some) }
}

impl Streams {
    /// Creates all files, or goes on with those of a checkpoint; `complete` where it was written at the loop's end.
    pub(super) fn open<T: Real>(
        plan: &VolumePlan,
        solid: &Solid<T>,
        folder: &Path,
        provenance: &Provenance,
        resume: Option<&RowCounts>,
        complete: bool,
    ) -> Result<Self, OutputError> {
        let axes = axes(plan);
        let stations = match plan.sensors.is_empty() {
            true => None,
            false => Some(Stations::open(
                plan,
                solid,
                folder,
                provenance,
                &axes,
                resume.map(|r| r.stations),
                complete,
            )?),
        };
        let path = folder.join("ledger.nc");
        let ledger = open(&path, resume.map(|r| r.ledger), complete, |rows| {
            WaveLedgerWriter::create(&path, provenance, plan.dimension, rows)
        })?;
        let mut streams =
            Self { axes, stations, ledger, fields: vec![], background: None, buffer: vec![], broken: false };
        streams.open_fields(plan, solid, folder, provenance, resume, complete)?;
        Ok(streams)
    }

    fn open_fields<T: Real>(
        &mut self,
        plan: &VolumePlan,
        solid: &Solid<T>,
        folder: &Path,
        provenance: &Provenance,
        resume: Option<&RowCounts>,
        complete: bool,
    ) -> Result<(), OutputError> {
        let mut sinks = vec![];
        let axes = self.axes.clone();
        let layout = |motions: &[usize]| WaveLayout {
            displacement: motions.contains(&0),
            velocity: motions.contains(&1),
            acceleration: motions.contains(&2),
            axes: axes.clone(),
        };
        let rows_of = |number: usize| resume.map(|r| r.fields.get(number).copied().unwrap_or(0));
        let mut add = |fields: &mut Vec<Stream>, mut stream: Stream, writer: Option<WaveWriter>| {
            stream.sink = writer.map(|w| {
                sinks.push(w);
                sinks.len() - 1
            });
            stream.sent = rows_of(fields.len()).unwrap_or(0);
            fields.push(stream);
        };
        if let Some(s) = &plan.surface {
            let path = folder.join("surface.nc");
            let writer = open(&path, rows_of(self.fields.len()), complete, |rows| {
                WaveWriter::surface(&path, provenance, &layout(&s.motions), &s.cells, rows)
            })?;
            let mut stream = Stream::new(plan, solid, &s.points, &s.motions, &s.rows, axes.len())?;
            stream.peaks = Some(Peaks::new(&axes, s.points.len()));
            add(&mut self.fields, stream, writer);
        }
        if let Some(v) = &plan.volume {
            let path = folder.join("volume.nc");
            let writer = open(&path, rows_of(self.fields.len()), complete, |rows| {
                WaveWriter::volume(&path, provenance, &layout(&v.motions), &v.cells, rows)
            })?;
            let stream = Stream::new(plan, solid, &v.points, &v.motions, &v.rows, axes.len())?;
            add(&mut self.fields, stream, writer);
        }
        if let Some(f) = &plan.field {
            let path = folder.join("field.nc");
            let writer = open(&path, rows_of(self.fields.len()), complete, |rows| {
                WaveWriter::grid(&path, provenance, &layout(&f.motions), &f.grid, rows)
            })?;
            let (points, interpolation) = Interpolation::new(&f.probes);
            let mut stream = Stream::new(plan, solid, &points, &f.motions, &f.rows, axes.len())?;
            stream.resize(f.probes.len(), interpolation, plan, &f.rows, axes.len())?;
            add(&mut self.fields, stream, writer);
        }
        let largest = self.fields.iter().map(|f| f.points).max().unwrap_or(0);
        self.buffer = vec![0.0; largest * axes.len()];
        if !sinks.is_empty() {
            self.background = Some(Background::start(sinks, 4)?);
        }
        Ok(())
    }

    /// Takes the state before the step of a sample.
    pub(super) fn before<T: Real>(&mut self, solid: &Solid<T>, sample: usize) {
        self.stations.iter_mut().for_each(|s| s.before(solid));
        self.fields.iter_mut().filter(|f| f.wants(sample)).for_each(|f| f.watch.before(solid));
    }

    /// Takes the state after it and writes what is due; `time` is that of the sample, s.
    pub(super) fn after<T: Real>(
        &mut self,
        plan: &VolumePlan,
        solid: &Solid<T>,
        sample: usize,
        time: f64,
    ) -> Result<(), OutputError> {
        if let Some(stations) = &mut self.stations {
            self.broken |= !stations.after(plan, solid, &self.axes, time)?;
        }
        let Self { fields, background, axes, buffer, .. } = self;
        for field in fields.iter_mut().filter(|f| f.wants(sample)) {
            field.watch.after(solid);
            field.take_peaks(axes, buffer);
            field.write(axes, background.as_mut(), sample, time)?;
        }
        Ok(())
    }

    /// Takes a row of the ledger.
    pub(super) fn book(&mut self, row: &crate::results::LedgerRow) -> Result<(), OutputError> {
        self.ledger.as_mut().map_or(Ok(()), |l| l.append(row))
    }

    /// Brings everything to the disk; the rows that are then there.
    pub(super) fn sync(&mut self) -> Result<RowCounts, OutputError> {
        let mut counts = RowCounts::default();
        if let Some(stations) = &mut self.stations {
            counts.stations = stations.sync()?;
        }
        if let Some(ledger) = &mut self.ledger {
            ledger.sync()?;
            counts.ledger = ledger.rows();
        }
        if let Some(background) = &mut self.background {
            background.flush()?;
        }
        counts.fields = self.fields.iter().map(|f| f.sent).collect();
        Ok(counts)
    }

    /// The state of filters and peaks.
    pub(super) fn save(&self, to: &mut Vec<u8>) {
        let mut part = vec![];
        for field in &self.fields {
            part.clear();
            if let Maker::Filtered(d) = &field.maker {
                d.save(&mut part);
            }
            to.extend((part.len() as u64).to_le_bytes());
            to.extend(&part);
            part.clear();
            field.peaks.iter().for_each(|p| p.save(&mut part));
            to.extend((part.len() as u64).to_le_bytes());
            to.extend(&part);
        }
    }

    /// Takes the state of [`Self::save`] back; `None` where it does not fit.
    pub(super) fn restore(&mut self, mut from: &[u8]) -> Option<()> {
        let mut next = || -> Option<&[u8]> {
            let (length, rest) = from.split_at_checked(8)?;
            let length = u64::from_le_bytes(length.try_into().ok()?) as usize;
            let (part, rest) = rest.split_at_checked(length)?;
            from = rest;
            Some(part)
        };
        for field in &mut self.fields {
            let filter = next()?;
            if let Maker::Filtered(d) = &mut field.maker {
                d.restore(filter).ok()?;
            }
            let peaks = next()?;
            if let Some(p) = &mut field.peaks {
                p.restore(peaks).ok()?;
            }
        }
        Some(())
    }

    /// Ends a run that is complete: the last rows of filters, peaks, closing error, compression.
    pub(super) fn finish(mut self, closing_error: f64) -> Result<(), OutputError> {
        for field in &mut self.fields {
            let maker = std::mem::replace(&mut field.maker, Maker::Ended);
            if let (Maker::Filtered(d), Some(sink), Some(to)) = (maker, field.sink, self.background.as_mut())
            {
                d.finish(|row| {
                    let mut frame = to.frame(sink)?;
                    frame.time = row.time;
                    frame.values.copy_from_slice(row.values);
                    to.send(frame)
                })?;
            }
        }
        self.close(closing_error, true)
    }

    /// Ends a run that will be gone on with.
    pub(super) fn leave(self, closing_error: f64) -> Result<(), OutputError> {
        self.close(closing_error, false)
    }

    fn close(self, closing_error: f64, complete: bool) -> Result<(), OutputError> {
        if let Some(mut writer) = self.stations.and_then(|s| s.writer) {
            if complete { writer.finish()? } else { writer.sync()? }
        }
        if let Some(mut ledger) = self.ledger {
            ledger.write_closing_error(closing_error)?;
            if complete { ledger.finish()? } else { ledger.sync()? }
        }
        let sinks = self.background.map_or(Ok(vec![]), Background::finish)?;
        for (number, mut sink) in sinks.into_iter().enumerate() {
            let own = self.fields.iter().find(|f| f.sink == Some(number));
            if let Some(peaks) = own.and_then(|f| f.peaks.as_ref()) {
                sink.write_peaks(peaks)?;
            }
            if complete { sink.finish()? } else { sink.leave()? }
        }
        Ok(())
    }

    /// Time for which the loop waited for the disk, s.
    pub(super) fn waited(&self) -> f64 {
        self.background.as_ref().map_or(0.0, |b| b.waited().as_secs_f64())
    }
}

impl Stream {
    fn new<T: Real>(
        plan: &VolumePlan,
        solid: &Solid<T>,
        points: &[u32],
        motions: &[usize],
        rows: &Rows,
        axes: usize,
    ) -> Result<Self, OutputError> {
        Ok(Self {
            watch: Watch::new(solid, points),
            interpolation: None,
            motions: motions.to_vec(),
            points: points.len(),
            maker: maker(plan, rows, motions.len() * axes * points.len())?,
            sink: None,
            sent: 0,
            peaks: None,
        })
    }

    /// Gives it the points of a grid.
    fn resize(
        &mut self,
        points: usize,
        interpolation: Interpolation,
        plan: &VolumePlan,
        rows: &Rows,
        axes: usize,
    ) -> Result<(), OutputError> {
        self.points = points;
        self.interpolation = Some(interpolation);
        self.maker = maker(plan, rows, self.motions.len() * axes * points)?;
        Ok(())
    }

    /// Whether it looks at a sample.
    fn wants(&self, sample: usize) -> bool {
        let written = !self.motions.is_empty();
        self.peaks.is_some()
            || match self.maker {
                Maker::Picked(every) => written && sample.is_multiple_of(every),
                Maker::Filtered(_) => written,
                Maker::Ended => false,
            }
    }

    fn take_peaks(&mut self, axes: &[usize], buffer: &mut [f32]) {
        let Some(peaks) = &mut self.peaks else { return };
        let values = &mut buffer[..self.points * axes.len()];
        for motion in 0..3 {
            fill(&self.watch, None, motion, axes, values);
            peaks.take(motion, values);
        }
    }

    fn write(
        &mut self,
        axes: &[usize],
        to: Option<&mut Background<WaveWriter>>,
        sample: usize,
        time: f64,
    ) -> Result<(), OutputError> {
        let (Some(to), Some(sink), false) = (to, self.sink, self.motions.is_empty()) else { return Ok(()) };
        let (watch, interpolation, motions) = (&self.watch, self.interpolation.as_ref(), &self.motions);
        let block = axes.len() * self.points;
        let fill_all = |values: &mut [f32]| {
            for (number, &motion) in motions.iter().enumerate() {
                fill(watch, interpolation, motion, axes, &mut values[number * block..(number + 1) * block]);
            }
        };
        let sent = &mut self.sent;
        match &mut self.maker {
            Maker::Picked(every) if sample.is_multiple_of(*every) => {
                let mut frame = to.frame(sink)?;
                frame.time = time;
                fill_all(&mut frame.values);
                *sent += 1;
                to.send(frame)
            }
            Maker::Filtered(d) => d.take(fill_all, |row| {
                let mut frame = to.frame(sink)?;
                frame.time = row.time;
                frame.values.copy_from_slice(row.values);
                *sent += 1;
                to.send(frame)
            }),
            _ => Ok(()),
        }
    }
}

fn maker(plan: &VolumePlan, rows: &Rows, values: usize) -> Result<Maker, OutputError> {
    Ok(match *rows {
        Rows::Filtered { dt } if values > 0 => {
            Maker::Filtered(Box::new(Decimator::new(values, plan.sampling.sample_dt(), 0.0, dt)?))
        }
        Rows::Picked { every } => Maker::Picked(every),
        Rows::Filtered { .. } => Maker::Ended,
    })
}

/// Values `[component][point]` of a motion, of the watched points or interpolated from them.
fn fill(watch: &Watch, interpolation: Option<&Interpolation>, motion: usize, axes: &[usize], to: &mut [f32]) {
    let from = match motion {
        0 => watch.displacement(),
        1 => watch.velocity(),
        _ => watch.acceleration(),
    };
    let points = to.len() / axes.len();
    for (to, &axis) in to.chunks_exact_mut(points.max(1)).zip(axes) {
        match interpolation {
            None => to.iter_mut().zip(from).for_each(|(to, x)| *to = x[axis] as f32),
            Some(i) => i.apply(from, axis, to),
        }
    }
}

impl Interpolation {
    /// The points that probes need, each once, and the weights; a point outside the ground has none.
    fn new(probes: &[Option<hati_sem::solid::Probe>]) -> (Vec<u32>, Self) {
        let mut points: Vec<u32> =
            probes.iter().flatten().flat_map(|p| p.weights.iter().map(|(p, _)| *p)).collect();
        points.sort_unstable();
        points.dedup();
        let mut made = Self { starts: vec![0], entries: vec![] };
        for probe in probes {
            for (point, weight) in probe.iter().flat_map(|p| &p.weights) {
                let place = points.binary_search(point).unwrap_or(0);
                made.entries.push((place as u32, *weight as f32));
            }
            made.starts.push(made.entries.len() as u32);
        }
        (points, made)
    }

    fn apply(&self, from: &[[f64; 3]], axis: usize, to: &mut [f32]) {
        for (to, ends) in to.iter_mut().zip(self.starts.windows(2)) {
            let entries = &self.entries[ends[0] as usize..ends[1] as usize];
            *to = match entries.is_empty() {
                true => f32::NAN,
                false => entries.iter().map(|&(p, w)| w * from[p as usize][axis] as f32).sum(),
            };
        }
    }
}

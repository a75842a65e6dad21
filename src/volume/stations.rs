//! The stations' file of a run.

use super::files::open;
use super::plan::{PlannedSensor, VolumePlan};
use crate::outputs::wave::{Sensor, SensorLayout, SensorWriter};
use crate::outputs::{OutputError, Provenance};
use hati_inputs::scene::OutputQuantity;
use hati_sem::solid::{Gauge, Motion, Real, Solid, Tensors, Watch};
use std::path::Path;

/// `stations.nc` and what it looks at.
pub(super) struct Stations {
    /// `None` where the file is finished already.
    pub(super) writer: Option<SensorWriter>,
    watch: Watch,
    /// First watched point of each station.
    firsts: Vec<usize>,
    gauges: Vec<Option<Gauge>>,
    tensors: Vec<Tensors>,
    layout: SensorLayout,
    row: Vec<f64>,
    rows: usize,
}

/// The motions in the order of the rows.
pub(super) const MOTIONS: [OutputQuantity; 3] =
    [OutputQuantity::Displacement, OutputQuantity::Velocity, OutputQuantity::Acceleration];

impl Stations {
    /// Creates the file, or goes on with that of a checkpoint.
    pub(super) fn open<T: Real>(
        plan: &VolumePlan,
        solid: &Solid<T>,
        folder: &Path,
        provenance: &Provenance,
        axes: &[usize],
        rows: Option<usize>,
        complete: bool,
    ) -> Result<Self, OutputError> {
        let asked = |q| plan.sensors.iter().any(|s| s.quantities.contains(&q));
        let (strain, stress) = (asked(OutputQuantity::Strain), asked(OutputQuantity::Stress));
        let layout = SensorLayout { axes: axes.to_vec(), strain, stress };
        let sensor =
            |s: &PlannedSensor| Sensor { name: s.name.clone(), asked: s.asked, position: s.probe.position };
        let sensors: Vec<Sensor> = plan.sensors.iter().map(sensor).collect();
        let path = folder.join("stations.nc");
        let writer = open(&path, rows, complete, |rows| {
            SensorWriter::create(&path, provenance, &layout, &sensors, rows)
        })?;
        let mut points = vec![];
        let mut firsts = vec![];
        for s in &plan.sensors {
            firsts.push(points.len());
            points.extend(s.probe.weights.iter().map(|(p, _)| *p));
        }
        let gauge = |s: &PlannedSensor| {
            let wants = s.quantities.iter().any(|q| *q >= OutputQuantity::Strain);
            wants.then(|| Gauge::new(solid, &plan.ground, &s.probe))
        };
        Ok(Self {
            writer,
            watch: Watch::new(solid, &points),
            firsts,
            gauges: plan.sensors.iter().map(gauge).collect(),
            tensors: vec![Tensors::default(); sensors.len()],
            row: vec![f64::NAN; layout.variables() * sensors.len()],
            layout,
            rows: rows.unwrap_or(0),
        })
    }

    /// Takes the state before the step of a sample.
    pub(super) fn before<T: Real>(&mut self, solid: &Solid<T>) {
        self.watch.before(solid);
        for (gauge, to) in self.gauges.iter().zip(&mut self.tensors) {
            gauge.iter().for_each(|g| *to = g.look(solid));
        }
    }

    /// Takes the state after it and writes the row of the sample; false where it is not finite.
    pub(super) fn after<T: Real>(
        &mut self,
        plan: &VolumePlan,
        solid: &Solid<T>,
        axes: &[usize],
        time: f64,
    ) -> Result<bool, OutputError> {
        self.watch.after(solid);
        self.write(plan, axes, time)
    }

    /// Brings all rows to the disk; how many they are.
    pub(super) fn sync(&mut self) -> Result<usize, OutputError> {
        self.writer.as_mut().map_or(Ok(()), SensorWriter::sync)?;
        Ok(self.rows)
    }

    /// Writes the row of a sample; false where it is not finite.
    fn write(&mut self, plan: &VolumePlan, axes: &[usize], time: f64) -> Result<bool, OutputError> {
        let count = plan.sensors.len();
        let mut finite = true;
        for (number, sensor) in plan.sensors.iter().enumerate() {
            let Motion { displacement, velocity, acceleration } =
                self.watch.at(&sensor.probe, self.firsts[number]);
            let all = [displacement, velocity, acceleration];
            for (motion, values) in all.iter().enumerate() {
                let asked = sensor.quantities.contains(&MOTIONS[motion]);
                for (slot, &axis) in axes.iter().enumerate() {
                    finite &= values[axis].is_finite();
                    self.row[(motion * axes.len() + slot) * count + number] =
                        if asked { values[axis] } else { f64::NAN };
                }
            }
            let mut variable = 3 * axes.len();
            let kinds = [
                (self.layout.strain, OutputQuantity::Strain, &self.tensors[number].strain),
                (self.layout.stress, OutputQuantity::Stress, &self.tensors[number].stress),
            ];
            for (_, quantity, tensor) in kinds.into_iter().filter(|k| k.0) {
                for component in tensor {
                    let asked = sensor.quantities.contains(&quantity);
                    self.row[variable * count + number] = if asked { *component } else { f64::NAN };
                    variable += 1;
                }
            }
        }
        if let Some(writer) = &mut self.writer {
            writer.append(time, &self.row)?;
        }
        self.rows += 1;
        Ok(finite)
    }
}

//! What is kept of a run: motions at stations, the field, peaks, the ledger. Allocates once.

use crate::plan::Plan;
use crate::results::{LedgerRow, PeakProfile, Section, Trace};
use hati_coupling::{Energies, Ledger, Subdomain};
use hati_sem::SemError;
use hati_sem::column::{Column, Probe};

/// Rows between two appends to the files.
pub const CHUNK: usize = 1024;

/// Most rows of a section: the picture needs no more, and a long run would fill the memory.
const SECTION_ROWS: usize = 8000;

/// Rows of the field that wait to be written, per component.
#[derive(Debug, Clone, Default)]
pub struct FieldRows {
    /// m
    pub displacement: Vec<f32>,
    /// m/s
    pub velocity: Vec<f32>,
    /// m/s²
    pub acceleration: Vec<f32>,
}

/// Collects samples of a column at the record's step.
pub struct Recorder {
    /// Elapsed time of each sample taken, s.
    pub time: Vec<f64>,
    /// Stations, one trace per place and component, in the order place, component.
    pub traces: Vec<Trace>,
    /// Field rows not yet written, one per component.
    pub field: Vec<FieldRows>,
    /// Sections, one per component.
    pub sections: Vec<Section>,
    /// Peaks, one per component.
    pub peaks: Vec<PeakProfile>,
    /// Outcrop velocity that goes with an imposed base, one per component; empty where not needed.
    pub outcrop_velocity: Vec<Vec<f64>>,
    /// Ledger rows.
    pub ledger_rows: Vec<LedgerRow>,
    /// The balance.
    pub ledger: Ledger,
    probes: Vec<Probe>,
    field_probes: Vec<Probe>,
    impedance: Vec<Option<f64>>,
    order: usize,
    section_stride: usize,
    kinetic_floor: f64,
    input_max: f64,
}

impl Recorder {
    /// Sets up everything for `plan.samples` samples.
    ///
    /// `velocity_scale`: largest velocity of the input, m/s, for the watchdog.
    pub fn new(plan: &Plan, column: &mut Column, velocity_scale: f64) -> Result<Self, SemError> {
        let samples = plan.samples;
        let room = || Vec::with_capacity(samples);
        let probes =
            plan.places.iter().map(|p| column.mesh().probe(p.depth)).collect::<Result<Vec<_>, _>>()?;
        let field_probes =
            plan.field_depths.iter().map(|&d| column.mesh().probe(d)).collect::<Result<Vec<_>, _>>()?;
        let mut traces = vec![];
        for place in &plan.places {
            for &axis in &plan.axes {
                traces.push(Trace {
                    place: place.name.clone(),
                    depth: Some(place.depth),
                    axis,
                    acceleration: room(),
                    velocity: room(),
                    displacement: room(),
                });
            }
        }
        let depth = column.element_point_depths();
        let zeros = || vec![0.0; depth.len()];
        let peaks = (plan.axes.iter())
            .map(|&axis| PeakProfile {
                axis,
                depth: depth.clone(),
                acceleration: zeros(),
                velocity: zeros(),
                displacement: zeros(),
                strain: zeros(),
                stress: zeros(),
            })
            .collect();
        let rows = CHUNK.min(samples) * field_probes.len();
        let field_row = || FieldRows {
            displacement: Vec::with_capacity(rows),
            velocity: Vec::with_capacity(rows),
            acceleration: Vec::with_capacity(rows),
        };
        let section_stride = samples.div_ceil(SECTION_ROWS).max(1);
        let section = |axis| Section {
            axis,
            depth: plan.field_depths.clone(),
            time: Vec::with_capacity(samples.div_ceil(section_stride)),
            acceleration: Vec::with_capacity(samples.div_ceil(section_stride) * plan.field_depths.len()),
        };
        let impedance: Vec<Option<f64>> = plan
            .axes
            .iter()
            .map(|&a| if plan.imposed() { plan.profile.base.impedance(a) } else { None })
            .collect();
        let mass: f64 = plan.column.layers.iter().map(|l| l.rho * l.thickness).sum();
        Ok(Self {
            time: room(),
            traces,
            field: plan.axes.iter().map(|_| field_row()).collect(),
            sections: plan.axes.iter().map(|&a| section(a)).collect(),
            peaks,
            outcrop_velocity: impedance.iter().map(|z| if z.is_some() { room() } else { vec![] }).collect(),
            ledger_rows: Vec::with_capacity(samples),
            ledger: Ledger::start(&column.energies()),
            probes,
            field_probes,
            impedance,
            order: plan.discretisation.order,
            section_stride,
            kinetic_floor: 1e-6 * mass * velocity_scale * velocity_scale,
            input_max: 0.0,
        })
    }

    /// Samples taken so far.
    pub fn samples_taken(&self) -> usize {
        self.time.len()
    }

    /// Takes a sample at the column's latest kick. Allocates nothing.
    pub fn sample(&mut self, column: &mut Column, elapsed: f64) -> Energies {
        let components = self.peaks.len();
        self.time.push(elapsed);
        for (p, probe) in self.probes.iter().enumerate() {
            for c in 0..components {
                let m = column.motion_at(probe, c);
                let trace = &mut self.traces[p * components + c];
                trace.acceleration.push(m.acceleration);
                trace.velocity.push(m.velocity);
                trace.displacement.push(m.displacement);
            }
        }
        for c in 0..components {
            self.section_row(column, c, elapsed);
            self.update_peaks(column, c);
            if let Some(z) = self.impedance[c] {
                self.outcrop_velocity[c].push(column.outcrop_velocity(c, z));
            }
        }
        let energies = column.energies();
        let residual = self.ledger.book(&energies);
        self.input_max = self.input_max.max(energies.input);
        self.ledger_rows.push(LedgerRow {
            time: elapsed,
            input: energies.input,
            kinetic: energies.kinetic,
            strain: energies.strain,
            viscous: energies.viscous,
            outflow: energies.outflow,
            residual,
        });
        energies
    }

    fn section_row(&mut self, column: &Column, c: usize, elapsed: f64) {
        if self.field_probes.is_empty() {
            return;
        }
        let (field, section) = (&mut self.field[c], &mut self.sections[c]);
        let drawn = (self.time.len() - 1).is_multiple_of(self.section_stride);
        if drawn {
            section.time.push(elapsed);
        }
        for probe in &self.field_probes {
            let m = column.motion_at(probe, c);
            field.displacement.push(m.displacement as f32);
            field.velocity.push(m.velocity as f32);
            field.acceleration.push(m.acceleration as f32);
            if drawn {
                section.acceleration.push(m.acceleration as f32);
            }
        }
    }

    fn update_peaks(&mut self, column: &Column, c: usize) {
        let n = self.order + 1;
        let base = column.node_motion(column.mesh().nodes() - 1, c).displacement;
        let peak = &mut self.peaks[c];
        let raise = |slot: &mut f64, value: f64| *slot = slot.max(value.abs());
        for k in 0..peak.depth.len() {
            let m = column.node_motion(k / n * self.order + k % n, c);
            raise(&mut peak.acceleration[k], m.acceleration);
            raise(&mut peak.velocity[k], m.velocity);
            raise(&mut peak.displacement[k], m.displacement - base);
        }
        column.strain_stress(c, |k, strain, stress| {
            raise(&mut peak.strain[k], strain);
            raise(&mut peak.stress[k], stress);
        });
    }

    /// The watchdog: kinetic energy beyond all that came in has no physical cause.
    pub fn grows_without_cause(&self, energies: &Energies) -> bool {
        !energies.kinetic.is_finite() || energies.kinetic > 4.0 * self.input_max + self.kinetic_floor
    }
}

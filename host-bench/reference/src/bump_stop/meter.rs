//! Meters and energy ledger of a bump-stop run.

use super::propagator::{Moments, Propagator};
use super::regime::Regime;
use super::system::{Row, System, value};
use crate::ledger::{Effort, Ledger, Totals, integral};
use crate::schedule::Recorder;
use harvester_scene::outcome::{BUMP_STOP_COLUMNS, BumpStopOutcome, ClampOutcome, Particular, with_store};
use harvester_scene::rainflow::Rainflow;
use harvester_scene::scene_file::Scene;

const COLUMNS: &[&str; 8] = &with_store(BUMP_STOP_COLUMNS);

/// The values of a linear quantity along a step of `ticks` between two vectors: at the start, at a turn, at the end.
///
/// The part of the step with the turn is halved on the exact path until a parabola departs from its ends by less than a
/// thousandth of `scale`: a circuit may relax within a small part of a step.
fn values(
    propagator: &Propagator,
    [row, rate]: [&Row; 2],
    [start, end]: [&[f64]; 2],
    mut ticks: u64,
    scale: f64,
) -> [f64; 3] {
    let [first, last] = [value(row, start), value(row, end)];
    let [mut leaves, mut arrives] = [value(rate, start), value(rate, end)];
    if (leaves > 0.0) == (arrives > 0.0) {
        return [first, last, last];
    }
    let (mut here, mut middle) = (start.to_vec(), Vec::new());
    loop {
        let length = ticks as f64 * propagator.tick();
        if ticks < 2 || length * (leaves - arrives).abs() <= 1e-3 * scale.max(first.abs()).max(last.abs()) {
            return [first, value(row, &here) + 0.5 * length * leaves * leaves / (leaves - arrives), last];
        }
        propagator.advance(&here, ticks / 2, &mut middle);
        let slope = value(rate, &middle);
        if (slope > 0.0) == (leaves > 0.0) {
            leaves = slope;
            std::mem::swap(&mut here, &mut middle);
            ticks -= ticks / 2;
        } else {
            arrives = slope;
            ticks /= 2;
        }
    }
}

/// Everything that is summed or compared along a run.
pub(super) struct Meter<'a> {
    system: &'a System,
    /// Stiffness in N/m of the closed contact; 0 if it is rigid.
    stiffness: f64,
    has_stop: bool,
    recorder: Option<Recorder>,
    moments: Moments,
    pub(super) ledger: Ledger,
    /// Magnitude of the base power in W at the end of the last step.
    base_power: f64,
    /// Rows of the velocities of tip and stop point, which are continuous.
    tip_rate: Row,
    stop_point_rate: Row,
    /// Largest magnitudes.
    tip: f64,
    stop_point: f64,
    voltage: f64,
    force: f64,
    curvature: f64,
    /// `∫ κ² dt` of the curvature at the clamp in s/m², and its cycles.
    curvature_squared: f64,
    cycles: Rainflow,
    contacts: u64,
    contact_time: f64,
    /// Momentum of the impacts in N s.
    momentum: f64,
    first_contact: Option<f64>,
}

impl<'a> Meter<'a> {
    pub(super) fn new(
        system: &'a System,
        stiffness: f64,
        has_stop: bool,
        start: &[f64],
        record_every: Option<f64>,
    ) -> Self {
        Self {
            system,
            stiffness,
            has_stop,
            recorder: record_every.map(Recorder::new),
            moments: Moments::new(),
            ledger: Ledger::new(energies(system, stiffness, start)),
            base_power: 0.0,
            tip_rate: System::rate(&system.tip, &system.free),
            stop_point_rate: System::rate(&system.stop_point, &system.free),
            tip: 0.0,
            stop_point: 0.0,
            voltage: 0.0,
            force: 0.0,
            curvature: 0.0,
            curvature_squared: 0.0,
            cycles: Rainflow::default(),
            contacts: 0,
            contact_time: 0.0,
            momentum: 0.0,
            first_contact: None,
        }
    }

    /// The moments from which the integrals follow.
    pub(super) fn moments(&mut self) -> &mut Moments {
        &mut self.moments
    }

    /// Adds the integrals since the last call.
    pub(super) fn sum_up(&mut self, propagator: &Propagator) {
        self.ledger.add(&self.moments.take(propagator));
    }

    /// Measures one step of `ticks`.
    pub(super) fn watch(&mut self, ends: [&[f64]; 2], ticks: u64, regime: &Regime, in_contact: bool) {
        let ([_, end], length) = (ends, ticks as f64 * regime.propagator.tick());
        self.ledger.compare(energies(self.system, self.stiffness, end));
        // The trapezium is accurate enough for the scale of a residual.
        let power = (value(&self.system.base, end) * value(&self.system.base_lever, end)).abs();
        self.ledger.base_work_magnitude += 0.5 * length * (self.base_power + power);
        self.base_power = power;
        if !self.ledger.in_window {
            return;
        }
        let system = self.system;
        let turned = |so_far: &mut f64, row, rate| {
            let values = values(&regime.propagator, [row, rate], ends, ticks, *so_far);
            *so_far = values.into_iter().fold(*so_far, |largest, value| largest.max(value.abs()));
            values
        };
        turned(&mut self.tip, &system.tip, &self.tip_rate);
        turned(&mut self.stop_point, &system.stop_point, &self.stop_point_rate);
        turned(&mut self.voltage, &system.voltage, &regime.voltage_rate);
        let bent = turned(&mut self.curvature, &regime.clamp, &regime.clamp_rate);
        bent.into_iter().for_each(|curvature| self.cycles.push(curvature));
        // The trapezium: a step is at most a tenth of the shortest period.
        let [from, _, to] = bent;
        self.curvature_squared += 0.5 * length * (from * from + to * to);
        if in_contact {
            self.contact_time += length;
            turned(&mut self.force, &regime.force, &regime.force_rate);
        }
    }

    /// Records the rows that are due within a step of `length` seconds from `time` on.
    pub(super) fn record(&mut self, time: f64, length: f64, start: &[f64], regime: &Regime) {
        let Self { recorder: Some(recorder), system, has_stop, .. } = self else { return };
        let tick = regime.propagator.tick();
        let mut vector = Vec::new();
        recorder.until(time + length, |due| {
            let ticks = ((due - time).clamp(0.0, length) / tick) as u64;
            regime.propagator.advance(start, ticks, &mut vector);
            let of = |row: &Row| value(row, &vector);
            let of_stop = |row: &Row| if *has_stop { of(row) } else { f64::NAN };
            let (tip, stop_point, face) =
                (of(&system.tip), of_stop(&system.stop_point), of_stop(&system.face));
            let (voltage, force, base) = (of(&system.voltage), of_stop(&regime.force), of(&system.base));
            let mut row = vec![due, tip, stop_point, face, voltage, force, base];
            row.extend(system.storage.map(|_| of(&system.storage_voltage)));
            row
        });
    }

    /// Counts a contact that begins at `time` seconds.
    pub(super) fn contact(&mut self, time: f64) {
        self.first_contact.get_or_insert(time);
        self.contacts += u64::from(self.ledger.in_window);
    }

    /// Adds an impact of this momentum in N s that loses `loss` joules.
    pub(super) fn impact(&mut self, momentum: f64, loss: f64) {
        self.ledger.impact_loss += loss;
        if self.ledger.in_window {
            self.momentum += momentum;
        }
    }

    /// The sums of a run that ends at this vector.
    ///
    /// Ledger of the motion: base, damping, impacts and the work on the charge. Ledger of the charge: that
    /// work, the load and the diodes. With two-way coupling the two close together; with one-way coupling the
    /// charge takes nothing from the beam, each closes by itself, and the larger remainder counts.
    pub(super) fn close(self, scene: &Scene, end: &[f64], events: u64, steps: u64) -> Totals {
        let length = scene.run.window_s();
        let periods = scene.excitation.single_frequency().map(|frequency| frequency * length);
        let Self { system, has_stop, .. } = self;
        let [beam_natural_frequencies_hz, rod_natural_frequencies_hz] = system.modes.natural_frequencies_hz();
        let [motion, charge, storage_energy] = energies(system, self.stiffness, end);
        let Ledger { total, window, start, impact_loss, .. } = &self.ledger;
        let work = total[integral::BASE_WORK] - total[integral::DAMPING] - impact_loss;
        let motion = motion - start[0] - work;
        let charge = charge - start[1] + total[integral::INTO_LOAD] + total[integral::DIODES];
        Totals {
            created_energy: None,
            remainder: if system.two_way {
                (motion + charge).abs()
            } else {
                motion.abs().max((charge - total[integral::COUPLING]).abs())
            },
            peak_voltage: self.voltage,
            delivered_energy: window[integral::INTO_LOAD],
            storage: system.storage,
            storage_end: [value(&system.storage_voltage, end), storage_energy],
            events,
            effort: Effort { steps, ..Effort::default() },
            particular: Particular::BumpStop(BumpStopOutcome {
                beam_natural_frequencies_hz,
                rod_natural_frequencies_hz,
                peak_tip_displacement_m: Some(self.tip),
                peak_stop_point_displacement_m: has_stop.then_some(self.stop_point),
                contacts: self.contacts,
                contacts_per_period: periods.map(|periods| self.contacts as f64 / periods),
                contact_fraction: Some(self.contact_time / length),
                first_contact_s: self.first_contact,
                peak_force_n: has_stop.then_some(self.force),
                mean_force_n: has_stop.then(|| (window[integral::FORCE] + self.momentum) / length),
                clamp: Some(ClampOutcome::new(
                    [self.curvature, (self.curvature_squared / length).sqrt()],
                    (&self.cycles, length),
                    system.modes.fibres.map(|[distance, modulus]| {
                        move |curvature: f64| [distance * curvature, modulus * distance * curvature]
                    }),
                )),
                end_state: system.layout.by_mode(end),
            }),
            ledger: self.ledger,
            recorder: self.recorder,
            columns: COLUMNS,
        }
    }
}

/// Energies in J of beam, rod and contact, of the charge, and of the storage.
fn energies(system: &System, stiffness: f64, vector: &[f64]) -> [f64; 3] {
    let [motion, charge, storage] = system.energies(vector);
    let penetration = value(&system.gap, vector).max(0.0);
    [motion + 0.5 * stiffness * penetration * penetration, charge, storage]
}

//! Meters and energy ledger of a bump-stop run.

use super::propagator::{FORMS, Moments, Propagator};
use super::regime::{Regime, form};
use super::system::{Row, System, value};
use crate::outcome::{BUMP_STOP_COLUMNS, BumpStopOutcome, Recording, StoreOutcome, with_store};
use crate::scene_file::Scene;

/// Columns of a recording with a store.
const WITH_STORE: [&str; 8] = with_store(BUMP_STOP_COLUMNS);

/// Rows at equal distances in time.
#[derive(Debug)]
struct Recorder {
    every: f64,
    next: u64,
    rows: Vec<Vec<f64>>,
}

/// The largest magnitude of a linear quantity in a step of `length` seconds between two vectors: at its ends,
/// and at a turn inside on the cubic through both. A tenth of the shortest period is well described by it.
fn highest(row: &[f64], rate: &[f64], [start, end]: [&[f64]; 2], length: f64) -> f64 {
    let [from, to] = [value(row, start), value(row, end)];
    let [leaves, arrives] = [value(rate, start), value(rate, end)];
    let at_ends = from.abs().max(to.abs());
    if (leaves > 0.0) == (arrives > 0.0) {
        return at_ends;
    }
    at_ends.max(cubic_turn(from, to, leaves * length, arrives * length).abs())
}

/// Value at the turn of the cubic on [0, 1] with these ends and slopes, the slopes of opposite sign.
fn cubic_turn(from: f64, to: f64, leaves: f64, arrives: f64) -> f64 {
    // Slope: a s² + b s + leaves; zero once in the interval, by bisection.
    let a = 3.0 * (leaves + arrives - 2.0 * (to - from));
    let b = 2.0 * (3.0 * (to - from) - 2.0 * leaves - arrives);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle: f64 = 0.5 * (low + high);
        if ((a * middle + b) * middle + leaves > 0.0) == (leaves > 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    from + low * (leaves + low * (0.5 * b + low * a / 3.0))
}

/// Everything that is summed or compared along a run.
#[derive(Debug)]
pub(super) struct Meters<'a> {
    system: &'a System,
    /// One over the contact's compliance in N/m while a spring closes it, else 0.
    stiffness: f64,
    recorder: Option<Recorder>,
    moments: Moments,
    total: [f64; FORMS],
    window: [f64; FORMS],
    base_work_magnitude: f64,
    base_power: f64,
    impact_loss: f64,
    start_energies: [f64; 3],
    peak_stored_energy: f64,
    in_window: bool,
    has_stop: bool,
    /// Rates of the displacements, which no force and no current changes at once.
    tip_rate: Row,
    stop_point_rate: Row,
    /// Largest magnitudes.
    tip: f64,
    stop_point: f64,
    voltage: f64,
    force: f64,
    contacts: u64,
    contact_time: f64,
    momentum: f64,
    first_contact: Option<f64>,
}

impl<'a> Meters<'a> {
    pub(super) fn new(
        system: &'a System,
        stiffness: f64,
        has_stop: bool,
        start: &[f64],
        record_every: Option<f64>,
    ) -> Self {
        let mut meters = Self {
            system,
            stiffness,
            recorder: record_every.map(|every| Recorder { every, next: 0, rows: Vec::new() }),
            moments: Moments::new(),
            total: [0.0; FORMS],
            window: [0.0; FORMS],
            base_work_magnitude: 0.0,
            base_power: 0.0,
            impact_loss: 0.0,
            start_energies: [0.0; 3],
            peak_stored_energy: 0.0,
            in_window: false,
            has_stop,
            tip_rate: System::rate(&system.tip, &system.free),
            stop_point_rate: System::rate(&system.stop_point, &system.free),
            tip: 0.0,
            stop_point: 0.0,
            voltage: 0.0,
            force: 0.0,
            contacts: 0,
            contact_time: 0.0,
            momentum: 0.0,
            first_contact: None,
        };
        meters.start_energies = meters.energies(start);
        meters.peak_stored_energy = meters.start_energies[0] + meters.start_energies[1];
        meters
    }

    /// Energy in J of beam, rod and contact, that of the charge, and that of the store.
    fn energies(&self, vector: &[f64]) -> [f64; 3] {
        let [motion, charge] = self.system.energies(vector);
        let penetration = value(&self.system.gap, vector).max(0.0);
        let contact = 0.5 * self.stiffness * penetration * penetration;
        [motion + contact, charge, self.system.stored(vector)]
    }

    /// Whether what follows lies in the measuring window.
    pub(super) fn set_in_window(&mut self, in_window: bool) {
        self.in_window = in_window;
    }

    /// Where to take down what the integrals need.
    pub(super) fn moments(&mut self) -> &mut Moments {
        &mut self.moments
    }

    /// Sums up the integrals since the last call.
    pub(super) fn sum_up(&mut self, propagator: &Propagator) {
        let integrals = self.moments.take(propagator);
        for (index, integral) in integrals.into_iter().enumerate() {
            self.total[index] += integral;
            if self.in_window {
                self.window[index] += integral;
            }
        }
    }

    /// Looks at one step of `length` seconds.
    pub(super) fn watch(&mut self, ends: [&[f64]; 2], length: f64, regime: &Regime, in_contact: bool) {
        let [_, end] = ends;
        let [motion, charge, store] = self.energies(end);
        // Of a store that is not empty at the start, what it has gained or given.
        let moved = (store - self.start_energies[2]).abs();
        self.peak_stored_energy = self.peak_stored_energy.max(motion + charge + moved);
        // Only a residual is divided by this: the trapezium is enough.
        let power = (value(&self.system.base, end) * value(&self.system.base_lever, end)).abs();
        self.base_work_magnitude += 0.5 * length * (self.base_power + power);
        self.base_power = power;
        if !self.in_window {
            return;
        }
        let system = self.system;
        let turned = |so_far: &mut f64, row, rate| *so_far = so_far.max(highest(row, rate, ends, length));
        turned(&mut self.tip, &system.tip, &self.tip_rate);
        turned(&mut self.stop_point, &system.stop_point, &self.stop_point_rate);
        turned(&mut self.voltage, &system.voltage, &regime.voltage_rate);
        if in_contact {
            self.contact_time += length;
            turned(&mut self.force, &regime.force, &regime.force_rate);
        }
    }

    /// Writes the rows that are due within a step of `length` seconds from `time` on.
    pub(super) fn record(&mut self, time: f64, length: f64, start: &[f64], regime: &Regime) {
        let Some(recorder) = &mut self.recorder else { return };
        let tick = regime.propagator.tick();
        let mut vector = Vec::new();
        loop {
            let due = recorder.next as f64 * recorder.every;
            // A row due at the end of the run may be computed as just after it.
            if due > (time + length) * (1.0 + 4.0 * f64::EPSILON) {
                return;
            }
            let ticks = ((due - time).clamp(0.0, length) / tick) as u64;
            regime.propagator.advance(start, ticks, &mut vector);
            let of = |row: &Row| value(row, &vector);
            let system = self.system;
            let (stop_point, force) = if self.has_stop {
                (of(&system.stop_point), of(&regime.force))
            } else {
                (f64::NAN, f64::NAN)
            };
            let face = if self.has_stop { of(&system.face) } else { f64::NAN };
            let mut row =
                vec![due, of(&system.tip), stop_point, face, of(&system.voltage), force, of(&system.base)];
            row.extend(system.store.map(|_| of(&system.store_voltage)));
            recorder.rows.push(row);
            recorder.next += 1;
        }
    }

    /// A contact that begins at `time` seconds.
    pub(super) fn contact(&mut self, time: f64) {
        self.first_contact.get_or_insert(time);
        self.contacts += u64::from(self.in_window);
    }

    /// An impact of this momentum in N s that takes `loss` joules.
    pub(super) fn impact(&mut self, momentum: f64, loss: f64) {
        self.impact_loss += loss;
        if self.in_window {
            self.momentum += momentum;
        }
    }

    /// What is left over in the ledger, over the larger of `∫ |base power| dt` and the peak stored energy.
    ///
    /// Motion against base, damping, impacts and what goes to the charge; charge against that, the load, and
    /// the diodes before it; a store against what enters and leaves it. With coupling both ways the first two
    /// close together; one way the beam gives nothing and each closes by itself. The largest remainder counts.
    fn energy_residual(&self, end: &[f64]) -> Option<f64> {
        let [motion, charge, store] = self.energies(end);
        let [motion_before, charge_before, store_before] = self.start_energies;
        let total = &self.total;
        let motion =
            motion - motion_before - (total[form::BASE_WORK] - total[form::DAMPING] - self.impact_loss);
        let charge = charge - charge_before + total[form::LOAD] + total[form::DIODES];
        let harvester = if self.system.two_way {
            (motion + charge).abs()
        } else {
            motion.abs().max((charge - total[form::COUPLING]).abs())
        };
        let has_end = self.system.store.is_some_and(|store| store.capacitance.is_finite());
        let entered = total[form::LOAD] - total[form::LEAKED] - total[form::DRAWN];
        let left = if has_end { harvester.max((store - store_before - entered).abs()) } else { harvester };
        let scale = self.base_work_magnitude.max(self.peak_stored_energy);
        (scale > 0.0).then(|| left / scale)
    }

    /// Closes the books at the vector at the end of the run.
    pub(super) fn close(self, scene: &Scene, end: &[f64]) -> Totals {
        let length = scene.run.window_s();
        let delivered = self.window[form::LOAD];
        let periods = scene.excitation.single_frequency().map(|frequency| frequency * length);
        let Self { system, has_stop, total, .. } = &self;
        let has_stop = *has_stop;
        let losses = [form::DIODES, form::LEAKED, form::DRAWN].map(|form| total[form]);
        let store = system.store.map(|store| store.outcome(value(&system.store_voltage, end), losses));
        Totals {
            energy_residual: self.energy_residual(end),
            delivered_energy: delivered,
            mean_power: delivered / length,
            rms_voltage: (self.window[form::VOLTAGE_SQUARED].max(0.0) / length).sqrt(),
            mean_voltage: self.window[form::VOLTAGE] / length,
            peak_voltage: self.voltage,
            store,
            particular: BumpStopOutcome {
                natural_frequencies_hz: self.system.modes.natural_frequencies_hz(),
                peak_tip_displacement_m: Some(self.tip),
                peak_stop_point_displacement_m: has_stop.then_some(self.stop_point),
                contacts: self.contacts,
                contacts_per_period: periods.map(|periods| self.contacts as f64 / periods),
                contact_fraction: Some(self.contact_time / length),
                first_contact_s: self.first_contact,
                peak_force_n: has_stop.then_some(self.force),
                mean_force_n: has_stop.then(|| (self.window[form::FORCE] + self.momentum) / length),
                end_state: self.system.layout.by_mode(end),
            },
            recording: self.recorder.map(|recorder| Recording {
                columns: if store.is_some() { &WITH_STORE } else { &BUMP_STOP_COLUMNS },
                rows: recorder.rows,
            }),
        }
    }
}

/// The sums at the end of a run, in SI units.
#[derive(Debug)]
pub(super) struct Totals {
    pub(super) energy_residual: Option<f64>,
    pub(super) delivered_energy: f64,
    pub(super) mean_power: f64,
    pub(super) rms_voltage: f64,
    pub(super) mean_voltage: f64,
    pub(super) peak_voltage: f64,
    pub(super) particular: BumpStopOutcome,
    pub(super) store: Option<StoreOutcome>,
    pub(super) recording: Option<Recording>,
}

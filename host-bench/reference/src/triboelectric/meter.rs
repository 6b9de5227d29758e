//! Meters and energy ledgers of a triboelectric run.

use super::flow::Step;
use super::harvester::{CircuitKind, Counts, Harvester, Motion};
use super::stick::Stick;
use crate::ledger::{Effort, Ledger, Totals, integral};
use crate::schedule::Recorder;
use harvester_scene::base_motion::LocalBase;
use harvester_scene::root::far_side;
use harvester_scene::scene_file::Scene;

/// Everything that is summed or compared along a run.
pub(crate) struct Meter<'a, H> {
    harvester: &'a H,
    recorder: Option<Recorder>,
    pub(crate) ledger: Ledger,
    peak_voltage: f64,
    /// Time in s in stick.
    stick_time: f64,
    counts: Counts,
}

impl<'a, H: Harvester> Meter<'a, H> {
    pub(crate) fn new(harvester: &'a H, start: &Motion, record_every: Option<f64>) -> Self {
        let [mechanical, electrical] = harvester.energies(start);
        Self {
            harvester,
            recorder: record_every.map(Recorder::new),
            ledger: Ledger::new([mechanical, electrical, 0.0]),
            peak_voltage: 0.0,
            stick_time: 0.0,
            counts: Counts { highest: f64::NEG_INFINITY, lowest: f64::INFINITY, ..Counts::default() },
        }
    }

    /// Measures one step of a flow that began at `start` seconds.
    pub(crate) fn watch(&mut self, start: f64, base: &LocalBase, step: &Step<'_>) {
        self.ledger.compare(self.energies(&step.end.1));
        // The base power changes sign twice a period. The error of the step around that is far below the
        // accuracy that the scale of a residual needs.
        self.ledger.base_work_magnitude += step.integrals[integral::BASE_WORK].abs();
        let (from, to) = (step.start.0, step.end.0);
        if self.ledger.in_window {
            self.compare(&step.start.1);
            self.compare(&step.end.1);
            for turn in &step.turns {
                self.compare(&(step.exact)(*turn));
            }
            // By the equations the rate of a fast circuit is a difference of rounded numbers.
            let is_state = self.harvester.load().kind == CircuitKind::Dynamic;
            let slope = |t: f64| {
                if is_state {
                    (step.voltage_rate)(t)
                } else {
                    self.harvester.voltage_slope(&(step.motion)(t), base.at(t))
                }
            };
            if (slope(from) > 0.0) != (slope(to) > 0.0) {
                self.compare(&(step.exact)(far_side(slope, from, to)));
            }
        }
        self.record_until(start + to, |harvester, time| {
            let local = (time - start).clamp(from, to);
            let motion = (step.exact)(local);
            (motion, [harvester.voltage(&motion), base.at(local), 0.0])
        });
    }

    /// Measures the first `elapsed` seconds of a stick that began at `start` seconds.
    pub(crate) fn watch_stick(&mut self, start: f64, elapsed: f64, stick: &Stick<'_, H>) {
        self.ledger.add(&stick.integrals(elapsed));
        self.ledger.compare(self.energies(&stick.motion(elapsed)));
        if self.ledger.in_window {
            self.stick_time += elapsed;
            self.compare_position(stick.start.position);
            // The voltage only falls.
            self.peak_voltage = self.peak_voltage.max(stick.load_voltage(0.0).abs());
        }
        self.record_until(start + elapsed, |_, time| {
            let local = (time - start).clamp(0.0, elapsed);
            let row = [stick.load_voltage(local), stick.base.at(local), 1.0];
            (stick.motion(local), row)
        });
    }

    /// Counts an impact at `time` seconds, with its speed in m/s and its energy loss in J.
    pub(crate) fn impact(&mut self, time: f64, [speed, loss]: [f64; 2]) {
        self.ledger.impact_loss += loss;
        self.counts.first_impact.get_or_insert(time);
        if self.ledger.in_window {
            self.counts.impacts += 1;
            self.counts.impact_speed = self.counts.impact_speed.max(speed);
        }
    }

    /// Counts an entry into stick.
    pub(crate) fn stick(&mut self) {
        self.counts.sticks += u64::from(self.ledger.in_window);
    }

    fn compare_position(&mut self, position: f64) {
        self.counts.highest = self.counts.highest.max(position);
        self.counts.lowest = self.counts.lowest.min(position);
    }

    fn compare(&mut self, motion: &Motion) {
        self.compare_position(motion.position);
        self.peak_voltage = self.peak_voltage.max(self.harvester.voltage(motion).abs());
    }

    /// Records the rows that are due; `at` gives the motion at a time, the load voltage in V, the base
    /// acceleration in m/s², and 1 in stick.
    fn record_until(&mut self, time: f64, at: impl Fn(&H, f64) -> (Motion, [f64; 3])) {
        let Self { recorder: Some(recorder), harvester, .. } = self else { return };
        recorder.until(time, |due| {
            let (motion, [voltage, base, stick]) = at(harvester, due);
            let charge = harvester.charge(&motion);
            let mut row = vec![due, motion.position, motion.velocity, charge, voltage, base, stick];
            row.extend(harvester.load().storage.map(|storage| storage.voltage(&motion.bridge)));
            row
        });
    }

    /// Energies in J: mechanical, electrical, and the gain of the storage since the start.
    fn energies(&self, motion: &Motion) -> [f64; 3] {
        let [mechanical, electrical] = self.harvester.energies(motion);
        let storage = self.harvester.load().storage;
        [mechanical, electrical, storage.map_or(0.0, |storage| storage.gained(&motion.bridge))]
    }

    /// The sums of a run that ends in this motion.
    ///
    /// Mechanical ledger: energy of mass and spring against the work of the base, the damper, the surfaces and the impacts. Electrical
    /// ledger: `dW/dt = −F_field v − V²/R`, true for any motion; behind a bridge, less what enters diodes and storage. Where the laws
    /// conserve energy the two close together. Otherwise each closes by itself, and the larger remainder counts.
    pub(crate) fn close(mut self, scene: &Scene, end: &Motion, events: u64, effort: Effort) -> Totals {
        let length = scene.run.window_s();
        self.counts.stick_fraction = self.stick_time / length;
        self.counts.periods = scene.excitation.single_frequency().map(|frequency| frequency * length);
        let (harvester, load) = (self.harvester, self.harvester.load());
        let [mechanical, electrical, storage_energy] = self.energies(end);
        let Ledger { total, window, start, impact_loss, .. } = &self.ledger;
        let work = harvester.mechanical_work(total) - impact_loss;
        let mechanical = mechanical - start[0] - work;
        let given = -total[integral::FIELD_WORK] - load.delivered(total) - total[integral::DIODES];
        let electrical = electrical - start[1] - given;
        let storage_voltage = load.storage.map_or(0.0, |storage| storage.voltage(&end.bridge));
        Totals {
            remainder: if harvester.conserves_energy() {
                (mechanical + electrical).abs()
            } else {
                mechanical.abs().max(electrical.abs())
            },
            created_energy: Some(harvester.created_energy(window)),
            delivered_energy: load.delivered(window),
            ledger: self.ledger,
            peak_voltage: self.peak_voltage,
            storage: load.storage,
            storage_end: [storage_voltage, storage_energy],
            events,
            effort,
            particular: harvester.particular(&self.counts),
            recorder: self.recorder,
            columns: H::COLUMNS,
        }
    }
}

//! The integrals over a run, and the energy ledger made of them.

use cpu_time::ThreadTime;

use super::schedule::Recorder;
use super::storage::Storage;
use harvester_scene::outcome::{CreatedEnergy, Outcome, Particular, Recording};
use harvester_scene::scene_file::{Random, Scene};

/// Integrals over time, in the order of [`integral`].
pub(super) type Integrals = [f64; 10];

/// Places among the [`Integrals`]; those from [`integral::INTO_LOAD`] on are about the load.
pub(super) mod integral {
    /// `∫ V² dt` in V² s.
    pub(crate) const VOLTAGE_SQUARED: usize = 0;
    /// `∫ V dt` in V s.
    pub(crate) const VOLTAGE: usize = 1;
    /// Work of the base in J.
    pub(crate) const BASE_WORK: usize = 2;
    /// Loss in the damping in J.
    pub(crate) const DAMPING: usize = 3;
    /// Triboelectric: energy in J that the motion gives to the other surface, as work against the electrostatic
    /// force between plates or as loss in the friction between patches.
    pub(crate) const SURFACE_WORK: usize = 4;
    /// Bump-stop: `∫ F dt` of the contact force in N s.
    pub(crate) const FORCE: usize = 4;
    /// Triboelectric: work in J on the motion of the electrostatic force that conserves energy, whether it acts or not.
    pub(crate) const FIELD_WORK: usize = 5;
    /// Bump-stop: `∫ v Σ θ r' dt` in J, the work of the beam on the charge.
    pub(crate) const COUPLING: usize = 5;
    /// Energy in J into the storage or bus; of a bump-stop scene also into the resistor.
    pub(crate) const INTO_LOAD: usize = 6;
    /// Loss in the diodes in J.
    pub(crate) const DIODES: usize = 7;
    /// Energy in J that leaks from the storage.
    pub(crate) const LEAKED: usize = 8;
    /// Energy in J that the node draws from the storage.
    pub(crate) const DRAWN: usize = 9;
}

/// Adds others times a weight.
pub(super) fn add(sums: &mut Integrals, weight: f64, others: &Integrals) {
    for (sum, other) in sums.iter_mut().zip(others) {
        *sum += weight * other;
    }
}

pub(super) struct Ledger {
    /// Integrals over the whole run.
    pub(super) total: Integrals,
    /// Integrals over the measuring window.
    pub(super) window: Integrals,
    /// Whether what follows lies in the measuring window.
    pub(super) in_window: bool,
    /// Energy in J lost in impacts.
    pub(super) impact_loss: f64,
    /// `∫ |base power| dt` in J.
    pub(super) base_work_magnitude: f64,
    /// Energies in J at the start: mechanical, electrical, and of the storage.
    pub(super) start: [f64; 3],
    peak_stored: f64,
}

impl Ledger {
    pub(super) fn new(start: [f64; 3]) -> Self {
        Self {
            total: Integrals::default(),
            window: Integrals::default(),
            in_window: false,
            impact_loss: 0.0,
            base_work_magnitude: 0.0,
            start,
            peak_stored: start[0] + start[1],
        }
    }

    pub(super) fn add(&mut self, stretch: &Integrals) {
        add(&mut self.total, 1.0, stretch);
        if self.in_window {
            add(&mut self.window, 1.0, stretch);
        }
    }

    /// Compares the stored energy with the largest so far; a storage counts with its gain or loss since the start.
    pub(super) fn compare(&mut self, [mechanical, electrical, storage]: [f64; 3]) {
        let stored = mechanical + electrical + (storage - self.start[2]).abs();
        self.peak_stored = self.peak_stored.max(stored);
    }

    /// Largest of the remainders in J at the end of the run, over the larger of `∫ |base power| dt` and the
    /// peak stored energy. The storage has a remainder of its own; a bus has none.
    pub(super) fn residual(
        &self,
        remainder: f64,
        storage: Option<Storage>,
        storage_energy: f64,
    ) -> Option<f64> {
        let [into, leaked, drawn] =
            [integral::INTO_LOAD, integral::LEAKED, integral::DRAWN].map(|place| self.total[place]);
        let of_storage = if storage.is_some_and(|storage| !storage.is_bus()) {
            storage_energy - self.start[2] - (into - leaked - drawn)
        } else {
            0.0
        };
        let scale = self.base_work_magnitude.max(self.peak_stored);
        (scale > 0.0).then(|| remainder.max(of_storage.abs()) / scale)
    }
}

/// Work of the integrator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Effort {
    /// Steps that the motion is made of, and for each event the one over it.
    pub(super) steps: u64,
    /// Refused attempts, and steps that were taken again because of an event in them.
    pub(super) rejected: u64,
    pub(super) newton_iterations: u64,
}

impl Effort {
    pub(super) fn attempts(&self) -> u64 {
        self.steps + self.rejected
    }

    /// Counts the last accepted step as refused.
    pub(super) fn refuse(&mut self) {
        self.steps -= 1;
        self.rejected += 1;
    }
}

/// The sums at the end of a run.
pub(super) struct Totals {
    pub(super) ledger: Ledger,
    /// Remainder in J of the mechanical and the electrical ledger.
    pub(super) remainder: f64,
    /// Largest magnitude of the voltage in the measuring window in V.
    pub(super) peak_voltage: f64,
    /// Energy in J that the force law created in the measuring window; `None` for a bump-stop scene.
    pub(super) created_energy: Option<f64>,
    /// Energy delivered in the measuring window in J.
    pub(super) delivered_energy: f64,
    pub(super) storage: Option<Storage>,
    /// Voltage of the storage in V at the end, and its energy in J as the ledger has it.
    pub(super) storage_end: [f64; 2],
    pub(super) events: u64,
    pub(super) effort: Effort,
    pub(super) particular: Particular,
    pub(super) recorder: Option<Recorder>,
    /// Columns of the recording, the last one that of the storage voltage.
    pub(super) columns: &'static [&'static str; 8],
}

impl Totals {
    /// The outcome of a run of the scene that began at this instant.
    pub(super) fn outcome(self, scene: &Scene, began: ThreadTime) -> Outcome {
        let length = scene.run.window_s();
        let Ledger { total, window, .. } = &self.ledger;
        let [voltage, energy] = self.storage_end;
        let losses = [integral::DIODES, integral::LEAKED, integral::DRAWN].map(|place| total[place]);
        let columns = if self.storage.is_some() { self.columns } else { &self.columns[..7] };
        Outcome {
            scene: scene.name(),
            method: "reference".to_owned(),
            precision: "f64",
            math: "std",
            duration_s: scene.run.duration_s,
            settle_s: scene.run.settle_s,
            mean_power_w: Some(self.delivered_energy / length),
            rms_voltage_v: Some((window[integral::VOLTAGE_SQUARED].max(0.0) / length).sqrt()),
            peak_voltage_v: Some(self.peak_voltage),
            mean_voltage_v: Some(window[integral::VOLTAGE] / length),
            delivered_energy_j: Some(self.delivered_energy),
            created: self
                .created_energy
                .map(|created| CreatedEnergy::new(created, self.delivered_energy, self.remainder)),
            base_rms_m_per_s2: scene.excitation.random().map(Random::rms_m_per_s2),
            energy_residual: self.ledger.residual(self.remainder, self.storage, energy),
            steps: self.effort.steps,
            rejected_steps: self.effort.rejected,
            newton_iterations: self.effort.newton_iterations,
            events: self.events,
            processor_s: began.elapsed().as_secs_f64(),
            particular: self.particular,
            store: self.storage.map(|storage| storage.outcome(voltage, losses)),
            trace: self.recorder.map(|recorder| Recording {
                columns,
                rows: recorder.rows,
                impacts_s: Vec::new(),
            }),
            ..Outcome::default()
        }
    }
}

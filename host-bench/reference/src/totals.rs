//! The sums at the end of a reference run, and the outcome made of them.

use cpu_time::ThreadTime;
use diffsol::ode_solver::OdeSolverStatistics;

use super::ledger::{Ledger, integral};
use super::recorder::Recorder;
use super::storage::Storage;
use harvester_scene::outcome::{CreatedEnergy, Outcome, Particular, Recording};
use harvester_scene::scene_file::{Random, Scene};

/// Work of the integrator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Effort {
    pub(super) steps: u64,
    pub(super) rejected: u64,
    pub(super) newton_iterations: u64,
}

impl Effort {
    /// Adds the work on one flow.
    pub(super) fn add(&mut self, work: &OdeSolverStatistics) {
        let rejected = work.number_of_error_test_failures + work.number_of_nonlinear_solver_fails;
        self.steps += work.number_of_steps as u64;
        self.rejected += rejected as u64;
        self.newton_iterations += work.number_of_nonlinear_solver_iterations as u64;
    }
}

/// The sums at the end of a run.
#[derive(Debug)]
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

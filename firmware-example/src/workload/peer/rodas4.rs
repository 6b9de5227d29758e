//! The smooth scene by the crate `numeris`: its RODAS4, in single precision.
//!
//! The same equations, in the way its interface wants them: right-hand side and Jacobian as
//! closures, the delivered energy as a fourth state, all states scaled to one because it has one
//! absolute tolerance for all. RODAS4 is of fourth order for autonomous systems, and numeris 0.6 has
//! no term with the derivative by time for the others; so time is a fifth state, which is the same.

use model_core::scalar::{Mathematics, Polynomial, Scalar};
use numeris::ode::{AdaptiveSettings, RODAS4, Rosenbrock};
use numeris::{Matrix, Vector};

use crate::workload::contact_separation::{SMOOTH, whole};
use crate::workload::run::Plan;
use crate::workload::{Progress, Workload};

/// States: gap over `d0`, velocity over `ω0 d0`, charge over `σS`, energy in microjoules, time in seconds.
const STATES: usize = 5;
/// Joules in the unit of the energy.
const ENERGY_UNIT: f32 = 1e-6;
const VACUUM_PERMITTIVITY: f32 = model_core::part::VACUUM_PERMITTIVITY as f32;

/// Coefficients of the default scene.
#[derive(Debug, Clone, Copy)]
struct Model {
    plan: Plan,
    gap: f32,
    angular_frequency: f32,
    damping: f32,
    dielectric: f32,
    tribo: f32,
    parasitic: f32,
    rate: f32,
    /// Watts per square of the charge's rate, in energy units.
    power: f32,
}

/// Quantities that right-hand side and Jacobian share.
struct Circuit {
    sharing: f32,
    shared: f32,
    transferred: f32,
    distance: f32,
    charge_rate: f32,
}

impl Model {
    fn new(plan: Plan) -> Self {
        let from = whole();
        let angular_frequency = (from.stiffness / from.mass).sqrt();
        let area = VACUUM_PERMITTIVITY * from.electrode_area;
        let unit = (2.0 * area * from.mass).sqrt();
        Self {
            plan,
            gap: from.initial_gap,
            angular_frequency,
            damping: 2.0 * from.damping_ratio * angular_frequency,
            dielectric: from.dielectric_thickness / from.relative_permittivity,
            tribo: from.charge_density * from.electrode_area / unit,
            parasitic: from.choices.parasitic.capacitance / area,
            rate: 1.0 / from.choices.load.resistance / area,
            power: from.choices.load.resistance * unit * unit / ENERGY_UNIT,
        }
    }

    #[inline]
    fn circuit(&self, y: &Vector<f32, STATES>) -> Circuit {
        let (gap, charge) = (self.gap * y[0], self.tribo * y[2]);
        let distance = gap + self.dielectric;
        let sharing = 1.0 / (1.0 + self.parasitic * distance);
        let transferred = (charge + self.parasitic * self.tribo * gap) * sharing;
        let voltage = (self.tribo * gap - charge * distance) * sharing;
        let charge_rate = self.rate * voltage;
        Circuit { sharing, shared: transferred * sharing, transferred, distance, charge_rate }
    }

    /// Phase of the base at a time, in units of 2⁻⁶⁴ turns.
    #[inline]
    fn phase(&self, time: f32) -> u64 {
        let turns = self.plan.frequency * time;
        let fraction = turns - turns as u32 as f32;
        u64::from((fraction * 4_294_967_296.0) as u32) << 32
    }

    /// Base acceleration, by the polynomial that model-core uses too.
    #[inline]
    fn base(&self, time: f32) -> f32 {
        self.plan.amplitude * <Polynomial as Mathematics<f32>>::sine_of_turns(self.phase(time))
    }

    /// Its derivative by time.
    #[inline]
    fn jerk(&self, time: f32) -> f32 {
        let cosine = <Polynomial as Mathematics<f32>>::cosine_of_turns(self.phase(time));
        core::f32::consts::TAU * self.plan.frequency * self.plan.amplitude * cosine
    }

    #[inline]
    fn flow(&self, y: &Vector<f32, STATES>) -> Vector<f32, STATES> {
        let circuit = self.circuit(y);
        let force = circuit.shared * circuit.shared + self.base(y[4]);
        Vector::from_array([
            self.angular_frequency * y[1],
            -self.damping * y[1]
                - self.angular_frequency * (y[0] - 1.0)
                - force / (self.angular_frequency * self.gap),
            circuit.charge_rate / self.tribo,
            self.power * circuit.charge_rate * circuit.charge_rate,
            1.0,
        ])
    }

    #[inline]
    fn jacobian(&self, y: &Vector<f32, STATES>) -> Matrix<f32, STATES, STATES> {
        let Circuit { sharing, shared, transferred, distance, charge_rate } = self.circuit(y);
        let voltage_by_gap = (self.tribo - transferred) * sharing;
        let transferred_by_gap = self.parasitic * voltage_by_gap;
        let force_by_gap = 2.0 * shared * sharing * (transferred_by_gap - self.parasitic * shared);
        let force_by_charge = 2.0 * shared * sharing * sharing;
        let by_gap = self.rate * voltage_by_gap;
        let by_charge = -self.rate * distance * sharing;
        let per_velocity = self.angular_frequency * self.gap;
        let power = 2.0 * self.power * charge_rate;
        Matrix::new([
            [0.0, self.angular_frequency, 0.0, 0.0, 0.0],
            [
                -self.angular_frequency - force_by_gap * self.gap / per_velocity,
                -self.damping,
                -force_by_charge * self.tribo / per_velocity,
                0.0,
                -self.jerk(y[4]) / per_velocity,
            ],
            [by_gap * self.gap / self.tribo, 0.0, by_charge, 0.0, 0.0],
            [power * by_gap * self.gap, 0.0, power * by_charge * self.tribo, 0.0, 0.0],
            [0.0; STATES],
        ])
    }
}

/// A run of the smooth scene.
#[derive(Debug)]
pub(super) struct Rodas4 {
    model: Model,
    tolerance: f32,
    done: bool,
    bits: [u32; 5],
}

impl Rodas4 {
    /// With `tolerance` as its relative and its absolute tolerance.
    #[must_use]
    pub(super) fn new(tolerance: f32) -> Self {
        let plan = Plan { name: "numeris-rodas4", ..SMOOTH };
        Self { model: core::hint::black_box(Model::new(plan)), tolerance, done: false, bits: [0; 5] }
    }
}

impl Workload for Rodas4 {
    fn name(&self) -> &'static str {
        self.model.plan.name
    }

    fn advance(&mut self) -> Progress {
        if self.done {
            return Progress::Finished;
        }
        self.done = true;
        let model = &self.model;
        let relaxed = model.gap / (model.gap + model.dielectric);
        let start = Vector::from_array([1.0, 0.0, relaxed, 0.0, 0.0]);
        let settings = AdaptiveSettings::<f32> {
            rel_tol: self.tolerance,
            abs_tol: self.tolerance,
            min_step: 1e-7,
            ..AdaptiveSettings::default()
        };
        let seconds = model.plan.quarters as f32 * 0.25;
        let run = RODAS4::integrate(
            0.0,
            seconds,
            &start,
            |_, y| model.flow(y),
            |_, y| model.jacobian(y),
            &settings,
        );
        let Ok(run) = run else { return Progress::Failed };
        let velocity = model.angular_frequency * model.gap * run.y[1];
        let values = [model.gap * run.y[0], velocity, model.tribo * run.y[2], 0.0, ENERGY_UNIT * run.y[3]];
        self.bits = values.map(f32::to_bits);
        Progress::Sample { steps: run.accepted as u32, simulated_us: model.plan.quarters * 250_000 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

//! The meters of a run: the same numbers as those of the core.

use model_core::integrate::Cubic;

use super::system::{State, System};
use crate::outcome::{BumpStopOutcome, Outcome, Particular};
use crate::scene_file::{Random, Scene};

#[derive(Debug, Clone, Copy)]
struct Sample {
    /// Voltage, displacement of the tip and of the beam at the stop, with their rates.
    quantities: [[f64; 2]; 3],
    penetration: f64,
    force: f64,
}

/// Places in [`Sample::quantities`] and [`Meter::peaks`].
const VOLTAGE: usize = 0;
const TIP: usize = 1;
const STOP_POINT: usize = 2;

impl Sample {
    fn of(system: &System, state: &State) -> Self {
        let penetration = system.penetration(state);
        Self {
            quantities: [
                [state.voltage, system.voltage_rate(state)],
                system.tip(state),
                system.stop_point(state),
            ],
            penetration,
            force: system.force(penetration),
        }
    }
}

/// Sums and peaks along a run.
pub(super) struct Meter<'a> {
    system: &'a System,
    last: Sample,
    in_window: bool,
    peaks: [f64; 3],
    voltage_squared: f64,
    voltage: f64,
    impulse: f64,
    peak_force: f64,
    contact_time: f64,
    contacts: u64,
    first_contact: Option<f64>,
}

/// Integral over a step of a quantity given with its rate at both ends: the trapezium and its correction.
fn integral([from, leaves]: [f64; 2], [to, arrives]: [f64; 2], step: f64) -> f64 {
    0.5 * step * (from + to) + step * step / 12.0 * (leaves - arrives)
}

impl<'a> Meter<'a> {
    pub(super) fn new(system: &'a System, start: &State) -> Self {
        Self {
            system,
            last: Sample::of(system, start),
            in_window: false,
            peaks: [0.0; 3],
            voltage_squared: 0.0,
            voltage: 0.0,
            impulse: 0.0,
            peak_force: 0.0,
            contact_time: 0.0,
            contacts: 0,
            first_contact: None,
        }
    }

    /// Whether what follows lies in the measuring window.
    pub(super) fn measure(&mut self, in_window: bool) {
        self.in_window = in_window;
    }

    /// Takes in the step of `step` seconds from `time` that ends in `end`.
    pub(super) fn add(&mut self, end: &State, time: f64, step: f64) {
        let before = std::mem::replace(&mut self.last, Sample::of(self.system, end));
        let after = &self.last;
        if before.force == 0.0 && after.force > 0.0 {
            let part = before.penetration / (before.penetration - after.penetration);
            self.first_contact.get_or_insert(time + part * step);
            self.contacts += u64::from(self.in_window);
        }
        if !self.in_window {
            return;
        }
        for (peak, (from, to)) in
            self.peaks.iter_mut().zip(before.quantities.into_iter().zip(after.quantities))
        {
            *peak = peak.max(from[0].abs()).max(to[0].abs());
            if (from[1] > 0.0) != (to[1] > 0.0) {
                let cubic = Cubic::new(from[0], from[1], to[0], to[1], step);
                *peak = peak.max(cubic.largest()).max(-cubic.smallest());
            }
        }
        let [from, to] = [before.quantities[VOLTAGE], after.quantities[VOLTAGE]];
        let square = |[value, rate]: [f64; 2]| [value * value, 2.0 * value * rate];
        self.voltage += integral(from, to, step);
        self.voltage_squared += integral(square(from), square(to), step);
        // The trapezium: the force has a corner where the contact opens.
        self.impulse += 0.5 * step * (before.force + after.force);
        self.peak_force = self.peak_force.max(before.force).max(after.force);
        let ends_in_contact = u32::from(before.force > 0.0) + u32::from(after.force > 0.0);
        self.contact_time += 0.5 * step * f64::from(ends_in_contact);
    }

    /// The outcome at the end of the run, but for the method, its work and its trace.
    pub(super) fn close(self, scene: &Scene, has_stop: bool, end: &State) -> Outcome {
        let length = scene.run.window_s();
        let periods = scene.excitation.single_frequency().map(|frequency| frequency * length);
        let [beam_natural_frequencies_hz, rod_natural_frequencies_hz] = self.system.natural_frequencies_hz();
        let delivered_energy = self.voltage_squared * self.system.conductance;
        Outcome {
            scene: scene.name(),
            precision: "f64",
            math: "std",
            duration_s: scene.run.duration_s,
            settle_s: scene.run.settle_s,
            mean_power_w: Some(delivered_energy / length),
            rms_voltage_v: Some((self.voltage_squared.max(0.0) / length).sqrt()),
            peak_voltage_v: Some(self.peaks[VOLTAGE]),
            mean_voltage_v: Some(self.voltage / length),
            delivered_energy_j: Some(delivered_energy),
            base_rms_m_per_s2: scene.excitation.random().map(Random::rms_m_per_s2),
            particular: Particular::BumpStop(BumpStopOutcome {
                beam_natural_frequencies_hz,
                rod_natural_frequencies_hz,
                peak_tip_displacement_m: Some(self.peaks[TIP]),
                peak_stop_point_displacement_m: has_stop.then_some(self.peaks[STOP_POINT]),
                contacts: self.contacts,
                contacts_per_period: periods.map(|periods| self.contacts as f64 / periods),
                contact_fraction: Some(self.contact_time / length),
                first_contact_s: self.first_contact,
                peak_force_n: has_stop.then_some(self.peak_force),
                mean_force_n: has_stop.then_some(self.impulse / length),
                clamp: None,
                end_state: self.system.scaled(end),
            }),
            // These methods keep no energy ledger.
            ..Outcome::default()
        }
    }
}

//! The bump-stop harvester: displacements and velocities of the modes of beam and rod.
//!
//! Mak, McWilliam, Popov and Fox, IMAC-XXVIII (2010), equations (1) to (4) and (10), with the contact as a spring whose
//! compliance is that of the modes left out. The branch says whether the contact is closed.

use harvester_scene::scene_file::modes::BumpStopModes;
use harvester_scene::scene_file::{BumpStop as Model, Coupling};

use super::{Base, NEVER};
use crate::Stop;
use crate::load::{After, Port, Transducer};

/// A mode of beam or rod, with a modal mass of one.
#[derive(Debug, Clone, Copy, Default)]
struct Mode {
    stiffness: f64,
    damping: f64,
    base: f64,
    /// Shape at the stop, or minus that at the rod's face.
    lever: f64,
    coupling: f64,
}

/// With `MODES` modes of beam and rod.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BumpStop<const MODES: usize> {
    base: Base,
    modes: [Mode; MODES],
    gap: f64,
    /// Of the contact, in N/m.
    stiffness: f64,
    capacitance: f64,
    /// 1 if the voltage acts back on the beam, else 0.
    back: f64,
}

impl<const MODES: usize> BumpStop<MODES> {
    /// The equations of a scene with so many modes; `None` for another number of them, and without a stop.
    pub(crate) fn new(model: &Model, base: Base) -> Option<Self> {
        let stop = model.stop.as_ref()?;
        let from = BumpStopModes::new(&model.parameters, Some(stop));
        let mode = |angular_frequency: f64, base: f64, lever: f64, coupling: f64| Mode {
            stiffness: angular_frequency * angular_frequency,
            damping: 2.0 * model.parameters.damping_ratio * angular_frequency,
            base,
            lever,
            coupling,
        };
        let beam =
            from.beam.iter().map(|m| mode(m.angular_frequency, m.participation, m.at_stop, m.coupling));
        let rod = from.rod.iter().map(|m| mode(m.angular_frequency, m.participation, -m.at_face, 0.0));
        let modes: Vec<Mode> = beam.chain(rod).collect();
        Some(Self {
            base,
            modes: modes.try_into().ok()?,
            gap: stop.gap_m,
            stiffness: (from.beam_residual + from.rod_residual + stop.contact_compliance_m_per_n).recip(),
            capacitance: from.capacitance,
            back: if model.parameters.coupling == Coupling::TwoWay { 1.0 } else { 0.0 },
        })
    }

    #[inline]
    fn levers(&self, motion: &[f64]) -> f64 {
        self.modes.iter().zip(motion.chunks_exact(2)).map(|(mode, at)| mode.lever * at[0]).sum()
    }

    #[inline]
    fn current(&self, motion: &[f64]) -> f64 {
        self.modes.iter().zip(motion.chunks_exact(2)).map(|(mode, at)| mode.coupling * at[1]).sum()
    }

    /// The linear part of the rates: everything but base and gap.
    #[inline]
    fn linear(&self, motion: &[f64], voltage: f64, force: f64, rates: &mut [f64]) {
        let back = self.back * voltage;
        let places = motion.chunks_exact(2).zip(rates.chunks_exact_mut(2));
        for (mode, (at, rate)) in self.modes.iter().zip(places) {
            rate[0] = at[1];
            rate[1] =
                -mode.stiffness * at[0] - mode.damping * at[1] - mode.lever * force - mode.coupling * back;
        }
    }
}

impl<const MODES: usize> Transducer for BumpStop<MODES> {
    type Branch = bool;
    const GUARDS: usize = 1;

    fn base(&self) -> &Base {
        &self.base
    }

    fn start(&self, motion: &mut [f64]) -> After<bool> {
        After::On(self.levers(motion) >= self.gap)
    }

    fn released(&self, _: f64, _: &[f64], _: f64) -> bool {
        false
    }

    /// Of each mode as if it followed the base alone, at resonance; of the charge as if the first mode moved so.
    fn sizes(&self, motion: &mut [f64]) -> [f64; 2] {
        let mut charge: f64 = 0.0;
        for (mode, size) in self.modes.iter().zip(motion.chunks_exact_mut(2)) {
            let rate = self.base.amplitude * mode.base.abs() / mode.damping;
            (size[0], size[1]) = (rate / mode.stiffness.sqrt(), rate);
            charge = charge.max(mode.coupling.abs() * size[0]);
        }
        [charge, self.capacitance]
    }

    #[inline]
    fn flow(&self, closed: bool, base: f64, motion: &[f64], voltage: f64, rates: &mut [f64]) -> Port {
        let force = if closed { self.stiffness * (self.levers(motion) - self.gap) } else { 0.0 };
        self.linear(motion, voltage, force, rates);
        for (mode, rate) in self.modes.iter().zip(rates.chunks_exact_mut(2)) {
            rate[1] -= mode.base * base;
        }
        Port { driven: self.current(motion), capacitance: self.capacitance }
    }

    #[inline]
    fn port(&self, _: bool, motion: &[f64], _: f64) -> Port {
        Port { driven: self.current(motion), capacitance: self.capacitance }
    }

    #[inline]
    fn flow_along(
        &self,
        closed: bool,
        (motion, _): (&[f64], f64),
        (change, d_voltage): (&[f64], f64),
        rates: &mut [f64],
    ) -> [Port; 2] {
        let force = if closed { self.stiffness * self.levers(change) } else { 0.0 };
        self.linear(change, d_voltage, force, rates);
        [
            Port { driven: self.current(motion), capacitance: self.capacitance },
            Port { driven: self.current(change), capacitance: 0.0 },
        ]
    }

    #[inline]
    fn guards(&self, closed: bool, motion: &[f64]) -> [f64; 2] {
        let penetration = self.levers(motion) - self.gap;
        [if closed { penetration } else { -penetration }, NEVER]
    }

    fn jump(&self, _: usize, _: f64, closed: bool, _: &mut [f64], _: f64) -> After<bool> {
        After::On(!closed)
    }

    fn reserve(&self, _: f64, _: &[f64], _: f64) -> f64 {
        -1.0
    }

    fn check(&self, motion: &[f64]) -> Result<(), Stop> {
        if motion.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(Stop::OutOfRange) }
    }
}

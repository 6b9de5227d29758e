//! The reference for the sliding harvester: slip in either direction, and stick.
//!
//! In one slip the direction of the friction and the side of the middle are fixed, so the equations are smooth.

mod physics;

use std::f64::consts::TAU;

use super::ledger::{Integrals, integral};
use super::triboelectric::{
    Branch, CircuitKind, Counts, Dense, ElectricalPort, Guards, Harvester, Jump, LoadCircuit, Mode, Motion,
    Sample, Scales,
};
use harvester_scene::outcome::{Particular, SLIDING_COLUMNS, SlidingOutcome, with_store};
use harvester_scene::root::far_side;
use harvester_scene::scene_file::ForceLaw;

pub(super) use physics::Physics as Sliding;

impl Harvester for Sliding {
    type Guards = SlipGuards;

    const POSITION: &'static str = "displacement";
    const COLUMNS: &'static [&'static str; 8] = &with_store(SLIDING_COLUMNS);
    /// A slider that is caught where the overlap ends is slowed to less than that.
    const LEAST_PROGRESS: f64 = 1e-6;

    fn load(&self) -> &LoadCircuit {
        &self.load
    }

    fn scales(&self, start: &Motion) -> Scales {
        let velocity = self.radius * self.beam.angular_frequency;
        let energy = self.beam.modal_mass * velocity * velocity;
        Scales {
            position: self.radius,
            velocity,
            voltage: self.voltage_scale(start),
            time: 1.0 / self.beam.angular_frequency,
            energy,
            surface_energy: energy,
            charge: self.tribo_charge,
        }
    }

    /// Equations (2) and (5).
    fn acceleration(&self, motion: &Motion, base: f64) -> f64 {
        let damper = 2.0 * self.damping_ratio * self.beam.angular_frequency * motion.velocity;
        let force = self.holding_friction(motion, base) + self.friction(motion, &self.overlap(motion));
        -damper - force / self.beam.modal_mass
    }

    fn acceleration_along(&self, motion: &Motion, change: &Motion) -> f64 {
        let overlap = self.overlap(motion);
        let omega = self.beam.angular_frequency;
        let force = self.friction_along(motion, &overlap, change)
            - self.lateral_force_along(motion, &overlap, change);
        -2.0 * self.damping_ratio * omega * change.velocity
            - omega * omega * change.position
            - force / self.beam.modal_mass
    }

    /// Equation (13).
    fn voltage_rate(&self, motion: &Motion, base: f64) -> f64 {
        let (overlap, velocity) = (self.overlap(motion), motion.velocity);
        match self.load.kind {
            CircuitKind::QuasiStatic => {
                let acceleration = self.acceleration(motion, base);
                -self.load.resistance
                    * self.tribo_charge
                    * (overlap.curvature * velocity * velocity + overlap.slope * acceleration)
            }
            CircuitKind::Dynamic | CircuitKind::Open => {
                let voltage = self.electrostatic_voltage(motion, &overlap);
                let current = voltage * self.load.conductance;
                (-overlap.slope * velocity * self.total_charge(voltage) - current)
                    / (self.capacitance * overlap.active)
            }
        }
    }

    fn voltage_rate_along(&self, motion: &Motion, change: &Motion) -> f64 {
        let (overlap, c, velocity) = (self.overlap(motion), self.capacitance, motion.velocity);
        let total = self.total_charge(motion.voltage);
        let covered = overlap.slope * change.position;
        (-(overlap.curvature * change.position) * velocity * total
            - overlap.slope * change.velocity * total
            - (overlap.slope * velocity * c + self.load.conductance) * change.voltage)
            / (c * overlap.active)
            - self.voltage_rate(motion, 0.0) * covered / overlap.active
    }

    fn powers(&self, motion: &Motion, base: f64) -> [f64; 4] {
        let overlap = self.overlap(motion);
        let (beam, velocity) = (&self.beam, motion.velocity);
        let damper = 2.0 * self.damping_ratio * beam.angular_frequency * beam.modal_mass * velocity;
        [
            -beam.participation * beam.modal_mass * base * velocity,
            damper * velocity,
            self.friction(motion, &overlap) * velocity,
            self.field_force(motion, &overlap) * velocity,
        ]
    }

    /// Energy of mass and spring, and that of the field in the overlap beyond that of the short circuit.
    fn energies(&self, motion: &Motion) -> [f64; 2] {
        let speed_like = self.beam.angular_frequency * motion.position;
        let overlap = self.overlap(motion);
        let voltage = self.electrostatic_voltage(motion, &overlap);
        [
            0.5 * self.beam.modal_mass * (motion.velocity * motion.velocity + speed_like * speed_like),
            0.5 * self.capacitance * overlap.active * voltage * voltage,
        ]
    }

    /// The lateral force works where it acts; normal forces do not work.
    fn mechanical_work(&self, total: &Integrals) -> f64 {
        let lateral = if self.lateral_force { total[integral::FIELD_WORK] } else { 0.0 };
        total[integral::BASE_WORK] - total[integral::DAMPING] - total[integral::SURFACE_WORK] + lateral
    }

    fn created_energy(&self, total: &Integrals) -> f64 {
        if self.lateral_force { 0.0 } else { -total[integral::FIELD_WORK] }
    }

    fn conserves_energy(&self) -> bool {
        self.force_law == ForceLaw::GapField && self.lateral_force
    }

    fn is_in_range(&self, motion: &Motion) -> bool {
        motion.position.is_finite() && motion.velocity.is_finite() && motion.voltage.is_finite()
    }

    fn voltage(&self, motion: &Motion) -> f64 {
        self.voltage_at(motion, &self.overlap(motion))
    }

    fn charge(&self, motion: &Motion) -> f64 {
        self.charge_at(motion, &self.overlap(motion))
    }

    /// `C = c s1` and `j = −(ds1/dx) v (σS + c V)`.
    fn port(&self, motion: &Motion) -> ElectricalPort {
        let overlap = self.overlap(motion);
        ElectricalPort {
            voltage: motion.voltage,
            driven: -overlap.slope * motion.velocity * self.total_charge(motion.voltage),
            capacitance: self.capacitance * overlap.active,
        }
    }

    fn port_along(&self, motion: &Motion, change: &Motion) -> [f64; 2] {
        let (overlap, c) = (self.overlap(motion), self.capacitance);
        let total = self.total_charge(motion.voltage);
        let driven = -(overlap.curvature * change.position * motion.velocity * total
            + overlap.slope * change.velocity * total
            + overlap.slope * motion.velocity * c * change.voltage);
        [driven, c * overlap.slope * change.position]
    }

    fn time_constant(&self, motion: &Motion) -> f64 {
        self.load.resistance * self.capacitance * self.overlap(motion).active
    }

    fn start(&self, motion: &mut Motion, base: f64) -> Mode {
        if motion.velocity == 0.0 {
            return self.stop(motion, base);
        }
        self.slip(motion, motion.velocity.signum());
        Mode::Flow
    }

    fn guards(&self, start: &Motion) -> SlipGuards {
        let scale = [self.radius, self.radius * self.beam.angular_frequency];
        SlipGuards::new(start, self.radius, scale.map(|size| 64.0 * f64::EPSILON * size))
    }

    fn jump(&self, event: SlipEvent, motion: &mut Motion, base: f64) -> Result<Jump, String> {
        match event {
            SlipEvent::Stop => Ok(Jump { mode: self.stop(motion, base), impact: None, counts: true }),
            SlipEvent::Middle => {
                motion.position = 0.0;
                motion.branch.side = -motion.branch.side;
                Ok(Jump { mode: Mode::Flow, impact: None, counts: false })
            }
            SlipEvent::End => Err(format!(
                "the slider left the active patch: displacement {:e} m, must stay below {:e} m (two patch radii) \
                 in magnitude",
                motion.position,
                2.0 * self.radius
            )),
        }
    }

    /// Static friction, equation (11), less what holds the slider.
    fn reserve(&self, motion: &Motion, base: f64) -> f64 {
        let overlap = self.overlap(motion);
        let most = self.static_friction.at(&overlap) * self.normal_force(motion, &overlap);
        most - self.holding_friction(motion, base).abs()
    }

    /// The slider slips where it is driven.
    fn release(&self, motion: &mut Motion, base: f64) {
        let needed = self.holding_friction(motion, base);
        self.slip(motion, if needed > 0.0 { -1.0 } else { 1.0 });
    }

    fn particular(&self, counts: &Counts) -> Particular {
        let Counts { highest, lowest, sticks, periods, .. } = *counts;
        Particular::Sliding(SlidingOutcome {
            natural_frequency_hz: Some(self.beam.angular_frequency / TAU),
            peak_displacement_m: Some(highest.max(-lowest)),
            amplitude_m: Some(0.5 * (highest - lowest)),
            stick_fraction: Some(counts.stick_fraction),
            sticks_per_period: periods.map(|periods| sticks as f64 / periods),
        })
    }
}

impl Sliding {
    /// A slider without velocity sticks if static friction can hold it; otherwise it slips where it is driven, equations (9) to (11).
    fn stop(&self, motion: &mut Motion, base: f64) -> Mode {
        motion.velocity = 0.0;
        if !self.is_frictionless() && self.reserve(motion, base) >= 0.0 {
            return Mode::Stick;
        }
        self.release(motion, base);
        Mode::Flow
    }

    /// Begins a slip in a direction. In the middle the overlap is taken on the side to which the slider goes.
    fn slip(&self, motion: &mut Motion, direction: f64) {
        if motion.position == 0.0 {
            motion.branch.side = direction;
        }
        motion.branch.direction = if self.is_frictionless() { 0.0 } else { direction };
    }
}

/// Part of two patch radii that a displacement must not reach. A ten-millionth before its end the overlap is
/// 4e-11 of a disc, and with it the time constant of the circuit: no device is left there, and no integrator can follow the rates.
const REACH: f64 = 1.0 - 1e-7;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SlipEvent {
    /// The velocity is zero.
    Stop,
    /// The slider passes the middle.
    Middle,
    /// The overlap ends, to [`REACH`].
    End,
}

/// The search for the end of a slip.
///
/// A slip begins without velocity after a stop, and in the middle after passing it: the search ignores an event
/// at the place where the slip began until the slider has left that place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SlipGuards {
    branch: Branch,
    /// Displacement in m at which the overlap ends.
    reach: f64,
    /// Displacement in m and velocity in m/s that count as zero at the start.
    clearance: [f64; 2],
    has_left_middle: bool,
    has_left_rest: bool,
}

impl SlipGuards {
    fn new(start: &Motion, radius: f64, clearance: [f64; 2]) -> Self {
        let reach = REACH * 2.0 * radius;
        let branch = start.branch;
        let mut guards = Self { branch, reach, clearance, has_left_middle: false, has_left_rest: false };
        guards.arm(start);
        guards
    }

    fn arm(&mut self, motion: &Motion) {
        let [displacement, velocity] = self.clearance;
        self.has_left_middle |= self.branch.side * motion.position > displacement;
        self.has_left_rest |= self.branch.direction * motion.velocity > velocity;
    }
}

impl Guards for SlipGuards {
    type Event = SlipEvent;

    /// Cuts at the changes of sign of the acceleration: the velocity is monotone in every piece.
    fn cuts(&self, acceleration: &Dense<'_, f64>, from: f64, to: f64) -> Vec<f64> {
        let middle = from + 0.5 * (to - from);
        let mut cuts = Vec::new();
        for [left, right] in [[from, middle], [middle, to]] {
            if (acceleration(left) > 0.0) != (acceleration(right) > 0.0) {
                cuts.push(far_side(acceleration, left, right));
            }
            cuts.push(right);
        }
        cuts
    }

    fn event(
        &mut self,
        motion: &Dense<'_, Motion>,
        (begin, _): Sample,
        (end, after): Sample,
    ) -> Option<(f64, SlipEvent)> {
        let ([displacement, velocity], reach) = (self.clearance, self.reach);
        let Branch { direction, side } = self.branch;
        let crossing = |value: &dyn Fn(&Motion) -> f64| far_side(|t| value(&motion(t)), begin, end);
        let away = side * after.position;
        let place = if away >= reach {
            Some((crossing(&|motion| side * motion.position - reach), SlipEvent::End))
        } else if self.has_left_middle && away <= 0.0 {
            Some((crossing(&|motion| side * motion.position), SlipEvent::Middle))
        } else {
            // A slider that left to the other side has passed the middle.
            (!self.has_left_middle && away < -displacement).then_some((end, SlipEvent::Middle))
        };
        let onward = direction * after.velocity;
        let rest = if self.has_left_rest && onward <= 0.0 {
            Some((crossing(&|motion| direction * motion.velocity), SlipEvent::Stop))
        } else {
            // A slider that is driven back before it has begun to move has stopped.
            (!self.has_left_rest && onward < -velocity).then_some((end, SlipEvent::Stop))
        };
        self.arm(&after);
        match (place, rest) {
            (Some(place), Some(rest)) if rest.0 < place.0 => Some(rest),
            (place, rest) => place.or(rest),
        }
    }
}

#[cfg(test)]
mod tests;

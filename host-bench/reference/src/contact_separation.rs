//! The reference for the contact-separation harvester: flights, impacts and sticks.

mod physics;

use std::f64::consts::TAU;

use super::triboelectric::{
    CircuitKind, Counts, Dense, ElectricalPort, Guards, Harvester, Jump, LoadCircuit, Mode, Motion, Sample,
    Scales,
};
use harvester_scene::outcome::{
    CONTACT_SEPARATION_COLUMNS, ContactSeparationOutcome, Particular, with_store,
};
use harvester_scene::root::far_side;
use harvester_scene::scene_file::ForceLaw;

pub(super) use physics::Physics as ContactSeparation;

impl Harvester for ContactSeparation {
    type Guards = ImpactSearch;

    const POSITION: &'static str = "gap";
    const COLUMNS: &'static [&'static str; 8] = &with_store(CONTACT_SEPARATION_COLUMNS);
    const LEAST_PROGRESS: f64 = 1e-9;

    fn load(&self) -> &LoadCircuit {
        &self.load
    }

    fn scales(&self, start: &Motion) -> Scales {
        let position = self.initial_gap;
        let velocity = position * self.angular_frequency;
        let voltage = self.voltage_scale(start);
        let energy = self.mass * velocity * velocity;
        let typical = Motion { position, velocity, voltage, ..Motion::default() };
        let force = self.field_force(&typical).max(self.force(&typical)).max(1e-12 * energy / position);
        Scales {
            position,
            velocity,
            voltage,
            time: 1.0 / self.angular_frequency,
            energy,
            surface_energy: position * force,
            charge: self.tribo_charge,
        }
    }

    /// Equation (19).
    fn acceleration(&self, motion: &Motion, base: f64) -> f64 {
        let pull = self.damping * motion.velocity
            + self.stiffness * (motion.position - self.initial_gap)
            + self.force(motion);
        -pull / self.mass - base
    }

    fn acceleration_along(&self, motion: &Motion, change: &Motion) -> f64 {
        let pull = self.damping * change.velocity
            + self.stiffness * change.position
            + self.force_along(motion, change);
        -pull / self.mass
    }

    /// Equation (23).
    fn voltage_rate(&self, motion: &Motion, base: f64) -> f64 {
        let Motion { position: gap, velocity, voltage, .. } = *motion;
        let spacing = gap + self.dielectric;
        match self.load.kind {
            CircuitKind::Dynamic => {
                (self.top_charge(gap, voltage) * velocity - spacing * voltage * self.load.conductance)
                    / self.total_capacitance_length(gap)
            }
            CircuitKind::QuasiStatic => {
                self.load.resistance * self.tribo_charge * self.dielectric / (spacing * spacing)
                    * (self.acceleration(motion, base) - 2.0 * velocity * velocity / spacing)
            }
            CircuitKind::Open => {
                self.electrostatic_voltage_along(motion, &Motion { position: velocity, ..*motion })
            }
        }
    }

    fn voltage_rate_along(&self, motion: &Motion, change: &Motion) -> f64 {
        let Motion { position: gap, velocity, voltage, .. } = *motion;
        let spacing = gap + self.dielectric;
        let current = (change.position * voltage + spacing * change.voltage) * self.load.conductance;
        (self.top_charge_along(motion, change) * velocity + self.top_charge(gap, voltage) * change.velocity
            - current
            - self.voltage_rate(motion, 0.0) * self.parasitic * change.position)
            / self.total_capacitance_length(gap)
    }

    fn powers(&self, motion: &Motion, base: f64) -> [f64; 4] {
        let velocity = motion.velocity;
        [
            -self.mass * base * velocity,
            self.damping * velocity * velocity,
            self.force(motion) * velocity,
            -self.field_force(motion) * velocity,
        ]
    }

    fn energies(&self, motion: &Motion) -> [f64; 2] {
        [self.mechanical_energy(motion), self.electrical_energy(motion)]
    }

    fn conserves_energy(&self) -> bool {
        self.force_law == ForceLaw::GapField
    }

    fn is_in_range(&self, motion: &Motion) -> bool {
        motion.position.is_finite() && motion.position > -self.dielectric
    }

    fn voltage(&self, motion: &Motion) -> f64 {
        match self.load.kind {
            CircuitKind::QuasiStatic => {
                let spacing = motion.position + self.dielectric;
                self.load.resistance * self.tribo_charge * self.dielectric * motion.velocity
                    / (spacing * spacing)
            }
            CircuitKind::Dynamic | CircuitKind::Open => self.electrostatic_voltage(motion),
        }
    }

    fn charge(&self, motion: &Motion) -> f64 {
        self.charge_at_voltage(motion.position, self.electrostatic_voltage(motion))
    }

    /// `C = c / (g + d_e) + C_p` and `j = (σS − q) v / (g + d_e)`.
    fn port(&self, motion: &Motion) -> ElectricalPort {
        let spacing = motion.position + self.dielectric;
        ElectricalPort {
            voltage: motion.voltage,
            driven: self.top_charge(motion.position, motion.voltage) * motion.velocity / spacing,
            capacitance: self.total_capacitance_length(motion.position) / spacing,
        }
    }

    fn port_along(&self, motion: &Motion, change: &Motion) -> [f64; 2] {
        let spacing = motion.position + self.dielectric;
        let port = self.port(motion);
        let top = self.top_charge(motion.position, motion.voltage);
        let driven = (self.top_charge_along(motion, change) * motion.velocity + top * change.velocity
            - port.driven * change.position)
            / spacing;
        [driven, (self.parasitic - port.capacitance) * change.position / spacing]
    }

    fn time_constant(&self, _: &Motion) -> f64 {
        self.load.resistance * self.closed_capacitance
    }

    fn start(&self, motion: &mut Motion, base: f64) -> Mode {
        let at_rest = motion.position == 0.0 && motion.velocity == 0.0;
        if at_rest && self.reserve(motion, base) > 0.0 { Mode::Stick } else { Mode::Flow }
    }

    fn guards(&self, start: &Motion) -> ImpactSearch {
        ImpactSearch::new(start, 64.0 * f64::EPSILON * self.initial_gap)
    }

    /// `v⁺ = −e(|v⁻|) v⁻`, equation (21), charge and voltage continuous. The mass sticks where it would leave
    /// slower than the threshold although it is pressed down.
    fn jump(&self, _: Impact, motion: &mut Motion, base: f64) -> Result<Jump, String> {
        // Exactly on the dielectric, and not moving out of it by rounding.
        (motion.position, motion.velocity) = (0.0, motion.velocity.min(0.0));
        let speed = -motion.velocity;
        let before = self.mechanical_energy(motion);
        motion.velocity = self.restitution(speed) * speed;
        let sticks = motion.velocity < self.stick_speed && self.reserve(motion, base) > 0.0;
        if sticks {
            motion.velocity = 0.0;
        }
        let impact = Some([speed, before - self.mechanical_energy(motion)]);
        Ok(Jump { mode: if sticks { Mode::Stick } else { Mode::Flow }, impact, counts: true })
    }

    /// Contact force: the dielectric presses on the mass, equation (22).
    fn reserve(&self, motion: &Motion, base: f64) -> f64 {
        self.mass * base + self.force(motion) - self.stiffness * self.initial_gap
    }

    fn particular(&self, counts: &Counts) -> Particular {
        let Counts { impacts, periods, .. } = *counts;
        Particular::ContactSeparation(ContactSeparationOutcome {
            natural_frequency_hz: Some(self.angular_frequency / TAU),
            // An impact is located on its far side, one rounding below the closed gap.
            peak_gap_m: Some(counts.highest.max(0.0)),
            min_gap_m: Some(counts.lowest.max(0.0)),
            impacts,
            impacts_per_period: periods.map(|periods| impacts as f64 / periods),
            max_impact_speed_m_per_s: (impacts > 0).then_some(counts.impact_speed),
            first_impact_s: counts.first_impact,
            stuck_fraction: Some(counts.stick_fraction),
        })
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Impact;

/// The search for an impact.
///
/// A flight that starts at closed gap without velocity is a release: gap, velocity and acceleration are all
/// zero, so no impact is looked for until the mass has left.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImpactSearch {
    /// Gap in m that counts as closed at a release.
    clearance: f64,
    /// Whether the mass has left the dielectric.
    has_left: bool,
}

impl ImpactSearch {
    fn new(start: &Motion, clearance: f64) -> Self {
        Self { clearance, has_left: start.position > 0.0 || start.velocity != 0.0 }
    }
}

impl Guards for ImpactSearch {
    type Event = Impact;

    fn event(
        &mut self,
        motion: &Dense<'_, Motion>,
        (begin, before): Sample,
        (end, after): Sample,
    ) -> Option<(f64, Impact)> {
        if !self.has_left {
            self.has_left = after.velocity > 0.0 && after.position > self.clearance;
            let pressed_back = after.position < -self.clearance;
            return pressed_back.then_some((end, Impact));
        }
        if after.position > 0.0 || after.position >= before.position {
            return None;
        }
        if before.position <= 0.0 {
            return Some((begin, Impact));
        }
        Some((far_side(|t| motion(t).position, begin, end), Impact))
    }
}

#[cfg(test)]
mod tests;

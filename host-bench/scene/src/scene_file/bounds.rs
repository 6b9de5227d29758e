//! The values that each number of a scene file may have.

use std::fmt;

use super::scene::ContactSeparationParameters;

/// The values that a number may have, ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bound {
    pub(super) lowest: f64,
    pub(super) highest: f64,
    /// Whether 0 and infinity are allowed beside the range.
    pub(super) or_limits: bool,
}

impl Bound {
    /// From `lowest` to `highest`.
    pub(super) const fn new(lowest: f64, highest: f64) -> Self {
        Self { lowest, highest, or_limits: false }
    }

    /// Whether the value is allowed; not-a-number never is.
    pub(super) fn contains(&self, value: f64) -> bool {
        (self.lowest..=self.highest).contains(&value)
            || self.or_limits && (value == 0.0 || value == f64::INFINITY)
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { lowest, highest, or_limits } = self;
        let limits = if *or_limits { "0, inf, or " } else { "" };
        write!(f, "{limits}a number from {} to {}", Short(*lowest), Short(*highest))
    }
}

/// A number as short as it can be written exactly.
pub(super) struct Short(pub(super) f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (plain, scientific) = (self.0.to_string(), format!("{:e}", self.0));
        write!(f, "{}", if plain.len() <= scientific.len() { plain } else { scientific })
    }
}

/// The bound of a number of `[parameters]`, `[load]`, `[excitation]`, `[run]` or `[initial]`, by its key.
pub(super) fn of(key: &str) -> Bound {
    let [lowest, highest] = match key {
        "mass_kg" => [1e-12, 1e3],
        "stiffness_n_per_m" => [1e-9, 1e9],
        "damping_ratio" => [0.0, 10.0],
        "initial_gap_m" => [1e-9, 1.0],
        "electrode_area_m2" => [1e-12, 10.0],
        "dielectric_thickness_m" => [1e-9, 0.1],
        "relative_permittivity" => [1.0, 1e5],
        "charge_density_c_per_m2" => [0.0, 1e-2],
        "parasitic_capacitance_f" => [0.0, 1e-3],
        "beam_length_m" => [1e-4, 10.0],
        "beam_width_m" => [1e-5, 10.0],
        "beam_thickness_m" => [1e-7, 1.0],
        "young_modulus_pa" => [1e5, 1e13],
        "density_kg_per_m3" => [1.0, 1e5],
        "slider_mass_kg" => [1e-12, 1e3],
        "patch_radius_m" => [1e-6, 1.0],
        "static_friction_active"
        | "static_friction_inert"
        | "kinetic_friction_active"
        | "kinetic_friction_inert" => [0.0, 10.0],
        "coefficient" | "at_rest" | "at_speed" => [0.0, 1.0],
        "reference_speed_m_per_s" => [1e-9, 1e3],
        // A start inside the dielectric is refused.
        "gap_m" => [0.0, 1.0],
        // Twice the largest patch radius; what the scene's own radius allows is checked beside it.
        "displacement_m" => [-2.0, 2.0],
        "velocity_m_per_s" => [-1e3, 1e3],
        "charge_c" => [-1.0, 1.0],
        "resistance_ohm" => return Bound { lowest: 1e-9, highest: 1e30, or_limits: true },
        "capacitance_f" => [1e-12, 1e4],
        "diode_drop_v" => [0.0, 100.0],
        "leakage_ohm" => [1e-3, f64::INFINITY],
        "initial_v" | "turn_on_v" | "turn_off_v" => [0.0, 1e6],
        "voltage_v" => [0.0, 1e6],
        "draw.value of a resistor" => [1e-3, 1e15],
        "draw.value of a current" | "draw.value of a power" => [0.0, 1e3],
        // What the core's energy budget takes.
        "storage.capacitance_f" => [1e-9, 1e4],
        "storage.leakage_ohm" => [1.0, f64::INFINITY],
        "charging_efficiency" | "discharging_efficiency" => [0.01, 1.0],
        "highest_v" => [0.01, 1e3],
        "storage.initial_v" | "storage.turn_on_v" | "storage.turn_off_v" => [0.0, 1e3],
        "standing_power_w" => [0.0, 1e3],
        "time_constant_s" => [1.0, 1e9],
        "day_weight" => [1e-3, 1.0],
        "energy_j" => [1e-12, 1e3],
        "action.duration_s" => [0.0, 86_400.0],
        "every_s" => [1.0, 86_400.0],
        "hours" => [0.0, 1e3],
        "amplitude_m_per_s2" => [0.0, 1e5],
        "amplitude_g" => [0.0, 1e4],
        "frequency_hz" => [0.0, 1e6],
        "phase_rad" => [-1e3, 1e3],
        "rate_hz" => [1e-3, 1e6],
        "scale_m_per_s2" => [-1e6, 1e6],
        "duration_s" => [1e-6, 1e7],
        "settle_s" => [0.0, 1e7],
        "duration_periods" | "settle_periods" => [0.0, 1e12],
        // A key without a line here must not pass unchecked.
        _ => [f64::NAN, f64::NAN],
    };
    Bound::new(lowest, highest)
}

/// What the parameters of a contact-separation scene must keep together; each is within its own bound.
///
/// Returns the key to blame and the reason.
pub(super) fn together(parameters: &ContactSeparationParameters) -> Result<(), (&'static str, String)> {
    let angular = (parameters.stiffness_n_per_m / parameters.mass_kg).sqrt();
    let with = format!("mass_kg = {}", Short(parameters.mass_kg));
    natural_frequency(angular / std::f64::consts::TAU, &with).map_err(|reason| ("stiffness_n_per_m", reason))
}

/// Whether a natural frequency is one of a harvester; `with` names what makes it beside the key that is
/// blamed. Returns the reason.
pub(super) fn natural_frequency(frequency: f64, with: &str) -> Result<(), String> {
    let bound = Bound::new(1e-3, 1e4);
    if bound.contains(frequency) {
        Ok(())
    } else {
        Err(format!("the natural frequency with {with} is {frequency:.3e} Hz, must be {bound}"))
    }
}

//! The sliding cases.

use serde::{Serialize, Serializer};

use super::{Common, Setting, law, law_name};
use crate::scene_file::{Excitation, ForceLaw, GRAVITY, Load, Model, RunSpan, Scene, StickCharge, Tone};
use crate::stability::Grid;

/// Load resistances in Ω, both limits among them.
const RESISTANCES: [f64; 9] = [0.0, 1e-6, 1.0, 1e3, 1e6, 1e8, 1e10, 1e15, f64::INFINITY];
/// Tribo-charge densities in C/m²: from none to beyond what the field of the gap locks.
const DENSITIES: [f64; 4] = [0.0, 20e-6, 120e-6, 500e-6];
/// Coefficients of kinetic friction on the active patch.
const FRICTIONS: [f64; 4] = [0.0, 0.05, 0.3, 2.0];
/// The other coefficients of Table 1 over that one: kinetic on the inert patch, static on both.
const RATIOS: [f64; 3] = [2.0 / 3.0, 7.0 / 6.0, 5.0 / 6.0];
/// Amplitude in m/s² and frequency in Hz of the base: with long sticks, at resonance, to the edge of the
/// overlap, quasi-static, and fast.
const DRIVES: [[f64; 2]; 7] =
    [[3.0, 6.0], [3.5, 18.373], [4.6, 18.373], [30.0, 10.0], [30.0, 0.01], [60.0, 1e3], [300.0, 1e4]];
/// Seconds that a case runs at least, or two periods, and in periods at most.
const SPAN_S: [f64; 2] = [0.3, 3.3];

/// One case: what differs from the shipped scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct SlidingSetting {
    /// Load resistance in Ω.
    #[serde(serialize_with = "resistance")]
    pub(super) resistance_ohm: f64,
    /// Tribo-charge density in C/m².
    pub(super) charge_density_c_per_m2: f64,
    #[serde(serialize_with = "law")]
    pub(super) force_law: ForceLaw,
    /// Whether the charge relaxes in a stick.
    pub(super) relaxing: bool,
    /// Coefficient of kinetic friction on the active patch; the others are in the shipped scene's ratios.
    pub(super) friction: f64,
    /// Amplitude of the base's acceleration in m/s².
    pub(super) amplitude_m_per_s2: f64,
    /// Its frequency in Hz.
    pub(super) frequency_hz: f64,
}

/// JSON has no number for infinity.
fn resistance<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { serializer.serialize_f64(*value) } else { serializer.serialize_str("inf") }
}

impl SlidingSetting {
    /// Whole periods of the base that it is run, and after which it is measured: two of a slow one, 0.3 s of
    /// a fast one, 60 of those in between.
    fn periods(&self) -> [f64; 2] {
        let [short, long] = SPAN_S;
        let most = if self.frequency_hz > 100.0 { short } else { long };
        let whole = (most * self.frequency_hz).ceil().max(2.0);
        [whole, (whole * 0.6).floor().max(1.0)]
    }

    /// The coefficients of friction: kinetic on the active and inert patch, static on both.
    fn coefficients(&self) -> [f64; 4] {
        let [inert, at_rest, at_rest_inert] = RATIOS.map(|ratio| ratio * self.friction);
        [self.friction, inert, at_rest, at_rest_inert]
    }
}

impl Setting for SlidingSetting {
    const HEADING: &'static str = "Sliding";
    const SCENE: &'static str = "sliding";

    /// All, or of each list of numbers every other.
    fn all(grid: Grid) -> Vec<Self> {
        let stride = if grid == Grid::Whole { 1 } else { 2 };
        let mut settings = Vec::new();
        for resistance_ohm in RESISTANCES.into_iter().step_by(stride) {
            for charge_density_c_per_m2 in DENSITIES.into_iter().skip(stride - 1).step_by(stride) {
                for force_law in [ForceLaw::TransferredCharge, ForceLaw::GapField] {
                    for relaxing in [false, true].into_iter().take(3 - stride) {
                        for friction in FRICTIONS {
                            settings.extend(DRIVES.map(|[amplitude_m_per_s2, frequency_hz]| Self {
                                resistance_ohm,
                                charge_density_c_per_m2,
                                force_law,
                                relaxing,
                                friction,
                                amplitude_m_per_s2,
                                frequency_hz,
                            }));
                        }
                    }
                }
            }
        }
        settings
    }

    fn scene(&self, base: &Scene) -> Scene {
        let mut scene = base.clone();
        if let Model::Sliding(model) = &mut scene.model {
            let parameters = &mut model.parameters;
            parameters.charge_density_c_per_m2 = self.charge_density_c_per_m2;
            parameters.force_law = self.force_law;
            parameters.stick_charge = if self.relaxing { StickCharge::Relaxing } else { StickCharge::Frozen };
            [
                parameters.kinetic_friction_active,
                parameters.kinetic_friction_inert,
                parameters.static_friction_active,
                parameters.static_friction_inert,
            ] = self.coefficients();
        }
        scene.load = Load::Resistor { resistance_ohm: self.resistance_ohm };
        scene.excitation = Excitation::Sine(Tone {
            amplitude_m_per_s2: self.amplitude_m_per_s2,
            frequency_hz: self.frequency_hz,
            phase_rad: 0.0,
        });
        let [end, settle] = self.periods().map(|periods| periods / self.frequency_hz);
        scene.run = RunSpan { duration_s: end, settle_s: settle };
        scene
    }

    /// One charge density and the shipped scene's friction.
    fn is_for_reference(&self) -> bool {
        let [_, _, density, _] = DENSITIES;
        let [_, _, friction, _] = FRICTIONS;
        self.charge_density_c_per_m2 == density && self.friction == friction
    }

    fn overrides(&self) -> String {
        let [active, inert, at_rest, at_rest_inert] = self.coefficients();
        let [end, settle] = self.periods();
        format!(
            "--set load.resistance_ohm={:e} --set parameters.charge_density_c_per_m2={:e} \
             --set parameters.force_law={} --set parameters.stick_charge={} \
             --set parameters.kinetic_friction_active={active} --set parameters.kinetic_friction_inert={inert} \
             --set parameters.static_friction_active={at_rest} \
             --set parameters.static_friction_inert={at_rest_inert} --set excitation.amplitude_g={} \
             --set excitation.frequency_hz={} --set run.settle_periods={settle} \
             --set run.duration_periods={end}",
            self.resistance_ohm,
            self.charge_density_c_per_m2,
            law_name(self.force_law),
            if self.relaxing { "relaxing" } else { "frozen" },
            self.amplitude_m_per_s2 / GRAVITY,
            self.frequency_hz,
        )
    }

    fn common(&self) -> Common {
        let Self { resistance_ohm, charge_density_c_per_m2, force_law, .. } = *self;
        Common { resistance_ohm, charge_density_c_per_m2, force_law }
    }

    fn others(&self) -> String {
        format!(
            "mu = {}, {} m/s^2 at {} Hz, {}",
            self.friction,
            self.amplitude_m_per_s2,
            self.frequency_hz,
            if self.relaxing { "relaxing" } else { "frozen" }
        )
    }
}

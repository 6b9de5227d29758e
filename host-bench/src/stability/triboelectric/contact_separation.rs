//! The contact-separation cases.

use serde::Serialize;

use super::{Common, Setting, law, law_name};
use crate::scene_file::{ForceLaw, Load, Model, Restitution, RunSpan, Scene};
use crate::stability::Grid;

/// Periods of the excitation that a case runs.
const PERIODS: f64 = 60.0;
/// Periods after which it is measured.
const SETTLED: f64 = 40.0;

/// Tribo-charge densities in C/m²: from none to beyond pull-in.
const DENSITIES: [f64; 8] = [0.0, 5e-6, 20e-6, 50e-6, 80e-6, 100e-6, 150e-6, 300e-6];
/// Parasitic capacitances in F.
const PARASITICS: [f64; 3] = [0.0, 1e-12, 1e-9];
const RESTITUTIONS: [f64; 4] = [0.0, 0.5, 0.9, 0.99];
/// Exponents of ten of the load resistance in Ω.
const DECADES: std::ops::RangeInclusive<i32> = -3..=15;

/// One case: what differs from the shipped scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct ContactSeparationSetting {
    /// Load resistance in Ω.
    pub(super) resistance_ohm: f64,
    /// Tribo-charge density in C/m².
    pub(super) charge_density_c_per_m2: f64,
    #[serde(serialize_with = "law")]
    pub(super) force_law: ForceLaw,
    /// Parasitic capacitance in F.
    pub(super) parasitic_capacitance_f: f64,
    /// Coefficient of restitution, the same at every speed.
    pub(super) restitution: f64,
}

impl Setting for ContactSeparationSetting {
    const HEADING: &'static str = "Contact-separation";
    const SCENE: &'static str = "contact-separation";

    /// Every decade of the resistance, or every third.
    fn all(grid: Grid) -> Vec<Self> {
        let stride = if grid == Grid::Whole { 1 } else { 3 };
        let mut settings = Vec::new();
        for decade in DECADES.step_by(stride) {
            for charge_density_c_per_m2 in DENSITIES {
                for force_law in [ForceLaw::TransferredCharge, ForceLaw::GapField] {
                    for parasitic_capacitance_f in PARASITICS {
                        settings.extend(RESTITUTIONS.map(|restitution| Self {
                            resistance_ohm: 10f64.powi(decade),
                            charge_density_c_per_m2,
                            force_law,
                            parasitic_capacitance_f,
                            restitution,
                        }));
                    }
                }
            }
        }
        settings
    }

    /// The parameters of this case, for 60 periods of the sine, of which the last 20 are measured.
    fn scene(&self, base: &Scene) -> Scene {
        let mut scene = base.clone();
        if let Model::ContactSeparation(model) = &mut scene.model {
            model.parameters.charge_density_c_per_m2 = self.charge_density_c_per_m2;
            model.parameters.force_law = self.force_law;
            model.parameters.parasitic_capacitance_f = self.parasitic_capacitance_f;
            model.parameters.restitution = Restitution::Constant { coefficient: self.restitution };
        }
        scene.load = Load::Resistor { resistance_ohm: self.resistance_ohm };
        let period = base.excitation.single_frequency().map_or(0.05, f64::recip);
        scene.run = RunSpan { duration_s: PERIODS * period, settle_s: SETTLED * period };
        scene
    }

    /// One capacitance and one restitution of each charge density, resistance and law.
    fn is_for_reference(&self) -> bool {
        let [_, parasitic, _] = PARASITICS;
        let [_, restitution, ..] = RESTITUTIONS;
        self.parasitic_capacitance_f == parasitic && self.restitution == restitution
    }

    fn overrides(&self) -> String {
        format!(
            "--set load.resistance_ohm={:e} --set parameters.charge_density_c_per_m2={:e} \
             --set parameters.force_law={} --set parameters.parasitic_capacitance_f={:e} \
             --set 'parameters.restitution={{kind=\"constant\",coefficient={}}}' \
             --set run.settle_periods={SETTLED} --set run.duration_periods={PERIODS}",
            self.resistance_ohm,
            self.charge_density_c_per_m2,
            law_name(self.force_law),
            self.parasitic_capacitance_f,
            self.restitution,
        )
    }

    fn common(&self) -> Common {
        let Self { resistance_ohm, charge_density_c_per_m2, force_law, .. } = *self;
        Common { resistance_ohm, charge_density_c_per_m2, force_law }
    }

    fn others(&self) -> String {
        format!("Cp = {:e} F, e = {}", self.parasitic_capacitance_f, self.restitution)
    }
}

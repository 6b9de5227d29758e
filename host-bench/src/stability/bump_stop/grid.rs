//! The cases.

use serde::{Serialize, Serializer};

use crate::scene_file::{BumpStopStart, Contact, Load, Model, RunSpan, Scene};
use crate::stability::Grid;

/// Simulated time in s: two periods. The first contact comes before the end of the first.
const DURATION_S: f64 = 0.01;

const BEAM_MODES: std::ops::RangeInclusive<usize> = 1..=10;
const ROD_MODES: std::ops::RangeInclusive<usize> = 0..=10;
/// Gaps in m: from touching at rest to out of reach.
const GAPS: [f64; 6] = [0.0, 1e-7, 1e-6, 3e-5, 1e-4, 1e-2];
/// Load resistances in Ω.
const RESISTANCES: [f64; 5] = [0.0, 1.0, 1e3, 1e6, f64::INFINITY];
/// Young's moduli of the rod in Pa, over six decades.
const MODULI: [f64; 7] = [7e7, 7e8, 7e9, 7e10, 7e11, 7e12, 7e13];
const DAMPINGS: [f64; 6] = [0.0, 1e-3, 1e-2, 0.1, 0.3, 0.5];
/// Steps in s.
const STEPS: [f64; 6] = [1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3];
/// Those of the coarse grid.
const COARSE_STEPS: [f64; 3] = [1e-6, 1e-5, 1e-3];
/// Coefficient of restitution where impacts are rigid.
const RESTITUTION: f64 = 0.5;

/// One case: what differs from the shipped scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Setting {
    pub(super) beam_modes: usize,
    pub(super) rod_modes: usize,
    /// Gap in m.
    pub(super) gap_m: f64,
    /// Load resistance in Ω.
    pub(super) resistance_ohm: f64,
    /// Young's modulus of the rod in Pa.
    pub(super) rod_young_modulus_pa: f64,
    pub(super) damping_ratio: f64,
    #[serde(serialize_with = "law")]
    pub(super) contact: Contact,
}

fn law<S: Serializer>(contact: &Contact, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(law_name(*contact))
}

/// The name that a scene file has for a contact law.
pub(super) fn law_name(contact: Contact) -> &'static str {
    match contact {
        Contact::ResidualFlexibility => "residual-flexibility",
        Contact::Restitution => "restitution",
        Contact::DisplacementConstraint => "displacement-constraint",
    }
}

pub(super) const LAWS: [Contact; 3] =
    [Contact::ResidualFlexibility, Contact::Restitution, Contact::DisplacementConstraint];

impl Setting {
    /// Of the shipped scene, with a few modes.
    pub(super) fn middle(contact: Contact) -> Self {
        Self {
            beam_modes: 4,
            rod_modes: 1,
            gap_m: 1e-5,
            resistance_ohm: 1e6,
            rod_young_modulus_pa: 7e10,
            damping_ratio: 0.01,
            contact,
        }
    }

    /// The scene of this case: the bump-stop scene `base` with these parameters, from rest for 10 ms.
    pub(super) fn scene(&self, base: &Scene) -> Scene {
        let mut scene = base.clone();
        if let Model::BumpStop(model) = &mut scene.model {
            model.parameters.beam_modes = self.beam_modes;
            model.parameters.damping_ratio = self.damping_ratio;
            model.initial = BumpStopStart::at_rest(self.beam_modes, self.rod_modes);
            if let Some(stop) = &mut model.stop {
                stop.rod_modes = self.rod_modes;
                stop.gap_m = self.gap_m;
                stop.young_modulus_pa = self.rod_young_modulus_pa;
                stop.contact = self.contact;
                stop.restitution = (self.contact == Contact::Restitution).then_some(RESTITUTION);
            }
        }
        scene.load = Load::Resistor { resistance_ohm: self.resistance_ohm };
        scene.run = RunSpan { duration_s: DURATION_S, settle_s: 0.0 };
        scene
    }

    /// The options that make `run` run this case.
    pub(super) fn overrides(&self) -> String {
        let restitution = if self.contact == Contact::Restitution {
            format!(" --set stop.restitution={RESTITUTION}")
        } else {
            String::new()
        };
        format!(
            "--set parameters.beam_modes={} --set stop.rod_modes={} --set stop.gap_m={:e} --set \
             load.resistance_ohm={:e} --set stop.young_modulus_pa={:e} --set parameters.damping_ratio={:e} --set \
             stop.contact={}{restitution} --set run.duration_s={DURATION_S} --set run.settle_s=0",
            self.beam_modes,
            self.rod_modes,
            self.gap_m,
            self.resistance_ohm,
            self.rod_young_modulus_pa,
            self.damping_ratio,
            law_name(self.contact),
        )
    }
}

/// The cases: from the middle, one quantity at a time over its range.
pub(super) fn settings() -> Vec<Setting> {
    let mut settings = Vec::new();
    for contact in LAWS {
        let middle = Setting::middle(contact);
        settings.push(middle);
        settings.extend(BEAM_MODES.map(|beam_modes| Setting { beam_modes, ..middle }));
        settings.extend(ROD_MODES.map(|rod_modes| Setting { rod_modes, ..middle }));
        settings.push(Setting { beam_modes: 10, rod_modes: 10, ..middle });
        settings.extend(GAPS.map(|gap_m| Setting { gap_m, ..middle }));
        settings.extend(RESISTANCES.map(|resistance_ohm| Setting { resistance_ohm, ..middle }));
        settings.extend(MODULI.map(|rod_young_modulus_pa| Setting { rod_young_modulus_pa, ..middle }));
        settings.extend(DAMPINGS.map(|damping_ratio| Setting { damping_ratio, ..middle }));
    }
    let mut kept: Vec<Setting> = Vec::new();
    for setting in settings {
        // The range of each quantity contains the middle.
        if !kept.contains(&setting) {
            kept.push(setting);
        }
    }
    kept
}

/// The steps in s at which each case is run.
pub(super) fn steps(grid: Grid) -> &'static [f64] {
    match grid {
        Grid::Whole => &STEPS,
        Grid::Coarse => &COARSE_STEPS,
    }
}

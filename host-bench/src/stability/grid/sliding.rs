//! The sliding cases.

use super::{
    Extent, FORCE_LAWS, Kind, NO_FORCE, each_law, each_number, each_word, noise, shipped, start_charges,
    stores,
};
use crate::stability::Case;

/// Load resistances in Ω, both limits among them.
const RESISTANCES: [f64; 9] = [0.0, 1e-6, 1.0, 1e3, 1e6, 1e10, 1e8, 1e15, f64::INFINITY];
/// Tribo-charge densities in C/m²: from none to beyond what the field of the gap locks.
const DENSITIES: [f64; 4] = [20e-6, 0.0, 500e-6, 120e-6];
const STICK_CHARGES: [&str; 2] = ["frozen", "relaxing"];
/// Coefficients of kinetic friction on the active patch.
const FRICTIONS: [f64; 4] = [0.0, 0.05, 0.3, 2.0];
/// The other coefficients over that one: kinetic on the inert patch, static on the active and the inert one.
const RATIOS: [f64; 3] = [2.0 / 3.0, 7.0 / 6.0, 5.0 / 6.0];
/// Amplitude in m/s² and frequency in Hz of the base: with long sticks, at resonance, to the edge of the
/// overlap, quasi-static, and fast.
const DRIVES: [[f64; 2]; 7] =
    [[3.0, 6.0], [3.5, 18.373], [4.6, 18.373], [30.0, 10.0], [30.0, 0.01], [60.0, 1e3], [300.0, 1e4]];

pub(super) fn settings(extent: Extent) -> Vec<Case> {
    let mut settings = resistances(extent);
    settings.extend(forceless());
    settings.extend(small_motions());
    settings.extend(start_charges(&base()));
    settings.extend(storages());
    settings.extend(
        [1e3, 1e5].map(|rate_hz| noise(&base(), rate_hz, 20.0).with("run", "{duration_s=1.0,settle_s=0.5}")),
    );
    settings
}

fn base() -> Case {
    shipped(Kind::Sliding)
}

/// Whole periods of the base that a case runs and after which it is measured: the window has a whole number for each
/// of its parts, except for a base that is quasi-static.
fn periods(frequency_hz: f64) -> [u32; 2] {
    match frequency_hz {
        ..1.0 => [2, 1],
        ..100.0 => [36, 20],
        _ => [160, 96],
    }
}

fn driven(case: Case, [amplitude, frequency_hz]: [f64; 2]) -> Case {
    let [all, settle] = periods(frequency_hz);
    case.with_number("excitation.amplitude_m_per_s2", amplitude)
        .with_number("excitation.frequency_hz", frequency_hz)
        .with("run", format_args!("{{duration_periods={all},settle_periods={settle}}}"))
}

/// The case with this kinetic friction on the active patch; the other coefficients are in the ratios of the shipped scene.
fn rubbing(case: Case, friction: f64) -> Case {
    let [inert, at_rest, at_rest_inert] = RATIOS.map(|ratio| ratio * friction);
    case.with_number("parameters.kinetic_friction_active", friction)
        .with_number("parameters.kinetic_friction_inert", inert)
        .with_number("parameters.static_friction_active", at_rest)
        .with_number("parameters.static_friction_inert", at_rest_inert)
}

/// Load resistance against charge density, force law, stick charge, friction and base.
fn resistances(extent: Extent) -> Vec<Case> {
    let loads = each_number(&[base()], "load.resistance_ohm", &extent.thinned(&RESISTANCES, 2));
    let charged = each_number(&loads, "parameters.charge_density_c_per_m2", &extent.thinned(&DENSITIES, 2));
    let stick_charges = extent.thinned(&STICK_CHARGES, 2);
    let cases = each_word(&each_law(&charged), "parameters.stick_charge", &stick_charges);
    let rubbed = cases.into_iter().flat_map(|case| FRICTIONS.map(|friction| rubbing(case.clone(), friction)));
    rubbed.flat_map(|case| DRIVES.map(|drive| driven(case.clone(), drive))).collect()
}

/// Load resistance against base, without an electrostatic force.
fn forceless() -> Vec<Case> {
    let loads = each_number(&[base()], "load.resistance_ohm", &[1.0, 1e6, 1e8]);
    let cases = each_word(&loads, "parameters.force_law", &[NO_FORCE]).into_iter();
    let rubbed = cases.map(|case| rubbing(case, FRICTIONS[2]));
    rubbed.flat_map(|case| DRIVES.map(|drive| driven(case.clone(), drive))).collect()
}

/// Motions far below the radius of the patch, with little friction.
fn small_motions() -> Vec<Case> {
    let cases = each_law(&each_number(&[base()], "load.resistance_ohm", &[1e3, 1e6, 1e9])).into_iter();
    let rubbed = cases.flat_map(|case| [0.0, 1e-4].map(|friction| rubbing(case.clone(), friction)));
    rubbed.map(|case| driven(case, [0.00981, 5.0])).collect()
}

fn storages() -> Vec<Case> {
    let of = |law: &str, stick_charge: &str| {
        let case = base().with("parameters.force_law", law).with("parameters.stick_charge", stick_charge);
        stores(&case.with("run", "{duration_periods=36,settle_periods=20}"))
    };
    let [transferred, gap_field] = FORCE_LAWS;
    [of(transferred, "frozen"), of(transferred, "relaxing"), of(gap_field, "frozen")].concat()
}

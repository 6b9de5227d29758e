//! The contact-separation cases.

use super::{
    Extent, FORCE_LAWS, Kind, NO_FORCE, each_law, each_number, each_word, noise, shipped, start_charges,
    stores,
};
use crate::stability::Case;

/// Periods of the base that a case runs, and after which it is measured: sixteen are, one for each part of the window.
const PERIODS: [f64; 2] = [36.0, 20.0];

/// Tribo-charge densities in C/m²: from none to beyond pull-in.
const DENSITIES: [f64; 8] = [5e-6, 0.0, 50e-6, 20e-6, 100e-6, 80e-6, 300e-6, 150e-6];
/// Parasitic capacitances in F.
const PARASITICS: [f64; 3] = [0.0, 1e-12, 1e-9];
const RESTITUTIONS: [f64; 5] = [0.0, 0.5, 0.99, 0.9, 1.0];
/// Exponents of ten of the load resistance in Ω.
const DECADES: [i32; 19] = [-3, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
/// Frequencies of the base in Hz, and of the loads in Ω at which they are taken.
const FREQUENCIES: [f64; 8] = [1.0, 5.0, 20.0, 25.0, 40.0, 200.0, 1e3, 1e4];
/// The frequencies in Hz that are taken without an electrostatic force too.
const FORCELESS: [f64; 2] = [20.0, 200.0];
const LOADS: [f64; 7] = [0.0, 1.0, 1e3, 1e6, 1e8, 1e10, f64::INFINITY];

pub(super) fn settings(extent: Extent) -> Vec<Case> {
    let mut settings = resistances(extent);
    settings.extend(frequencies());
    settings.extend(small_motions());
    settings.extend(start_charges(&base()));
    settings.extend(storages());
    settings.extend([1e3, 1e4, 1e5].map(|rate_hz| over(noise(&base(), rate_hz, 2.0), 1.0)));
    settings
}

fn base() -> Case {
    shipped(Kind::ContactSeparation)
}

fn periods(case: Case) -> Case {
    let [all, settle] = PERIODS;
    case.with("run", format_args!("{{duration_periods={all},settle_periods={settle}}}"))
}

/// The case for a number of seconds, of which the last half is measured.
fn over(case: Case, duration_s: f64) -> Case {
    case.with("run", format_args!("{{duration_s={duration_s},settle_s={}}}", duration_s / 2.0))
}

/// Load resistance against charge density, force law, parasitic capacitance and restitution.
fn resistances(extent: Extent) -> Vec<Case> {
    let ohms: Vec<f64> = extent.thinned(&DECADES, 3).into_iter().map(|decade| 10_f64.powi(decade)).collect();
    let loads = each_number(&[base()], "load.resistance_ohm", &ohms);
    let charged = each_number(&loads, "parameters.charge_density_c_per_m2", &extent.thinned(&DENSITIES, 2));
    let parasitics = extent.thinned(&PARASITICS, 2);
    let cases = each_number(&each_law(&charged), "parameters.parasitic_capacitance_f", &parasitics);
    let constant = |coefficient: f64| format!("{{kind=\"constant\",coefficient={coefficient}}}");
    let restitutions: Vec<String> = extent.thinned(&RESTITUTIONS, 2).into_iter().map(constant).collect();
    let restitutions: Vec<&str> = restitutions.iter().map(String::as_str).collect();
    each_word(&cases, "parameters.restitution", &restitutions).into_iter().map(periods).collect()
}

/// Load resistance against the frequency of the base, from slow to fast.
fn frequencies() -> Vec<Case> {
    let of = |frequency_hz: f64| {
        let loads = each_number(&[base()], "load.resistance_ohm", &LOADS);
        let cases = each_number(&loads, "excitation.frequency_hz", &[frequency_hz]);
        let without = FORCELESS.contains(&frequency_hz).then_some(NO_FORCE);
        let laws: Vec<&str> = FORCE_LAWS.into_iter().chain(without).collect();
        each_word(&cases, "parameters.force_law", &laws)
    };
    FREQUENCIES.into_iter().flat_map(of).map(periods).collect()
}

/// Motions far below the gap.
fn small_motions() -> Vec<Case> {
    let of = |(amplitude_g, frequency_hz)| {
        let moved = base()
            .with_number("excitation.amplitude_g", amplitude_g)
            .with_number("excitation.frequency_hz", frequency_hz);
        each_law(&each_number(&[moved], "load.resistance_ohm", &[1e3, 1e6, 1e8]))
    };
    [(1e-3, 5.0), (1e-3, 40.0), (1e-5, 20.0)].into_iter().flat_map(of).map(periods).collect()
}

fn storages() -> Vec<Case> {
    let laws = FORCE_LAWS.map(|law| periods(base().with("parameters.force_law", law)));
    let relaxing = laws[0].clone().with("parameters.stick_charge", "relaxing");
    laws.iter().chain([&relaxing]).flat_map(stores).collect()
}

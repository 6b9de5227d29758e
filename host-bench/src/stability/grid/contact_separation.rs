//! The contact-separation cases.

use super::{Extent, FORCE_LAWS, Kind, NO_FORCE, noise, shipped, start_charges, stores};
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
    let mut settings = Vec::new();
    for decade in extent.thinned(&DECADES, 3) {
        for density in extent.thinned(&DENSITIES, 2) {
            for law in FORCE_LAWS {
                for parasitic in extent.thinned(&PARASITICS, 2) {
                    for restitution in extent.thinned(&RESTITUTIONS, 2) {
                        let case = base()
                            .with_number("load.resistance_ohm", 10_f64.powi(decade))
                            .with_number("parameters.charge_density_c_per_m2", density)
                            .with("parameters.force_law", law)
                            .with_number("parameters.parasitic_capacitance_f", parasitic)
                            .with(
                                "parameters.restitution",
                                format_args!("{{kind=\"constant\",coefficient={restitution}}}"),
                            );
                        settings.push(periods(case));
                    }
                }
            }
        }
    }
    settings
}

/// Load resistance against the frequency of the base, from slow to fast.
fn frequencies() -> Vec<Case> {
    let mut settings = Vec::new();
    for frequency_hz in FREQUENCIES {
        for resistance_ohm in LOADS {
            let without = FORCELESS.contains(&frequency_hz).then_some(NO_FORCE);
            for law in FORCE_LAWS.into_iter().chain(without) {
                let case = base()
                    .with_number("load.resistance_ohm", resistance_ohm)
                    .with_number("excitation.frequency_hz", frequency_hz)
                    .with("parameters.force_law", law);
                settings.push(periods(case));
            }
        }
    }
    settings
}

/// Motions far below the gap.
fn small_motions() -> Vec<Case> {
    let mut settings = Vec::new();
    for (amplitude_g, frequency_hz) in [(1e-3, 5.0), (1e-3, 40.0), (1e-5, 20.0)] {
        for resistance_ohm in [1e3, 1e6, 1e8] {
            for law in FORCE_LAWS {
                let case = base()
                    .with_number("excitation.amplitude_g", amplitude_g)
                    .with_number("excitation.frequency_hz", frequency_hz)
                    .with_number("load.resistance_ohm", resistance_ohm)
                    .with("parameters.force_law", law);
                settings.push(periods(case));
            }
        }
    }
    settings
}

fn storages() -> Vec<Case> {
    let laws = FORCE_LAWS.map(|law| periods(base().with("parameters.force_law", law)));
    let relaxing = laws[0].clone().with("parameters.stick_charge", "relaxing");
    laws.iter().chain([&relaxing]).flat_map(stores).collect()
}

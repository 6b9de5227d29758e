//! Rows, errors and columns of the triboelectric scenes.

use std::f64::consts::{PI, TAU};

use model_core::clock::LONGEST_STEP_S;
use model_core::part::VACUUM_PERMITTIVITY;
use serde_json::Value;

use super::table::{WORK, error, resistance, shown};
use super::{Comparison, Control, Errors, Extent, Kind, Row, Variant, relative};
use crate::method::{Math, Method, Precision};
use crate::outcome::{Outcome, name};
use crate::rows::{Column, Digits};
use crate::scene_file::{ContactSeparation, Scene};

/// Name of the error by which rows are compared.
pub(crate) const MEAN_POWER: &str = "mean_power_error";
const RMS_VOLTAGE: &str = "rms_voltage_error";
const FIRST_IMPACT: &str = "first_impact_error";
const AMPLITUDE: &str = "amplitude_error";

pub(super) const KIND: Kind = Kind {
    variants,
    errors,
    target: (MEAN_POWER, 1e-3),
    lists_reference: true,
    columns: &COLUMNS,
    csv: CSV,
    cells,
    words: 4,
    title,
    notes,
    label: |variant| format!("{}, {}, {}", method_name(variant), name(&variant.precision), variant.control),
    summary,
};

const COLUMNS: [Column<'_>; 12] = {
    let [steps, time, spread, ratio, residual] = WORK;
    [
        ("method", "method", Digits::Word),
        ("precision", "precision", Digits::Word),
        ("math", "math", Digits::Word),
        ("step or tolerance", "step_or_tolerance", Digits::Word),
        error("error of mean power", MEAN_POWER),
        error("of RMS voltage", RMS_VOLTAGE),
        error("of first impact or amplitude", "first_impact_or_amplitude"),
        steps,
        time,
        spread,
        ratio,
        residual,
    ]
};
const CSV: &str = "scene,resistance_ohm,method,precision,math,step_or_tolerance,mean_power_error,rms_voltage_error,\
    first_impact_error,amplitude_error,steps_per_s,ns_per_s,time_spread,time_ratio,energy_residual,runs,failure";

fn cells(table: &Comparison, row: &Row) -> Vec<(&'static str, Value)> {
    let math = row.variant.math.as_ref().map_or_else(|| "std".to_owned(), name);
    vec![
        ("scene", table.file().into()),
        ("resistance_ohm", table.scene.load.resistance_ohm().into()),
        ("method", method_name(&row.variant).into()),
        ("math", math.into()),
        ("step_or_tolerance", row.variant.control.to_string().into()),
        ("first_impact_or_amplitude", row.error(FIRST_IMPACT).or(row.error(AMPLITUDE)).into()),
    ]
}

fn first_impact(outcome: &Outcome) -> Option<f64> {
    outcome.contact_separation()?.first_impact_s
}

fn amplitude(outcome: &Outcome) -> Option<f64> {
    outcome.sliding()?.amplitude_m
}

fn errors(outcome: &Outcome, reference: &Outcome) -> Errors {
    Errors(vec![
        (MEAN_POWER, relative(outcome.mean_power_w, reference.mean_power_w)),
        (RMS_VOLTAGE, relative(outcome.rms_voltage_v, reference.rms_voltage_v)),
        (FIRST_IMPACT, relative(first_impact(outcome), first_impact(reference))),
        (AMPLITUDE, relative(amplitude(outcome), amplitude(reference))),
    ])
}

/// The name of the method: the name of the peer where the integrator of the reference runs at another tolerance.
pub(crate) fn method_name(variant: &Variant) -> &'static str {
    match (variant.method, variant.control) {
        (Method::Auto, Control::Default) => "auto",
        (Method::Auto | Method::ExponentialRadau, Control::PerPeriod { .. }) => {
            "exponential Radau, fixed step"
        }
        (Method::Auto | Method::ExponentialRadau, _) => "exponential Radau",
        (Method::TrBdf2, Control::PerPeriod { .. }) => "TR-BDF2, fixed step",
        (Method::TrBdf2, _) => "TR-BDF2",
        (Method::Rk4, _) => "RK4, fixed step",
        (Method::DiscreteGradient, _) => "discrete gradient",
        (Method::Newmark, _) => "Newmark",
        (Method::Reference, Control::Default) => "reference",
        (Method::Reference, _) => "Radau5 (std)",
    }
}

fn title(table: &Comparison) -> String {
    let reference = &table.reference;
    let motion = match amplitude(reference) {
        Some(amplitude) => format!("amplitude {}", shown(Some(amplitude), "m")),
        None => format!("first impact {}", shown(first_impact(reference), "s")),
    };
    format!(
        "{}, R = {}, {} s simulated; by the reference: mean power {}, RMS voltage {}, {motion}",
        table.file(),
        resistance(table.scene.load.resistance_ohm()),
        (table.scene.run.duration_s * 1e3).round() / 1e3,
        shown(reference.mean_power_w, "W"),
        shown(reference.rms_voltage_v, "V"),
    )
}

fn notes(table: &Comparison) -> Vec<String> {
    let runs = table.rows.iter().filter_map(|row| row.found.as_ref()).map(|found| found.runs);
    let mut notes = vec![format!(
        "T is the period of the excitation. Errors are relative to the reference; time ratio is to the fastest row whose error of mean power \
         is at most {:.0e}. Times are processor times, the least of up to {} runs without energy ledger; spread: the largest over it, less 1.",
        table.target_error(),
        runs.max().unwrap_or(0)
    )];
    notes.extend(table.reference.warnings.iter().map(|warning| format!("Warning: {warning}.")));
    notes
}

fn summary(table: &Comparison) -> Vec<(&'static str, Value)> {
    let reference = &table.reference;
    vec![
        ("file", table.file().into()),
        ("resistance_ohm", table.scene.load.resistance_ohm().into()),
        ("duration_s", table.scene.run.duration_s.into()),
        ("mean_power_w", reference.mean_power_w.into()),
        ("rms_voltage_v", reference.rms_voltage_v.into()),
        ("first_impact_s", first_impact(reference).into()),
        ("amplitude_m", amplitude(reference).into()),
    ]
}

/// Steps per period of the rows of TR-BDF2, in the polynomial backend.
const FIXED: [u32; 3] = [400, 800, 3200];
/// Tolerances of the rows of TR-BDF2.
const TOLERANCES: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5];
/// Steps per period of the rows of exponential Radau, in the polynomial backend.
const RADAU_FIXED: [u32; 4] = [16, 32, 64, 128];
/// Tolerances of the rows of exponential Radau.
const RADAU_TOLERANCES: [f64; 5] = [6e-2, 2e-2, 6e-3, 2e-3, 6e-4];
/// Tolerances of the peer.
const PEER: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-9];
/// Precisions and elementary functions of the core.
const BACKENDS: [(Precision, Math); 5] = [
    (Precision::F64, Math::Polynomial),
    (Precision::F32, Math::Polynomial),
    (Precision::F64, Math::Libm),
    (Precision::F32, Math::Libm),
    (Precision::F32, Math::Micromath),
];

pub(super) fn variants(scene: &Scene, extent: &Extent) -> Vec<Variant> {
    let period_s = period(scene);
    let explicit = explicit_steps(scene, period_s);
    let mut variants = Vec::new();
    for (precision, math) in BACKENDS.into_iter().take(extent.backends) {
        let variant = |method, control| Variant { method, precision, math: Some(math), control };
        let mut fixed = |method, steps: &[u32]| {
            // A longer step is refused.
            let steps = steps.iter().filter(|&&steps| period_s / f64::from(steps) <= LONGEST_STEP_S);
            variants.extend(steps.map(|&steps| variant(method, Control::PerPeriod { steps, period_s })));
        };
        if math == Math::Polynomial {
            fixed(Method::ExponentialRadau, &RADAU_FIXED);
            fixed(Method::TrBdf2, &FIXED);
        }
        if math == Math::Polynomial || extent.whole {
            fixed(Method::Rk4, &explicit);
        }
        for (method, tolerances) in
            [(Method::ExponentialRadau, &RADAU_TOLERANCES), (Method::TrBdf2, &TOLERANCES)]
        {
            variants.extend(tolerances.iter().map(|&value| variant(method, Control::Tolerance(value))));
        }
    }
    if !extent.whole {
        let auto =
            |precision| Variant { method: Method::Auto, precision, math: None, control: Control::Default };
        variants.extend([Precision::F64, Precision::F32].map(auto));
    }
    let peers = if extent.whole { &PEER[..] } else { &PEER[..2] };
    variants.extend(peers.iter().map(|&tolerance| Variant::reference(Control::Tolerance(tolerance))));
    variants
}

/// The period of the excitation in s, or of the free motion where the excitation has none.
pub(super) fn period(scene: &Scene) -> f64 {
    let natural = match scene.contact_separation() {
        Ok(model) => TAU * (model.parameters.mass_kg / model.parameters.stiffness_n_per_m).sqrt(),
        Err(_) => scene.sliding().map_or(1.0, |model| model.parameters.natural_frequency_hz().recip()),
    };
    scene.excitation.single_frequency().map_or(natural, f64::recip)
}

/// Steps per period of the explicit method where stability does not limit them, or no step is short enough.
const NOT_STIFF: [u32; 5] = [100, 200, 400, 800, 1600];
/// Most steps per period for which the explicit method is tried.
const MOST_EXPLICIT: f64 = 1e5;
/// Where the stability of the explicit method ends on the negative real axis.
const STABLE: f64 = 2.785;
/// Part of the active patch that a wide motion of the slider still covers, 1.4 radii off its middle.
const COVERED: f64 = 0.19;

/// The least capacitance in F in the course of the motion; `None` for a bump-stop scene, which has other rows.
fn least_capacitance(scene: &Scene) -> Option<f64> {
    if let Ok(ContactSeparation { parameters: from, .. }) = scene.contact_separation() {
        // The gap of a motion that touches the dielectric.
        let distance = 2.0 * from.initial_gap_m + from.dielectric_thickness_m / from.relative_permittivity;
        return Some(VACUUM_PERMITTIVITY * from.electrode_area_m2 / distance + from.parasitic_capacitance_f);
    }
    let from = &scene.sliding().ok()?.parameters;
    let area = PI * from.patch_radius_m * from.patch_radius_m;
    let distance = from.dielectric_thickness_m / from.relative_permittivity;
    Some(VACUUM_PERMITTIVITY * area * COVERED / distance)
}

/// The two of [`FIXED`] that the explicit method is run with too.
const COARSE: u32 = FIXED[1];
const FINE: u32 = FIXED[2];

/// Steps per period of the explicit method: two of TR-BDF2, which show where the explicit one is unstable;
/// and half, once and twice the number with which it is stable at the least capacitance.
fn explicit_steps(scene: &Scene, period_s: f64) -> Vec<u32> {
    let stable = least_capacitance(scene)
        .map(|capacitance| period_s / (STABLE * scene.load.resistance_ohm() * capacitance))
        .filter(|stable| (f64::from(COARSE)..MOST_EXPLICIT).contains(stable));
    let Some(stable) = stable else { return NOT_STIFF.to_vec() };
    let fine = (stable / 1000.0).ceil().max(1.0) * 1000.0;
    let fine = if fine < MOST_EXPLICIT { fine as u32 } else { FINE };
    vec![COARSE, FINE, fine / 2, fine, fine * 2]
}

//! Rows, errors and columns of the bump-stop scenes: the core's method at one step length and at two, in both
//! precisions, beside general methods on the host.

use serde_json::{Value, json};

use super::table::{WORK, error, grouped, microseconds, reason, shown};
use super::{Comparison, Control, Errors, Extent, Kind, Row, Variant, relative};
use crate::method::{Method, Precision};
use crate::outcome::{BumpStopOutcome, Outcome};
use crate::rows::{Column, Digits};
use crate::scene_file::{BumpStop, Scene};

/// Steps near contact in s that are tried.
const STEPS: [f64; 9] = [2e-5, 1e-5, 5e-6, 2e-6, 1e-6, 5e-7, 2.5e-7, 1e-7, 5e-8];
/// Those of the short table.
const FEW_STEPS: [f64; 4] = [5e-6, 1e-6, 2.5e-7, 5e-8];
/// Longest step in free flight of the rows with long steps, in s.
const LONG_STEP: f64 = 2e-5;
/// Fewest and most steps of a run: fewer do not resolve the motion, more take too long.
const STEP_COUNT: std::ops::RangeInclusive<f64> = 1e3..=3e6;

const END: &str = "end_error";
const FIRST_CONTACT: &str = "first_contact_error";
const RMS_VOLTAGE: &str = "rms_voltage_error";
const MEAN_FORCE: &str = "mean_force_error";

pub(super) const KIND: Kind = Kind {
    variants,
    errors,
    target: (RMS_VOLTAGE, 1e-2),
    lists_reference: false,
    columns: &COLUMNS,
    csv: CSV,
    cells,
    words: 2,
    title,
    notes: |table| vec![errors_note(table), fastest_note(table)],
    label: |variant| format!("{}, {}", method_name(variant), variant.control),
    summary,
};

const COLUMNS: [Column<'_>; 13] = {
    let [steps, time, spread, ratio, residual] = WORK;
    [
        ("method", "method_name", Digits::Word),
        ("precision", "precision", Digits::Word),
        ("step [us]", "step_us", Digits::Word),
        error("error at the end", END),
        error("of first contact", FIRST_CONTACT),
        error("of RMS voltage", RMS_VOLTAGE),
        error("of mean force", MEAN_FORCE),
        ("contacts", "contacts", Digits::Six),
        steps,
        time,
        spread,
        ratio,
        residual,
    ]
};
const CSV: &str = "scene,beam_modes,rod_modes,method,precision,step_s,long_step_s,end_error,first_contact_error,rms_voltage_error,\
    mean_force_error,contacts,steps_per_s,ns_per_s,time_spread,time_ratio,energy_residual,failure";

fn cells(table: &Comparison, row: &Row) -> Vec<(&'static str, Value)> {
    let ([beam, rod], [step_s, _]) = (modes(&table.scene), steps_of(&row.variant));
    vec![
        ("scene", table.file().into()),
        ("beam_modes", beam.into()),
        ("rod_modes", rod.into()),
        ("method_name", method_name(&row.variant).into()),
        ("step_us", step_s.map(microseconds).unwrap_or_default().to_string().into()),
        ("failure", row.failure.as_deref().map(reason).into()),
    ]
}

/// Modes of the beam and of the rod.
fn modes(scene: &Scene) -> [usize; 2] {
    scene.bump_stop().map_or([0; 2], BumpStop::modes)
}

/// Place in m of the stop from the clamp, and gap in m; `None` without a stop.
fn stop(scene: &Scene) -> Option<[f64; 2]> {
    scene.bump_stop().ok()?.stop.map(|stop| [stop.position_m, stop.gap_m])
}

/// Steps in s near contact and in free flight.
fn steps_of(variant: &Variant) -> [Option<f64>; 2] {
    match variant.control {
        Control::Step { step_s, long_step_s } => [Some(step_s), long_step_s],
        Control::PerPeriod { .. } | Control::Tolerance(_) | Control::Default => [None; 2],
    }
}

fn method_name(variant: &Variant) -> &'static str {
    match variant.method {
        Method::DiscreteGradient if steps_of(variant)[1].is_some() => "discrete gradient, two rates",
        Method::DiscreteGradient => "discrete gradient",
        Method::TrBdf2 => "TR-BDF2 (std)",
        Method::Newmark => "Newmark (std)",
        Method::Rk4 => "explicit RK4 (std)",
        Method::Auto | Method::ExponentialRadau | Method::Reference => "reference",
    }
}

fn variants(scene: &Scene, extent: &Extent) -> Vec<Variant> {
    let steps = if extent.whole { &STEPS[..] } else { &FEW_STEPS[..] };
    let resolves = |step: &f64| STEP_COUNT.contains(&(scene.run.duration_s / step));
    let steps: Vec<f64> = steps.iter().copied().filter(resolves).collect();
    let variant = |method, precision, step_s, long_step_s| Variant {
        method,
        precision,
        math: None,
        control: Control::Step { step_s, long_step_s },
    };
    let mut variants = Vec::new();
    for precision in [Precision::F64, Precision::F32] {
        for long in [None, Some(LONG_STEP)] {
            // Two equal steps are one, and in the table already.
            let steps = steps.iter().filter(|step| long.is_none_or(|long| **step < long));
            variants.extend(steps.map(|&step| variant(Method::DiscreteGradient, precision, step, long)));
        }
    }
    for method in [Method::TrBdf2, Method::Newmark, Method::Rk4] {
        variants.extend(steps.iter().map(|&step| variant(method, Precision::F64, step, None)));
    }
    variants
}

fn errors(outcome: &Outcome, reference: &Outcome) -> Errors {
    let particular = |value: fn(&BumpStopOutcome) -> Option<f64>| {
        relative(outcome.bump_stop().and_then(value), reference.bump_stop().and_then(value))
    };
    Errors(vec![
        (END, end_error(outcome, reference)),
        (FIRST_CONTACT, particular(|found| found.first_contact_s)),
        (RMS_VOLTAGE, relative(outcome.rms_voltage_v, reference.rms_voltage_v)),
        (MEAN_FORCE, particular(|found| found.mean_force_n)),
    ])
}

/// Error of the state at the end of the run in the energy norm, over the norm of the state itself.
fn end_error(outcome: &Outcome, reference: &Outcome) -> Option<f64> {
    let (found, exact) = (&outcome.bump_stop()?.end_state, &reference.bump_stop()?.end_state);
    let error: f64 = found.iter().zip(exact).map(|(found, exact)| (found - exact).powi(2)).sum();
    let whole: f64 = exact.iter().map(|entry| entry * entry).sum();
    Some(if whole > 0.0 { (error / whole).sqrt() } else { 0.0 })
}

/// Processor time of the reference in ns per simulated second, one run.
fn reference_ns_per_s(table: &Comparison) -> f64 {
    1e9 * table.reference.processor_s / table.scene.run.duration_s
}

fn title(table: &Comparison) -> String {
    let [beam, rod] = modes(&table.scene);
    let stop = stop(&table.scene).map_or_else(
        || "no stop".to_owned(),
        |[position, gap]| {
            let micrometres = (gap * 1e9).round() / 1e3;
            format!("stop at {} mm, gap {micrometres} um", (position * 1e6).round() / 1e3)
        },
    );
    let found = table.reference.bump_stop();
    format!(
        "{}, ({beam}, {rod}) modes, {stop}, {} s simulated, measured from {} s; by the reference: RMS voltage \
         {}, {} contacts, the first at {}, {} µs per simulated s",
        table.file(),
        table.scene.run.duration_s,
        table.scene.run.settle_s,
        shown(table.reference.rms_voltage_v, "V"),
        found.map_or(0, |found| found.contacts),
        shown(found.and_then(|found| found.first_contact_s), "s"),
        grouped(reference_ns_per_s(table) / 1e3),
    )
}

fn errors_note(table: &Comparison) -> String {
    format!(
        "Errors are relative to the reference; at the end: of the state, in the energy norm. Host time is the \
         processor time of stepping and of the meters shown, without energy ledger, the least of the runs; spread: the \
         largest over it, less 1; of the reference, one run. Two rates: {:.0} us in free flight. Time ratio \
         is to the fastest row whose error of RMS voltage is at most {:.0e}. Where the motion is chaotic only \
         statistics can agree.",
        LONG_STEP * 1e6,
        table.target_error()
    )
}

/// The fastest row of each method that reaches the target.
fn fastest_note(table: &Comparison) -> String {
    let methods = [Method::DiscreteGradient, Method::TrBdf2, Method::Newmark, Method::Rk4];
    let step_us = |row: &Row| 1e6 * steps_of(&row.variant)[0].unwrap_or(f64::NAN);
    table.fastest_note(methods, |row| format!("step {:.2} µs", step_us(row)))
}

fn summary(table: &Comparison) -> Vec<(&'static str, Value)> {
    let found = table.reference.bump_stop();
    vec![
        ("file", table.file().into()),
        ("modes", json!(modes(&table.scene))),
        ("stop_m", json!(stop(&table.scene))),
        ("duration_s", table.scene.run.duration_s.into()),
        ("settle_s", table.scene.run.settle_s.into()),
        ("rms_voltage_v", table.reference.rms_voltage_v.into()),
        ("contacts", found.map_or(0, |found| found.contacts).into()),
        ("first_contact_s", found.and_then(|found| found.first_contact_s).into()),
        ("reference_ns_per_s", reference_ns_per_s(table).into()),
    ]
}

#[cfg(test)]
mod tests;

//! What each part of a scene costs: the bench without it.

use firmware_example::variant::{Variant, named};
use firmware_example::workload::contact_separation::parts::CONSTANT;
use firmware_example::workload::run::Plan;
use firmware_example::workload::{bump_stop, contact_separation, sliding};

use super::output::Output;
use super::rows::{self, Case, RADAU, Steps};
use crate::on_target::{Bench, Error, accuracy};
use crate::scene_file::{
    BumpStop, ContactSeparationParameters, Coupling, ForceLaw, Load, Restitution, SlidingParameters,
};

/// The variants of a scene, the whole scene first.
type Variants = Vec<(Variant, Case)>;

/// Measures the variants of each scene and prints a table of each.
///
/// # Errors
///
/// If a firmware does not build or run, or computes other bits than the host.
pub(super) fn report(bench: &Bench, output: &mut Output) -> Result<(), Error> {
    table(bench, output, contact_separation()?, &contact_separation_note())?;
    table(bench, output, sliding()?, &sliding_note())?;
    table(bench, output, bump_stop()?, &bump_stop_note())
}

fn table(bench: &Bench, output: &mut Output, variants: Variants, note: &str) -> Result<(), Error> {
    let mut found = Vec::new();
    for (variant, case) in variants {
        found.extend(rows::measure(bench, &variant, vec![case])?);
    }
    let columns = [
        rows::NAME,
        rows::FLASH,
        rows::FLASH_DIFFERENCE,
        rows::STACK,
        rows::STEPS,
        rows::PER_STEP,
        rows::PER_SECOND,
        rows::ERROR,
    ];
    let note = format!(
        "{}. {note}
Error: against the independent reference of the same variant; without load there is none.
Instructions as QEMU executes them, which are not cycles. Flash and stack in bytes, flash over an empty firmware.",
        bench.core()
    );
    output.rows(&found, &columns, 1, &note);
    Ok(())
}

fn contact_separation() -> Result<Variants, Error> {
    use contact_separation::{FIXED_STEP, IMPACTING, TOLERANCE};
    type Change = fn(&mut ContactSeparationParameters);
    let case = |name, steps, change: Change| {
        let scene = accuracy::contact_separation(&IMPACTING, 0.0, change)?;
        Case::of_scene(name, &scene, RADAU, steps)
    };
    let (adaptive, fixed) = (Steps::Tolerance(TOLERANCE), Steps::Fixed(FIXED_STEP));
    let same: Change = |_| {};
    let no_parasitic: Change = |parameters| parameters.parasitic_capacitance_f = 0.0;
    let constant: Change = |parameters| {
        parameters.restitution = Restitution::Constant { coefficient: f64::from(CONSTANT.coefficient) };
    };
    let both: Change = |parameters| {
        parameters.parasitic_capacitance_f = 0.0;
        parameters.restitution = Restitution::Constant { coefficient: f64::from(CONSTANT.coefficient) };
    };
    Ok(vec![
        (const { named("contact_separation::bench") }, case("whole", adaptive, same)?),
        (
            const { named("contact_separation::without_parasitic") },
            case("without parasitic capacitance", adaptive, no_parasitic)?,
        ),
        (const { named("contact_separation::without_sticking") }, case("without sticking", adaptive, same)?),
        (
            const { named("contact_separation::without_law_of_speed") },
            case("with constant restitution", adaptive, constant)?,
        ),
        (
            const { named("contact_separation::without_error_control") },
            case("without error control", fixed, same)?,
        ),
        (const { named("contact_separation::without_any") }, case("without all of these", fixed, both)?),
    ])
}

fn sliding() -> Result<Variants, Error> {
    use sliding::{FIXED_STEP, GENTLE, IMPLICIT_STEP, MOVING, SLIDING, STEP, STRONG, TOLERANCE};
    type Change = fn(&mut SlidingParameters, &mut Load);
    let case = |name, plan: &Plan, method, steps, change: Change| {
        Case::of_scene(name, &accuracy::sliding(plan, 0.0, change)?, method, steps)
    };
    let adaptive = |name, plan: &Plan, change| case(name, plan, RADAU, Steps::Tolerance(TOLERANCE), change);
    let fixed = |name, method, step| case(name, &SLIDING, method, Steps::Fixed(step), |_, _| {});
    let frictionless: Change = |parameters, _| {
        parameters.static_friction_active = 0.0;
        parameters.static_friction_inert = 0.0;
        parameters.kinetic_friction_active = 0.0;
        parameters.kinetic_friction_inert = 0.0;
    };
    Ok(vec![
        (const { named("sliding::bench") }, adaptive("whole", &SLIDING, |_, _| {})?),
        (const { named("sliding::without_friction") }, adaptive("without friction", &GENTLE, frictionless)?),
        (const { named("sliding::without_sticking") }, adaptive("without sticking", &MOVING, |_, _| {})?),
        (
            const { named("sliding::open") },
            adaptive("load open", &SLIDING, |_, load| *load = resistor(f64::INFINITY))?,
        ),
        (
            const { named("sliding::shorted") },
            adaptive("load shorted", &SLIDING, |_, load| *load = resistor(0.0))?,
        ),
        (
            const { named("sliding::gap_field") },
            adaptive("force of the field", &STRONG, |parameters, _| {
                parameters.force_law = ForceLaw::GapField;
            })?,
        ),
        (
            const { named("sliding::without_error_control") },
            fixed("without error control", RADAU, FIXED_STEP)?,
        ),
        (const { named("sliding::explicit") }, fixed("Runge-Kutta 4, fixed step", "Runge-Kutta 4", STEP)?),
        (const { named("sliding::implicit") }, fixed("TR-BDF2, fixed step", "TR-BDF2", IMPLICIT_STEP)?),
    ])
}

fn bump_stop() -> Result<Variants, Error> {
    use bump_stop::{GAPS, IMPACTING, LONG, SHORT};
    type Change = fn(&mut BumpStop, &mut Load);
    let case = |name, long, change: Change| {
        let scene = accuracy::bump_stop(&IMPACTING, GAPS[1], 0.5, change)?;
        Case::of_scene(name, &scene, "discrete gradient", Steps::ShortAndLong([SHORT, long]))
    };
    Ok(vec![
        (const { named("bump_stop::bench") }, case("whole", LONG, |_, _| {})?),
        (
            const { named("bump_stop::without_stop") },
            case("without stop and rod", LONG, |model, _| model.stop = None)?,
        ),
        (
            const { named("bump_stop::one_way") },
            case("one-way coupling", LONG, |model, _| model.parameters.coupling = Coupling::OneWay)?,
        ),
        (
            const { named("bump_stop::open") },
            case("load open", LONG, |_, load| *load = resistor(f64::INFINITY))?,
        ),
        (const { named("bump_stop::single_rate") }, case("one length of step", SHORT, |_, _| {})?),
    ])
}

fn resistor(resistance_ohm: f64) -> Load {
    Load::Resistor { resistance_ohm }
}

fn contact_separation_note() -> String {
    format!(
        "Contact-separation, 0.2 g at 20 Hz, 3 s from rest, with impacts; exponential Radau with tolerance {}, without error
control with a fixed step of {} ms. Error: of the mean power. The restitution is evaluated at impacts only, so its
law does not change the cost of a step.",
        contact_separation::TOLERANCE,
        contact_separation::FIXED_STEP * 1e3,
    )
}

fn sliding_note() -> String {
    format!(
        "Sliding, 0.36 g at 18.373 Hz, 3 s from rest; without friction 0.1 g, because 0.36 g would part the discs;
without sticking in motion from the start; with the force of the field 0.8 g at 16 Hz, because 0.36 g would not move
the slider. Exponential Radau with tolerance {}, without error control with a step of {} ms; Runge-Kutta 4 with a
step of {} ms; TR-BDF2 with a step of {} ms. Error: of the mean power.",
        sliding::TOLERANCE,
        sliding::FIXED_STEP * 1e3,
        sliding::STEP * 1e3,
        sliding::IMPLICIT_STEP * 1e3,
    )
}

fn bump_stop_note() -> String {
    format!(
        "Bump-stop, four modes of the beam and one of the rod, a gap of 10 um, 20 m/s2 at 220 Hz, 2 s from rest;
steps of {} us near contact and {} us in free flight. Error: of the RMS voltage from 0.5 s on, with the same modes;
the motion is weakly chaotic, and a run of this length scatters by some per cent.",
        bump_stop::SHORT * 1e6,
        bump_stop::LONG * 1e6,
    )
}

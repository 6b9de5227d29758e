//! What each part of a scene costs: the bench without it.

use firmware_example::variant::{Variant, named};
use firmware_example::workload::contact_separation::parts::CONSTANT;
use firmware_example::workload::run::Plan;
use firmware_example::workload::{bump_stop, contact_separation, node_parts, sliding};

use super::output::Output;
use super::rows::{self, Case, RADAU, Steps};
use crate::on_target::{Bench, Error, accuracy};
use crate::scene_file::{
    BumpStop, ContactSeparationParameters, Coupling, Draw, ForceLaw, Load, RectifiedStore, Restitution,
    SlidingParameters,
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
    table(bench, output, bump_stop()?, &bump_stop_note())?;
    table(bench, output, node()?, &node_note())
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
    use contact_separation::{FIXED_STEP, IMPACTING, PASSIVE, TOLERANCE};
    type Change = fn(&mut ContactSeparationParameters, &mut Load);
    let under = |plan: &Plan, name, steps, change: Change| {
        Case::of_scene(name, &accuracy::contact_separation(plan, 0.0, change)?, RADAU, steps)
    };
    let case = |name, steps, change| under(&IMPACTING, name, steps, change);
    let (adaptive, fixed) = (Steps::Tolerance(TOLERANCE), Steps::Fixed(FIXED_STEP));
    let same: Change = |_, _| {};
    let no_parasitic: Change = |parameters, _| parameters.parasitic_capacitance_f = 0.0;
    let gap_field: Change = |parameters, _| parameters.force_law = ForceLaw::GapField;
    let constant: Change = |parameters, _| {
        parameters.restitution = Restitution::Constant { coefficient: f64::from(CONSTANT.coefficient) };
    };
    let both: Change = |parameters, _| {
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
            const { named("contact_separation::gap_field") },
            under(&PASSIVE, "force of the field", adaptive, gap_field)?,
        ),
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
    use bump_stop::{FEWER_MODES, GAPS, IMPACTING, LONG, LONGER, MORE_MODES, SHORT};
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
        (
            const { named("bump_stop::spring") },
            case("rod as a spring", LONG, |model, _| with_modes(model, [bump_stop::BEAM_MODES, 0]))?,
        ),
        (
            const { named("bump_stop::fewer_modes") },
            case("(2,1) modes", LONG, |model, _| with_modes(model, FEWER_MODES))?,
        ),
        (
            const { named("bump_stop::more_modes") },
            case("(6,2) modes", LONG, |model, _| with_modes(model, MORE_MODES))?,
        ),
        (const { named("bump_stop::checked") }, case("with the error of the steps", LONG, |_, _| {})?),
        (
            const { named("bump_stop::checked_longer") },
            case("the same, 220 µs in flight", LONGER, |_, _| {})?,
        ),
    ])
}

/// Sets the numbers of modes of beam and rod.
fn with_modes(model: &mut BumpStop, [beam, rod]: [usize; 2]) {
    model.parameters.beam_modes = beam;
    if let Some(stop) = &mut model.stop {
        stop.rod_modes = rod;
    }
}

/// The parts of a node that steps the model, each with those before it.
fn node() -> Result<Variants, Error> {
    use contact_separation::{PASSIVE, TOLERANCE};
    let case = |name, change: fn(&mut Load)| {
        let scene = accuracy::contact_separation(&PASSIVE, 0.0, |parameters, load| {
            parameters.force_law = ForceLaw::GapField;
            change(load);
        })?;
        Case::of_scene(name, &scene, RADAU, Steps::Tolerance(TOLERANCE))
    };
    let charging = |load: &mut Load| *load = node_storage();
    Ok(vec![
        (const { named("node_parts::resistor") }, case("harvester with a resistor", |_| {})?),
        (
            const { named("node_parts::bus") },
            case("bridge into a bus", |load| {
                *load = Load::DcBus {
                    voltage_v: f64::from(node_parts::VOLTAGE),
                    diode_drop_v: f64::from(node_parts::DIODE_DROP),
                };
            })?,
        ),
        (const { named("node_parts::storage") }, case("bridge into a storage", charging)?),
        (const { named("node_parts::estimator") }, case("and estimator", charging)?),
    ])
}

/// The storage of the node, which nothing discharges here.
fn node_storage() -> Load {
    Load::RectifiedStore(RectifiedStore {
        capacitance_f: f64::from(node_parts::CAPACITANCE),
        diode_drop_v: f64::from(node_parts::DIODE_DROP),
        leakage_ohm: f64::INFINITY,
        initial_v: f64::from(node_parts::VOLTAGE),
        draw: Draw::None,
    })
}

fn resistor(resistance_ohm: f64) -> Load {
    Load::Resistor { resistance_ohm }
}

fn contact_separation_note() -> String {
    format!(
        "Contact-separation, 0.2 g at 20 Hz, with the force of the field at {:.2} Hz, where its motion is periodic; 3 s from
rest, with impacts; exponential Radau with tolerance {}, without error control with a fixed step of {} ms. Error: of the
mean power. The restitution is evaluated at impacts only, so its law does not change the cost of a step.",
        contact_separation::PASSIVE.frequency,
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
steps of {} us near contact and {} us in free flight, for other numbers of modes too. Error: of the RMS voltage from
0.5 s on, with the same modes; the motion is weakly chaotic, and a run of this length scatters by some per cent.",
        bump_stop::SHORT * 1e6,
        bump_stop::LONG * 1e6,
    )
}

fn node_note() -> String {
    format!(
        "What a node adds, each row with the parts of those before it: contact-separation under the force of the field, 0.2 g
at {:.2} Hz, 3 s from rest; exponential Radau with tolerance {}. The bus and the storage have {} V at the start. The
estimator takes the base acceleration as 400 samples a second. Error: of the mean power.",
        contact_separation::PASSIVE.frequency,
        contact_separation::TOLERANCE,
        node_parts::VOLTAGE,
    )
}

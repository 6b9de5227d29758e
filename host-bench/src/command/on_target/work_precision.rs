//! Error against instructions, on the settled scenes.

use firmware_example::workload::run::{Plan, REJECTED};
use firmware_example::workload::{bump_stop, contact_separation, named, sliding};

use super::Output;
use super::rows::{self, Case, Column, Steps, percent};
use crate::embedded;
use crate::method::{Method, Options, Precision};
use crate::on_target::{Bench, Error, native};
use crate::scene_file::{Load, Scene};

/// Settling time of the triboelectric scenes, in seconds.
const SETTLE_S: f64 = 10.0;

/// Measures the scenes with each setting and prints a table of each.
pub(super) fn report(bench: &Bench, output: &mut Output) -> Result<(), Error> {
    report_contact_separation(bench, output)?;
    report_sliding(bench, output)?;
    report_bump_stop(bench, output)
}

fn report_contact_separation(bench: &Bench, output: &mut Output) -> Result<(), Error> {
    use contact_separation::{EXPLICIT_STEPS, LOAD_TOLERANCES, LOADS, SETTLING, STEPS, TOLERANCES};
    let mut scene = native::scene("contact-separation", &SETTLING, SETTLE_S)?;
    let mut others = other_cases(&scene, &TOLERANCES, &STEPS, &EXPLICIT_STEPS)?;
    others.iter_mut().try_for_each(|case| add_double_precision(case, &scene))?;
    let mut cases = Vec::new();
    for resistance in LOADS {
        scene.load = loaded(resistance);
        let mut loaded = radau_cases(&scene, &LOAD_TOLERANCES)?;
        loaded.iter_mut().try_for_each(|case| add_double_precision(case, &scene))?;
        cases.extend(loaded);
    }
    cases.extend(others);
    let found = rows::measure(bench, &const { named("contact_separation::precision") }, cases)?;
    let columns = [
        rows::LOAD,
        rows::METHOD,
        rows::SETTING,
        rows::STEPS_PER_SECOND,
        ("error f32", rows::ERROR.1),
        ("error f64", |row| host_error(&row.case, 0)),
        rows::PER_STEP,
        rows::PER_SECOND,
    ];
    let note = format!(
        "{}. Contact-separation, 20 Hz, 0.2 g, from {SETTLE_S} s to {} s. Error: of the mean power against the
independent reference; f32 is this core's run, with the host's bits, f64 the host's. Instructions as QEMU executes
them, which are not cycles.",
        bench.core(),
        scene.run.duration_s
    );
    output.rows(&found, &columns, 2, &note);
    Ok(())
}

fn report_sliding(bench: &Bench, output: &mut Output) -> Result<(), Error> {
    use sliding::{ABOVE, BELOW, EXPLICIT_STEPS, LOAD_TOLERANCES, LOADS, SETTLING, STEPS, TOLERANCES};
    let mut scene = native::scene("sliding", &SETTLING, SETTLE_S)?;
    let mut others = other_cases(&scene, &TOLERANCES, &STEPS, &EXPLICIT_STEPS)?;
    for plan in [BELOW, ABOVE] {
        for (case, error) in others.iter_mut().zip(sliding_host_errors(plan)?) {
            case.host_errors.push(error);
        }
    }
    let mut cases = Vec::new();
    for resistance in LOADS {
        scene.load = loaded(resistance);
        cases.extend(radau_cases(&scene, &LOAD_TOLERANCES)?);
    }
    cases.extend(others);
    let found = rows::measure(bench, &const { named("sliding::precision") }, cases)?;
    let columns = [
        rows::LOAD,
        rows::METHOD,
        rows::SETTING,
        rows::STEPS_PER_SECOND,
        ("error at 18.373 Hz", rows::ERROR.1),
        ("at 18.303 Hz", |row| host_error(&row.case, 0)),
        ("at 18.443 Hz", |row| host_error(&row.case, 1)),
        rows::PER_STEP,
        rows::PER_SECOND,
    ];
    let note = format!(
        "{}. Sliding, 0.36 g, from {SETTLE_S} s to {} s. Error: of the mean power in f32, with this core's bits,
against the independent reference. Steps and instructions at 18.373 Hz, with four events a period. Instructions as
QEMU executes them, which are not cycles.",
        bench.core(),
        SETTLING.seconds()
    );
    output.rows(&found, &columns, 2, &note);
    Ok(())
}

fn report_bump_stop(bench: &Bench, output: &mut Output) -> Result<(), Error> {
    use bump_stop::{GAPS, SETTLING, STEPS};
    const GAP: Column = ("gap in um", |row| row.case.name.clone());
    const NOT_TAKEN: Column = ("not taken", |row| {
        let rejected = row.workload.samples.last().and_then(|sample| sample.bits.get(REJECTED));
        rejected.map_or_else(String::new, |&count| format!("{:.0}", f64::from(count) / row.counted().seconds))
    });
    let mut cases = Vec::new();
    for gap in GAPS {
        let scene = native::bump_stop(&SETTLING, gap, 0.5)?;
        let name = format!("{}", gap * 1e6);
        let case = Case::of_scene(name, &scene, "discrete gradient", Steps::None)?;
        cases.extend(STEPS.map(|steps| Case { steps: Steps::ShortAndLong(steps), ..case.clone() }));
    }
    let found = rows::measure(bench, &const { named("bump_stop::precision") }, cases)?;
    let columns = [
        GAP,
        rows::SETTING,
        rows::STEPS_PER_SECOND,
        NOT_TAKEN,
        rows::ERROR,
        rows::PER_STEP,
        rows::PER_SECOND,
    ];
    let note = format!(
        "{}. Bump-stop, four modes of the beam and one of the rod, 20 m/s2 at 220 Hz, from rest to {} s, with steps
near contact and in free flight. Error: of the RMS voltage from 0.5 s on, against the reference with the same modes;
the motion is weakly chaotic, and a few per cent are scatter. Not taken: long steps a second that were rejected
because of a possible contact. Instructions as QEMU executes them, which are not cycles.",
        bench.core(),
        SETTLING.seconds()
    );
    output.rows(&found, &columns, 2, &note);
    Ok(())
}

/// A settled run of a scene, counted from the settling time on.
fn settled(scene: &Scene) -> Result<Case, Error> {
    let counted_from_us = (SETTLE_S * 1e6) as u64;
    Ok(Case { counted_from_us, ..Case::of_scene("settled", scene, rows::RADAU, Steps::None)? })
}

fn radau_cases(scene: &Scene, tolerances: &[f32]) -> Result<Vec<Case>, Error> {
    let case = settled(scene)?;
    let with = |&tolerance| Case { steps: Steps::Tolerance(tolerance), ..case.clone() };
    Ok(tolerances.iter().map(with).collect())
}

/// The cases of a scene by the other methods, in the firmware's order.
fn other_cases(
    scene: &Scene,
    tolerances: &[f32],
    steps: &[f32],
    explicit_steps: &[f32],
) -> Result<Vec<Case>, Error> {
    let case = settled(scene)?;
    let with = |method, steps| Case { method, steps, ..case.clone() };
    let tolerances = tolerances.iter().map(|&tolerance| with("TR-BDF2", Steps::Tolerance(tolerance)));
    let fixed = steps.iter().map(|&step| with("TR-BDF2", Steps::Fixed(step)));
    let explicit = explicit_steps.iter().map(|&step| with("Runge-Kutta 4", Steps::Fixed(step)));
    Ok(tolerances.chain(fixed).chain(explicit).collect())
}

fn loaded(resistance: f32) -> Load {
    Load::Resistor { resistance_ohm: f64::from(resistance) }
}

/// Adds the error of the same run in double precision on the host.
fn add_double_precision(case: &mut Case, scene: &Scene) -> Result<(), Error> {
    let double =
        embedded::run(scene, &double_precision(case)).map_err(|error| Error::Host(error.to_string()))?;
    let power = double.mean_power_w.unwrap_or(f64::NAN);
    case.host_errors = vec![case.reference.and_then(|reference| reference.error_of(power))];
    Ok(())
}

/// The options of the same run in double precision on the host.
fn double_precision(case: &Case) -> Options {
    let method = match case.method {
        "TR-BDF2" => Method::TrBdf2,
        rows::RADAU => Method::ExponentialRadau,
        _ => Method::Rk4,
    };
    let double = Options { method, precision: Some(Precision::F64), ..Options::default() };
    match case.steps {
        Steps::Tolerance(tolerance) => Options { tolerance: Some(f64::from(tolerance).min(0.1)), ..double },
        Steps::Fixed(step) => Options { step_s: Some(f64::from(step)), ..double },
        Steps::ShortAndLong(_) | Steps::None => double,
    }
}

/// Relative errors of the sliding runs under `plan`, on the host, which computes the core's bits.
fn sliding_host_errors(plan: Plan) -> Result<Vec<Option<f64>>, Error> {
    let reference = native::Reference::new(&native::scene("sliding", &plan, SETTLE_S)?)?;
    native::each_workload(
        |visit| sliding::precision_of(plan, visit),
        |workload| Ok(reference.power_error(&native::run(workload)?)),
    )
}

fn host_error(case: &Case, index: usize) -> String {
    percent(case.host_errors.get(index).copied().flatten())
}

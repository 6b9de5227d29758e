//! The benches of the three scenes on each core.

use std::time::Duration;

use firmware_example::workload::{Variant, bump_stop, contact_separation, named, sliding};

use super::rows::{self, Case, Column, RADAU, Row, Steps};
use super::{Output, bench, on_each};
use crate::on_target::qemu::Core;
use crate::on_target::{Error, native};
use crate::scene_file::{Draw, ForceLaw, Load, Model, RectifiedStore};

/// Settling time of the bump-stop runs in seconds: their first sample.
const SETTLE_S: f64 = 0.5;

const SCENE: Column = ("scene", |row| row.case.name.clone());
const RUN: Column = ("run", |row| row.case.name.clone());

/// Measures the benches on `cores` and prints their tables.
pub(super) fn report(cores: &[Core], limit: Duration, output: &mut Output) -> Result<(), Error> {
    let (benches, others) = (benches()?, others()?);
    let measured = on_each(cores, |core| {
        let bench = bench(core, limit)?;
        let mut bench_rows = Vec::new();
        for (variant, case) in &benches {
            bench_rows.extend(rows::measure(&bench, variant, vec![case.clone()])?);
        }
        // The board of the Cortex-M3 has 8 kB of RAM, too few for the last of them.
        let fitting = others.len() - usize::from(core == Core::M3);
        let mut other_rows = Vec::new();
        for (variant, cases) in &others[..fitting] {
            other_rows.extend(rows::measure(&bench, variant, cases.clone())?);
        }
        Ok((bench_rows, other_rows))
    })?;
    let (bench_rows, other_rows): (Vec<_>, Vec<_>) = measured.into_iter().unzip();
    let [bench_rows, other_rows] =
        [bench_rows, other_rows].map(|rows| rows.into_iter().flatten().collect::<Vec<Row>>());
    let samples = |rows: &[Row]| rows.iter().map(|row| row.workload.samples.len()).sum::<usize>();
    let count = samples(&bench_rows) + samples(&other_rows);
    let columns = [
        rows::CORE,
        SCENE,
        rows::PER_STEP,
        rows::PER_SECOND,
        rows::ERROR,
        rows::FLASH,
        rows::STATIC_RAM,
        rows::STACK,
    ];
    output.rows(&bench_rows, &columns, 2, &bench_note());
    let columns = [rows::CORE, RUN, rows::METHOD, rows::PER_STEP, rows::PER_SECOND, rows::ERROR, rows::STACK];
    output.rows(&other_rows, &columns, 3, &other_note(count));
    Ok(())
}

fn benches() -> Result<[(Variant, Case); 3], Error> {
    let contact = native::scene("contact-separation", &contact_separation::IMPACTING, 0.0)?;
    let slide = native::scene("sliding", &sliding::SLIDING, 0.0)?;
    let bump = native::bump_stop(&bump_stop::IMPACTING, bump_stop::GAPS[1], SETTLE_S)?;
    let tolerance = Steps::Tolerance(contact_separation::TOLERANCE);
    let steps = Steps::ShortAndLong([bump_stop::SHORT, bump_stop::LONG]);
    Ok([
        (
            const { named("contact_separation::bench") },
            Case::of_scene("contact-separation", &contact, RADAU, tolerance)?,
        ),
        (
            const { named("sliding::bench") },
            Case::of_scene("sliding", &slide, RADAU, Steps::Tolerance(sliding::TOLERANCE))?,
        ),
        (
            const { named("bump_stop::bench") },
            Case::of_scene("bump-stop", &bump, "discrete gradient", steps)?,
        ),
    ])
}

/// The runs beside the benches, and the builds of the coefficients.
fn others() -> Result<[(Variant, Vec<Case>); 4], Error> {
    let [capacitance, initial_v, diode_drop] = contact_separation::STORAGE.map(f64::from);
    let mut charging = native::scene("contact-separation", &contact_separation::PASSIVE, 0.0)?;
    if let Model::ContactSeparation(model) = &mut charging.model {
        model.parameters.force_law = ForceLaw::GapField;
    }
    charging.load = Load::RectifiedStore(RectifiedStore {
        capacitance_f: capacitance,
        diode_drop_v: diode_drop,
        leakage_ohm: f64::INFINITY,
        initial_v,
        draw: Draw::None,
    });
    let checked = native::bump_stop(&bump_stop::CHECKED, bump_stop::GAPS[1], SETTLE_S)?;
    let stick_slip = native::scene("sliding", &sliding::STICK_SLIP, 0.0)?;
    let touching = native::bump_stop(&bump_stop::TOUCHING, 0.0, SETTLE_S)?;
    let (step, tolerance) = (Steps::Fixed(sliding::STEP), Steps::Tolerance(sliding::TOLERANCE));
    let steps = Steps::ShortAndLong([bump_stop::SHORT, bump_stop::LONG]);
    let of_storage = Steps::Tolerance(contact_separation::TOLERANCE);
    Ok([
        (
            const { named("contact_separation::others") },
            vec![Case::of_scene("a bridge into a storage", &charging, RADAU, of_storage)?],
        ),
        (
            const { named("sliding::others") },
            vec![
                Case::of_scene("stick-slip", &stick_slip, RADAU, tolerance)?,
                Case::of_scene("stick-slip", &stick_slip, "Runge-Kutta 4", step)?,
                Case::new("sliding", "sliding", "build"),
            ],
        ),
        (
            const { named("bump_stop::others") },
            vec![
                Case::of_scene("bump-stop without a gap", &touching, "discrete gradient", steps)?,
                Case::new("bump-stop", "bump-stop", "build"),
            ],
        ),
        (
            const { named("bump_stop::checked") },
            vec![Case::of_scene("error of the steps", &checked, "discrete gradient", steps)?],
        ),
    ])
}

fn bench_note() -> String {
    format!(
        "Contact-separation: exponential Radau with tolerance {}, 20 Hz, 0.2 g, 3 s from rest, with impacts.
Sliding: exponential Radau with tolerance {}, 18.373 Hz, 0.36 g, 3 s from rest.
Bump-stop: four modes of the beam and one of the rod, a gap of 10 um, steps of {} us near contact and {} us
in free flight, 220 Hz, 20 m/s2, 2 s from rest.
Error: of the mean power of this run, against the independent reference over the same time; for bump-stop of the
RMS voltage from {SETTLE_S} s on, against the reference with the same modes.
Instructions as QEMU executes them, which are not cycles. Flash: what is added to an empty firmware with the same
runtime and log. Stack: from the top of RAM. Sizes in bytes.",
        contact_separation::TOLERANCE,
        sliding::TOLERANCE,
        bump_stop::SHORT * 1e6,
        bump_stop::LONG * 1e6,
    )
}

fn other_note(samples: usize) -> String {
    format!(
        "Bridge into a storage: 22 uF from 2.6 V, under the force of the field at {:.2} Hz. Stick-slip: 6 Hz, 0.30 g. Runge-Kutta 4 with a step of {} ms. The other settings are those of the first table.
Build: the coefficients from the parameters, once; instructions per step are those of one build.
{samples} sampled states in both tables, each bit-identical to the host's f32 run.",
        contact_separation::PASSIVE.frequency,
        sliding::STEP * 1e3,
    )
}

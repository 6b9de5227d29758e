//! What an estimate costs for each sample, and a look-up in a response map for each call.

use super::output::Output;
use super::rows::{self, Case, Column, RADAU, Steps};
use crate::on_target::{Bench, Error};
use firmware_example::variant::named;
use firmware_example::workload::{bump_stop, contact_separation, sliding};

const ESTIMATE: Column = ("estimate", |row| row.workload.name.clone());
const PER_CALL: Column = ("instructions per sample or call", rows::PER_STEP.1);
const PER_SECOND: Column = ("per second", rows::PER_SECOND.1);

/// Measures the estimators of all scenes and the look-up, and prints their instructions.
///
/// # Errors
///
/// If the firmware does not build or run, or computes other bits than the host.
pub(super) fn report(bench: &Bench, output: &mut Output) -> Result<(), Error> {
    let estimator =
        |scene, method, steps| Case { steps, by_sample: true, ..Case::new("estimator", scene, method) };
    let cases = vec![
        estimator("contact-separation", RADAU, Steps::Tolerance(contact_separation::TOLERANCE)),
        estimator("sliding", RADAU, Steps::Tolerance(sliding::TOLERANCE)),
        estimator("bump-stop", "discrete gradient", Steps::ShortAndLong([bump_stop::SHORT, bump_stop::LONG])),
    ];
    let mut found = rows::measure(bench, &const { named("estimators::all") }, cases)?;
    let look_up = |motions| Case::new("look-up", "contact-separation", motions);
    let cases = vec![
        look_up("one motion"),
        look_up("two motions"),
        Case { by_sample: true, ..Case::new("estimator", "strongest-sine", "bank of lines") },
    ];
    found.extend(rows::measure(bench, &const { named("response_map::all") }, cases)?);
    let columns = [rows::CORE, ESTIMATE, PER_CALL, PER_SECOND, rows::STACK];
    let note =
        "Samples at 400 a second (contact-separation, lines of the band), 367 (sliding) and 3520 (bump-stop).
A response map is called once a second. Each estimate has the host's bits.";
    output.rows(&found, &columns, 2, note);
    Ok(())
}

//! The smooth contact-separation scene by the crate numeris, beside model-core.

use firmware_example::variant::named;
use firmware_example::workload::contact_separation::{SMOOTH, SMOOTH_STEP, SMOOTH_TOLERANCES};
use firmware_example::workload::peer;

use super::output::Output;
use super::rows::{self, Case, Steps};
use crate::on_target::{Bench, Error, accuracy};

/// Measures both and prints one table.
///
/// # Errors
///
/// If the firmware does not build or run, or model-core computes other bits than on the host.
pub(super) fn report(bench: &Bench, output: &mut Output) -> Result<(), Error> {
    let scene = accuracy::scene("contact-separation", &SMOOTH, 0.0)?;
    let case = |method, steps| Case::of_scene("smooth", &scene, method, steps);
    let ours = SMOOTH_TOLERANCES.map(|value| case("model-core, exponential Radau", Steps::Tolerance(value)));
    let explicit = case("model-core, Runge-Kutta 4", Steps::Fixed(SMOOTH_STEP));
    let peer = peer::TOLERANCES.map(|value| case("numeris 0.6, RODAS4", Steps::Tolerance(value)));
    let cases = ours.into_iter().chain([explicit]).chain(peer).collect::<Result<Vec<_>, _>>()?;
    let found = rows::measure(bench, &const { named("peer::smooth") }, cases)?;
    let columns = [rows::METHOD, rows::SETTING, rows::STEPS, rows::ERROR, rows::PER_STEP, rows::PER_SECOND];
    let note = format!(
        "{}. Contact-separation without impacts, 22 Hz, 0.2 g, {} s from rest, both in f32.
Error: of the mean power against the independent reference. numeris has the energy as a fourth state, and time as a
fifth in place of the derivative by time. Instructions as QEMU executes them, which are not cycles.",
        bench.core(),
        scene.run.duration_s,
    );
    output.rows(&found, &columns, 2, &note);
    Ok(())
}

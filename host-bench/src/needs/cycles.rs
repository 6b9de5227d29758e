//! Runs of a scene whose draw is switched on and off, over whole cycles of the switch.

use crate::method::{Failure, Options};
use crate::outcome::{Outcome, SwitchCycles};
use crate::run::run_scene;
use crate::scene_file::{Excitation, Load, Scene};

/// Whole cycles of the switch of a draw that a window has, and the longest window for them over that of the scene.
const FEWEST_CYCLES: f64 = 4.0;
const LONGEST: f64 = 8.0;

/// A run with the means over the whole cycles of the switch of a draw in place of those of its window.
pub(super) fn run_cycles(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    run_scene(scene, options).map(over_cycles)
}

/// The means over whole cycles, where there are any, in place of those of the window.
pub(super) fn over_cycles(mut outcome: Outcome) -> Outcome {
    if let (Some(cycles), Some(store)) = (cycles(&outcome), &mut outcome.store) {
        outcome.mean_power_w = Some(cycles.mean_power_w);
        outcome.rms_voltage_v = Some(cycles.rms_voltage_v);
        store.store_voltage_v = Some(cycles.mean_store_voltage_v);
    }
    outcome
}

/// The whole cycles of the switch of a draw in the window of a run.
pub(crate) fn cycles(outcome: &Outcome) -> Option<SwitchCycles> {
    outcome.store.and_then(|store| store.cycles)
}

/// Whether the draw of a scene is switched on and off.
pub(super) fn switches(scene: &Scene) -> bool {
    matches!(scene.load, Load::RectifiedStore(store) if store.draw.lockout().is_some())
}

/// The scene with as long a window as [`FEWEST_CYCLES`] whole cycles of the switch of its draw need, and a warning where
/// [`LONGEST`] windows do not have so many.
pub(super) fn with_cycles(scene: &Scene) -> Result<(Scene, Option<String>), Failure> {
    let mut longer = scene.clone();
    if !switches(scene) {
        return Ok((longer, None));
    }
    if !matches!(&scene.excitation, Excitation::File(trace) if !trace.repeat) {
        longer.run.duration_s = scene.run.settle_s + LONGEST * scene.run.window_s();
    }
    let most_s = longer.run.duration_s;
    let found = cycles(&run_scene(&longer, &Options { blocks: true, ..Options::default() })?);
    // Half a cycle more than it takes, wherever the window ended.
    let cycle_s = |found: SwitchCycles| (found.until_s - found.from_s) / found.count as f64;
    let needed = found.map(|found| found.from_s + (FEWEST_CYCLES + 0.5) * cycle_s(found));
    let needed = needed.filter(|needed| *needed <= most_s);
    longer.run.duration_s = scene.run.duration_s.max(needed.unwrap_or(0.0));
    let text = format!(
        "load.draw: fewer than {FEWEST_CYCLES} whole cycles of its switch until {most_s} s: the verdicts depend on the window"
    );
    Ok((longer, needed.is_none().then_some(text)))
}

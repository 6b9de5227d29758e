//! The storage capacitor of the second paper: finding 20.

use super::scenes::{PAPER, each_of, scene, value};
use super::{Bound, Check, Measured};
use crate::method::{Failure, Options};
use crate::run::run_scene;
use crate::scene_file::Scene;

/// Finding 20.
pub(super) fn measure() -> Result<Measured, Failure> {
    let charging = scene("bump-stop-paper-charging", &[])?;
    let stored = each_of(PAPER, |name| {
        let scene = Scene { load: charging.load, run: charging.run, ..scene(name, &[])? };
        let outcome = run_scene(&scene, &Options::default())?;
        let store =
            outcome.store.ok_or_else(|| Failure::of_file(&scene, "load.kind must be \"rectified-store\""))?;
        Ok([value(store.store_voltage_v), 1e6 * value(store.stored_energy_j)])
    })?;
    let voltages = stored.map(|[voltage, _]| voltage);
    let [tip, mid, none] = voltages;
    Ok(vec![(
        "20",
        vec![
            Check::new(
                "voltage after 5 s, mid-span / tip, none / mid-span",
                [mid / tip, none / mid],
                Bound::Above(1.15),
            ),
            Check::new("voltage [V]: tip, mid-span, none", voltages, Bound::Reported),
            Check::new("energy [µJ]: tip, mid-span, none", stored.map(|[_, energy]| energy), Bound::Reported),
        ],
    )])
}

//! Impacts and periodicity of contact-separation: findings 37 to 39; the parasitic capacitance: finding 42.

use super::runs::{Changes, Loader, each_of, value};
use super::statistics::spread;
use super::{Bound::*, Measured, check};
use crate::method::{Failure, Options};
use crate::outcome::ContactSeparationOutcome;
use crate::run::run_scene;
use crate::scene_file::Scene;

/// 50 µC/m² at 100 MΩ, at a frequency in Hz.
fn at(frequency_hz: &str) -> [(&str, &str); 3] {
    [
        ("parameters.charge_density_c_per_m2", "50e-6"),
        ("load.resistance_ohm", "1e8"),
        ("excitation.frequency_hz", frequency_hz),
    ]
}

/// The numbers of a scene with a window of 20 s after 10 s: at the left edge of the band it has 16 impacts only.
fn motion(scene: &Scene) -> Result<ContactSeparationOutcome, Failure> {
    run_scene(scene, &Options::default())?
        .contact_separation()
        .cloned()
        .ok_or_else(|| Failure::Input("a contact-separation scene must be run".to_owned()))
}

/// Spread in µm of the gap once a period, over the last 100 periods of a run of `duration_s` seconds.
fn stroboscopic_spread(loader: Loader<'_>, frequency_hz: &str, duration_s: &str) -> Result<f64, Failure> {
    let run: Changes<'_> = &[("run.duration_s", duration_s), ("run.settle_s", "0")];
    let scene = loader.scene("contact-separation", &[&at(frequency_hz)[..], run].concat())?;
    let period_s = scene.excitation.single_frequency().map(f64::recip);
    let outcome = run_scene(&scene, &Options { trace_every_s: period_s, ..Options::default() })?;
    let rows = outcome.trace.map(|trace| trace.rows).unwrap_or_default();
    let last = rows.len().saturating_sub(100);
    Ok(1e6 * spread(rows[last..].iter().map(|row| row.get(1).copied().unwrap_or(f64::NAN))))
}

/// Findings 37 to 39.
pub(super) fn measure(loader: Loader<'_>) -> Result<Measured, Failure> {
    let longer: Changes<'_> = &[("run.duration_s", "30")];
    let at = |frequency: &&str| loader.scene("contact-separation", &[&at(frequency)[..], longer].concat());
    let scenes = each_of(["18.83", "18.84", "20.15", "20.2"], at)?;
    let [below, first, near_last, above] = each_of(scenes.each_ref(), |scene| motion(scene))?;
    let per_period = |motion: &ContactSeparationOutcome| value(motion.impacts_per_period);
    let speed = |motion: &ContactSeparationOutcome| value(motion.max_impact_speed_m_per_s);
    let [before, chaotic, periodic, after] = each_of(
        [("18.8", "40"), ("19.2", "15"), ("19.8", "15"), ("20.3", "15")],
        |(frequency, duration)| stroboscopic_spread(loader, frequency, duration),
    )?;
    Ok(vec![
        check("37", "impacts per period at 18.83 Hz", [per_period(&below)], Is(0.0)).of(scenes),
        check("37", "at 18.84 Hz", [per_period(&first)], Within(1e-3, 0.2)),
        check("38", "impacts per period at 20.15 Hz", [per_period(&near_last)], Within(0.9, 1.1)),
        check(
            "38",
            "largest impact speed, 20.15 / 18.84 Hz",
            [speed(&near_last) / speed(&first)],
            // With half the restitution it is 2.2.
            Within(1.1, 1.6),
        ),
        check("38", "impacts per period at 20.20 Hz", [per_period(&above)], Is(0.0)),
        check("39", "gap once a period at 18.8 Hz: spread [µm]", [before], Below(0.1)),
        check("39", "at 19.2 Hz [µm]", [chaotic], Above(100.0)),
        check("39", "at 19.8 Hz [µm]", [periodic], Below(1.0)),
        check("39", "at 20.3 Hz [µm]", [after], Below(10.0)),
    ])
}

/// Finding 42.
pub(super) fn measure_parasitic(loader: Loader<'_>) -> Result<Measured, Failure> {
    let changes = each_of(["1e6", "1e8", "1e9"], |resistance| {
        let [without, with] = each_of(["0", "1e-12"], |capacitance| {
            let changes = [
                ("parameters.force_law", "gap-field"),
                ("parameters.parasitic_capacitance_f", *capacitance),
                ("excitation.frequency_hz", "20.5"),
                ("load.resistance_ohm", *resistance),
            ];
            Ok(value(loader.run("contact-separation", &changes)?.rms_voltage_v))
        })?;
        Ok((with / without - 1.0).abs())
    })?;
    let [low, _, high] = changes;
    Ok(vec![
        check("42", "change of the RMS voltage by 1 pF, 1 MΩ to 1 GΩ", changes, Rises),
        check("42", "at 1 MΩ", [low], Below(5e-3)),
        check("42", "at 1 GΩ", [high], Above(0.05)),
    ])
}

//! Values found before by independent implementations (TR-BDF2 with bisected events, Radau at 1e-9).

use super::*;

#[test]
fn impacts_once_a_period() {
    let outcome = run(&shipped(1e8));
    let found = particular(&outcome);
    close(found.peak_gap_m, 5.51344e-3, 2e-6);
    close(found.max_impact_speed_m_per_s, 0.06378, 1e-4);
    close(outcome.rms_voltage_v, 32.51, 1e-4);
    assert_eq!(found.impacts, 100);
    close(found.impacts_per_period, 1.0, 1e-12);
    // No direct voltage in a periodic motion.
    assert!(outcome.mean_voltage_v.expect("a number").abs() < 1e-9 * 32.51);
}

#[test]
fn impacts_once_a_period_under_the_gap_field() {
    let parameters = table_2(100e-6, ForceLaw::GapField);
    let excitation = sine(0.2 * GRAVITY, 20.5);
    let span = [200.0 / 20.5, 300.0 / 20.5];
    let outcome = run(&scene(parameters, ContactSeparationStart::default(), 1e8, excitation, span));
    let found = particular(&outcome);
    close(found.peak_gap_m, 6.00485e-3, 2e-6);
    close(found.max_impact_speed_m_per_s, 0.05396, 1e-4);
    close(outcome.rms_voltage_v, 67.920, 1e-5);
}

/// Thin gap, strong shaking, hard losses: nine or ten impacts and one stick each period.
#[test]
fn sticks_each_period() {
    use ForceLaw::{GapField, TransferredCharge};
    use StickCharge::{Frozen, Relaxing};
    for (force_law, stick_charge, resistance, gap, stuck, impacts) in [
        (TransferredCharge, Frozen, 1e6, 0.82010e-3, 0.3713, 9.0),
        (TransferredCharge, Relaxing, 1e6, 0.82010e-3, 0.3713, 9.0),
        (GapField, Frozen, 1e6, 1.03460e-3, 0.3795, 10.0),
        (TransferredCharge, Frozen, 1e8, 0.81435e-3, 0.3808, 9.0),
        (TransferredCharge, Relaxing, 1e8, 0.79843e-3, 0.3760, 9.0),
    ] {
        let parameters = ContactSeparationParameters {
            initial_gap_m: 0.1e-3,
            restitution: Restitution::Constant { coefficient: 0.3 },
            stick_charge,
            ..table_2(20e-6, force_law)
        };
        let span = [20.0 / 6.0, 40.0 / 6.0];
        let excitation = sine(GRAVITY, 6.0);
        let outcome =
            run(&scene(parameters, ContactSeparationStart::default(), resistance, excitation, span));
        let found = particular(&outcome);
        close(found.peak_gap_m, gap, 2e-5);
        close(found.stuck_fraction, stuck, 3e-4);
        close(found.impacts_per_period, impacts, 1e-12);
        assert!(outcome.energy_residual.expect("a number") < 1e-10);
    }
}

#[test]
fn band_of_impacts_begins_where_it_was_found() {
    // 300 periods from rest; the last 100 without or with impacts.
    for (frequency, resistance, impacts) in
        [(18.83, 1e8, false), (18.84, 1e8, true), (18.96, 1e6, false), (18.97, 1e6, true)]
    {
        let mut scene = shipped(resistance);
        scene.excitation = sine(0.2 * GRAVITY, frequency);
        scene.run = RunSpan { settle_s: 200.0 / frequency, duration_s: 300.0 / frequency };
        let outcome = run(&scene);
        assert_eq!(particular(&outcome).impacts > 0, impacts, "{frequency} Hz, {resistance} ohm");
    }
}

#[test]
fn tightening_the_tolerance_changes_nothing_that_counts() {
    for resistance in [1e6, 1e8] {
        let scene = shipped(resistance);
        let usual = run(&scene);
        let tight = ReferenceOptions { tolerance: 1e-13, ..ReferenceOptions::default() };
        let tight = crate::run(&scene, &tight).expect("the reference gets to the end");
        close(usual.mean_power_w, tight.mean_power_w.expect("a number"), 1e-9);
        close(usual.peak_voltage_v, tight.peak_voltage_v.expect("a number"), 1e-9);
        let first = particular(&tight).first_impact_s.expect("an impact");
        close(particular(&usual).first_impact_s, first, 1e-10);
        assert!(usual.energy_residual.expect("a number") < 5e-10);
    }
}

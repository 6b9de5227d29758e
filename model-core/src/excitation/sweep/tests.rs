use super::super::test_support::{advance, checksum, oscillator};
use super::*;
use crate::oscillator::tests::by_small_steps;
use core::f64::consts::TAU;

fn at(seconds: f64) -> Instant {
    Instant::from_seconds(seconds).expect("in range")
}

/// Turns since time zero by the closed forms in `f64`, for one way and back.
fn turns(law: SweepLaw, [from, to]: [f64; 2], seconds: f64, time: f64) -> f64 {
    let way = |t: f64| match law {
        SweepLaw::Linear => from * t + 0.5 * (to - from) * t * t / seconds,
        SweepLaw::Logarithmic => {
            let logarithm = (to / from).ln();
            from * seconds / logarithm * (logarithm * t / seconds).exp_m1()
        }
    };
    let (both, time) = ((time / (2.0 * seconds)).floor(), time % (2.0 * seconds));
    let whole = 2.0 * way(seconds);
    both * whole + if time <= seconds { way(time) } else { whole - way(2.0 * seconds - time) }
}

#[test]
fn phase_and_frequency_are_those_of_the_closed_forms() {
    let cases = [
        ([10.0, 60.0], 30.0),
        ([60.0, 10.0], 30.0),
        ([5.0, 2000.0], 240.0),
        ([20.0, 20.5], 600.0),
        ([500.0, 2.0], 0.1),
    ];
    for law in [SweepLaw::Linear, SweepLaw::Logarithmic] {
        for (frequencies, seconds) in cases {
            let sweep = Sweep::<f64>::new(3.0, frequencies, seconds, law, 0.4).expect("valid");
            let narrow = frequencies.map(|frequency| frequency as f32);
            let narrow = Sweep::<f32>::new(3.0, narrow, seconds as f32, law, 0.4).expect("valid");
            for k in 0..300 {
                let instant = at(f64::from(k) * 0.013_7 * seconds);
                let time = instant.seconds::<f64>();
                let exact = TAU * turns(law, frequencies, seconds, time).fract() + 0.4;
                let found = sweep.acceleration(instant);
                // The closed form rounds its turns, and the library the time of the sweep to a tick.
                assert!((found - 3.0 * exact.sin()).abs() < 5e-8, "{law:?} {frequencies:?} {time}: {found}");
                let step = 1e-7 * seconds;
                let rate = (turns(law, frequencies, seconds, time + step)
                    - turns(law, frequencies, seconds, (time - step).max(0.0)))
                    / (step + time.min(step));
                let (_, angular, _) = sweep.place(instant);
                assert!((angular / (TAU * rate) - 1.0).abs() < 1e-4, "{law:?} {frequencies:?} {time}");
                let (_, single, _) = narrow.place(instant);
                let highest = TAU * frequencies[0].max(frequencies[1]);
                assert!((f64::from(single) - angular).abs() < 1e-6 * highest);
                if seconds.fract() == 0.0 {
                    // 30, 240 and 600 s and the frequencies are numbers of both precisions.
                    assert!((f64::from(narrow.acceleration(instant)) - found).abs() < 2e-6);
                }
            }
        }
    }
}

#[test]
fn a_sweep_loses_no_phase_in_a_simulated_day() {
    // A way has 35 s · 30 Hz = 1050 turns: after any number of them the phase is that of the start.
    let sweep = Sweep::<f64>::new(1.0, [10.0, 50.0], 35.0, SweepLaw::Linear, 0.0).expect("valid");
    for k in 0..50 {
        let time = f64::from(k) * 1.37;
        let late = at(time + 70.0 * 1234.0);
        assert!((sweep.acceleration(late) - sweep.acceleration(at(time))).abs() < 2e-8, "{k}");
    }
}

#[test]
fn an_oscillator_follows_a_sweep_through_its_resonance_and_back() {
    for (law, frequencies, seconds) in [
        (SweepLaw::Linear, [20.0, 45.0], 2.0),
        (SweepLaw::Logarithmic, [60.0, 15.0], 2.0),
        // 400 Hz in a second: the bend limits the steps.
        (SweepLaw::Linear, [5.0, 105.0], 0.25),
    ] {
        let sweep = Sweep::<f64>::new(3.0, frequencies, seconds, law, 0.4).expect("valid");
        let (mut motion, oscillator) = ([0.0; 2], oscillator(30.0, 0.02));
        let mut now = Instant::START;
        for until in [0.43, 0.97, 1.6, 2.9] {
            let next = at(until * seconds);
            advance(&sweep, &oscillator, &mut motion, [now, next]);
            now = next;
            let acceleration = |t| 3.0 * (TAU * turns(law, frequencies, seconds, t).fract() + 0.4).sin();
            let exact = by_small_steps(&oscillator, until * seconds, 200_000, acceleration);
            // Relative to the static deflection; at the resonance it is up to 25 times that, and so is the error.
            let own = TAU * 30.0;
            let error = (own * (motion[0] - exact[0])).hypot(motion[1] - exact[1]) / (3.0 / own);
            assert!(error < 1e-5, "{law:?} {until}: {error}");
        }
    }
}

#[test]
fn the_bits_are_those_recorded() {
    let mut found = [0; 4];
    for (found, law) in found.chunks_mut(2).zip([SweepLaw::Linear, SweepLaw::Logarithmic]) {
        let double = Sweep::<f64>::new(3.0, [10.0, 60.0], 30.0, law, 0.5).expect("valid");
        let narrow = Sweep::<f32>::new(3.0, [10.0, 60.0], 30.0, law, 0.5).expect("valid");
        let instants = || (0..2000).map(|k: u64| Instant::from_ticks(k * 98_765_432_109));
        found[0] = checksum(instants().map(|at| double.acceleration(at).to_bits()));
        found[1] = checksum(instants().map(|at| u64::from(narrow.acceleration(at).to_bits())));
    }
    let recorded =
        [0x4d30_44e8_a908_8aa1, 0x1559_3ba0_aada_fa29, 0xd923_ca4b_0e03_fc8c, 0xe3d5_3841_0307_3e4d];
    assert_eq!(found, recorded, "{found:x?}");
}

#[test]
fn arguments_out_of_range_are_named() {
    let new = |amplitude, frequencies, seconds, phase| {
        Sweep::<f64>::new(amplitude, frequencies, seconds, SweepLaw::Logarithmic, phase).err()
    };
    assert_eq!(new(1.0, [10.0, 20.0], 1.0, 0.0), None);
    assert_eq!(new(f64::NAN, [10.0, 20.0], 1.0, 0.0), Some(ExcitationError::Amplitude));
    for frequencies in
        [[0.0, 20.0], [10.0, 10.0], [10.0, 2e6], [f64::NAN, 10.0], [10.0, f64::NAN], [-1.0, 10.0]]
    {
        assert_eq!(new(1.0, frequencies, 1.0, 0.0), Some(ExcitationError::Frequency), "{frequencies:?}");
    }
    for seconds in [0.0, 1e-4, 2e5, f64::NAN] {
        assert_eq!(new(1.0, [10.0, 20.0], seconds, 0.0), Some(ExcitationError::Duration));
    }
    assert_eq!(new(1.0, [10.0, 20.0], 1.0, f64::INFINITY), Some(ExcitationError::Phase));
}

//! Shaking that is not steady from listen to listen, for twelve days. The plant yields what the map says, so that each error is
//! one of the node's filter.
//!
//! A modelled power that varies while the storage averages it must change neither the gain of the map nor the standing
//! power, and a storage that is full must not stay so.

use model_core::energy::ResponseMap;
use model_core::energy::cost::Processor;

use super::plant::{Plant, Run, Source, World};
use super::truth::{Kind, Shaking, tone};
use super::{Errors, INCOME, build, map};

const HOURS: usize = 300;
const FREQUENCY: f64 = 20.13;

/// A run with amplitudes between two values in m/s², each for `hold` minutes.
fn run([low, high]: [f64; 2], hold: usize, capacitance: f64, spread: f64) -> Run {
    let kind = Kind::ContactSeparation;
    let bytes = map(kind);
    let fingerprint = u32::from_le_bytes([bytes[6], bytes[7], bytes[8], bytes[9]]);
    let response = ResponseMap::new(bytes, fingerprint).expect("a map");
    let mut random = Source(5);
    let (mut minutes, mut shaking) = (Vec::new(), Vec::<Shaking>::new());
    while minutes.len() < 60 * HOURS {
        let amplitude = low * (high / low).powf(random.uniform());
        let power = response.at(amplitude as f32, FREQUENCY as f32).income().expect("inside").value;
        minutes.extend(std::iter::repeat_n(60.0 * f64::from(power), hold));
        shaking.extend(std::iter::repeat_n(tone(amplitude, FREQUENCY), hold));
    }
    let build = build(kind, Processor::nrf52832(), capacitance, spread);
    let node =
        build.node(bytes, build.income / (minutes.iter().sum::<f64>() / (60.0 * minutes.len() as f64)));
    let plant = Plant { standing: 1.0, action: 1.0 };
    World::new(&build, &node, (&minutes, &shaking), plant, 7).run(|state| state)
}

fn sum(run: &Run, of: fn(&super::Hour) -> f64) -> f64 {
    run.hours.iter().map(of).sum()
}

#[test]
fn what_changes_between_two_listens_moves_neither_the_gain_nor_the_draw() {
    for hold in [1, 3, 30] {
        for capacitance in [10e-3, 0.1] {
            for spread in [0.2, 0.01] {
                let run = run([0.37, 0.42], hold, capacitance, spread);
                let errors = Errors::of(run.hours.iter());
                let told = sum(&run, |hour| hour.told) / sum(&run, |hour| hour.truth);
                let ([gain, of_gain], [draw, of_draw]) = (run.state.gain(), run.state.excess_draw());
                println!(
                    "{hold} min, {capacitance} F, {spread}: inside {:.3}, bound {:.3}, told {told:.3}, gain {gain:.2} \
                     ± {of_gain:.2}, draw {draw:.1e} ± {of_draw:.1e}",
                    errors.inside, errors.bound
                );
                assert!(errors.inside >= 0.95 && (told - 1.0).abs() < 0.08, "{told} {}", errors.inside);
                // Two and a half deviations and a tenth.
                assert!((gain - 1.0).abs() <= of_gain + 0.1 && draw.abs() <= of_draw, "{gain} {draw}");
            }
        }
    }
}

#[test]
fn a_storage_that_is_full_is_used() {
    for hold in [1, 60, 600] {
        let run = run([0.37, 0.42], hold, 1e-3, 0.2);
        let errors = Errors::of(run.hours.iter());
        let spent = 0.3e-3 * f64::from(run.actions) / (INCOME * 3600.0 * HOURS as f64);
        let [gain, of_gain] = run.state.gain();
        println!(
            "{hold} min: inside {:.3}, bound {:.3}, {:.3} spent on actions, {:.3} shunted, gain {gain:.2} ± {of_gain:.2}",
            errors.inside, errors.bound, spent, run.shunted
        );
        assert!(errors.inside >= 0.95 && spent > 0.4, "{} {spent}", errors.inside);
        assert!((gain - 1.0).abs() <= of_gain + 0.1 && of_gain < 1.0, "{gain} ± {of_gain}");
    }
}

//! The schedule of listens, on random incomes whose true energy is known.

use crate::common::Random;
use model_core::energy::{Heard, Listening, ListeningParameters, ListeningState};
use model_core::scalar::Scalar;

/// Seconds between two values of an income.
const STEP: u32 = 30;
/// Energy of a listen in J: 160 samples at 400 Hz, of an accelerometer of 6 µW and a Cortex-M4F.
const COST: f64 = 4e-6;
/// Mean power in W.
const MEAN: f64 = 2.9e-6;

fn schedule<S: Scalar>() -> Listening<S> {
    let parameters = ListeningParameters {
        share: S::from_f64(0.01),
        error: S::from_f64(0.02),
        horizon: S::from_f64(3600.0),
        shortest: STEP,
        doublings: 8,
    };
    parameters.build().expect("within the bounds")
}

/// A day and a half of a stationary process with an exponential correlation, in steps; not negative.
fn correlated(random: &mut Random, spread: f64, time_constant: f64) -> Vec<f64> {
    let kept = (-f64::from(STEP) / time_constant).exp();
    let mut state = random.normal();
    (0..4320)
        .map(|_| {
            state = kept * state + (1.0 - kept * kept).sqrt() * random.normal();
            MEAN * (1.0 + spread * state).max(0.0)
        })
        .collect()
}

/// A machine that runs and rests for random times of a mean of `dwell` s.
fn switched(random: &mut Random, dwell: f64) -> Vec<f64> {
    let mut on = random.unit() < 0.5;
    (0..4320)
        .map(|_| {
            on ^= random.unit() < f64::from(STEP) / dwell;
            if on { 2.0 * MEAN } else { 0.0 }
        })
        .collect()
}

/// Draws the powers of an income.
type Income = fn(&mut Random) -> Vec<f64>;

/// True energy in J from step `from` to step `to` of a power that is linear between its values.
fn energy(powers: &[f64], from: usize, to: usize) -> f64 {
    powers[from..=to].windows(2).map(|pair| 0.5 * (pair[0] + pair[1]) * f64::from(STEP)).sum()
}

/// What became of a schedule on an income.
struct Outcome {
    /// Energy of the listens over the energy of the income.
    share: f64,
    /// Error of each stretch of an hour, over its stated deviation.
    normalised: Vec<f64>,
    /// Error of each stretch of an hour, over the mean energy of an hour.
    relative: Vec<f64>,
}

/// Listens after the first `skipped` steps, in which the schedule learns, where it is asked each `poll` steps.
fn follow<S: Scalar>(powers: &[f64], skipped: usize, (listening, poll): (Listening<S>, usize)) -> Outcome {
    let mut state: ListeningState<S> = listening.start();
    let (mut listens, mut last) = (0, 0);
    let mut outcome = Outcome { share: 0.0, normalised: Vec::new(), relative: Vec::new() };
    let (mut begun, mut sum, mut variance) = (None, 0.0, 0.0);
    for now in (0..powers.len()).step_by(poll) {
        let elapsed = (now - last) as u32 * STEP;
        if !listening.is_due(&state, elapsed, S::ZERO) {
            continue;
        }
        let power = S::from_f64(powers[now]);
        let heard = listening.hear(&mut state, elapsed, power, S::ZERO, S::from_f64(COST));
        last = now;
        if now < skipped {
            continue;
        }
        listens += 1;
        let (Some(start), Some(Heard { energy: found, deviation })) = (begun, heard) else {
            begun = Some(now);
            continue;
        };
        sum += found.to_f64();
        variance += deviation.to_f64().powi(2);
        let hours = (now - start) as f64 * f64::from(STEP) / 3600.0;
        if hours >= 1.0 {
            let error = (sum - energy(powers, start, now)).abs();
            outcome.normalised.push(error / variance.sqrt().max(1e-12));
            outcome.relative.push(error / (MEAN * 3600.0 * hours));
            (begun, sum, variance) = (Some(now), 0.0, 0.0);
        }
    }
    outcome.share = f64::from(listens) * COST / energy(powers, skipped, powers.len() - 1);
    outcome
}

/// Part of `values` that are at most `bound`.
fn within(values: &[f64], bound: f64) -> f64 {
    values.iter().filter(|&&value| value <= bound).count() as f64 / values.len() as f64
}

#[test]
fn the_stated_bound_of_two_deviations_holds_in_95_of_100_hours() {
    let mut random = Random(15);
    let incomes: [(&str, Income); 5] = [
        ("minutes", |random| correlated(random, 0.2, 600.0)),
        ("hours", |random| correlated(random, 0.3, 7200.0)),
        ("half a day", |random| correlated(random, 0.3, 43_200.0)),
        ("switched each hour", |random| switched(random, 3600.0)),
        ("switched each four hours", |random| switched(random, 14_400.0)),
    ];
    for (what, income) in incomes {
        let (mut normalised, mut relative, mut share) = (Vec::new(), Vec::new(), 0.0);
        for _ in 0..40 {
            let outcome = follow::<f32>(&income(&mut random), 720, (schedule(), 1));
            normalised.extend(outcome.normalised);
            relative.extend(outcome.relative);
            share += outcome.share / 40.0;
        }
        relative.sort_by(f64::total_cmp);
        let median = relative[relative.len() / 2];
        println!(
            "{what}: {:.3} within, share {share:.4}, median error {median:.4}",
            within(&normalised, 2.0)
        );
        assert!(within(&normalised, 2.0) >= 0.95, "{what}");
        assert!(share < 0.0125, "{what}: {share}");
    }
}

#[test]
fn the_bound_holds_in_nine_of_ten_hours_where_every_listen_is_late() {
    let parameters =
        ListeningParameters { share: 0.01, error: 0.02, horizon: 3600.0, shortest: STEP, doublings: 0 };
    let mut random = Random(16);
    for (time_constant, poll) in [(60.0, 8), (600.0, 8), (600.0, 20)] {
        let mut normalised = Vec::new();
        for _ in 0..20 {
            let powers = correlated(&mut random, 0.3, time_constant);
            let listening = parameters.build().expect("within the bounds");
            normalised.extend(follow::<f32>(&powers, 720, (listening, poll)).normalised);
        }
        let part = within(&normalised, 2.0);
        println!("{time_constant} s, each {poll} steps: {part:.3} within");
        assert!(part >= 0.9, "{time_constant} s, each {poll} steps: {part}");
    }
}

#[test]
fn a_steady_income_is_listened_to_ever_more_rarely() {
    let listening = schedule::<f32>();
    let mut state = listening.start();
    assert!(listening.is_due(&state, 0, 0.0));
    let mut intervals = Vec::new();
    for _ in 0..60 {
        let elapsed = listening.interval(&state);
        assert!(!listening.is_due(&state, elapsed - 1, 0.0) || state == listening.start());
        listening.hear(&mut state, elapsed, 3e-6, 1e-8, 1e-7);
        intervals.push(listening.interval(&state));
    }
    assert!(intervals.is_sorted(), "{intervals:?}");
    assert_eq!(intervals.last(), Some(&(STEP << 8)));
    // A change of the income ends that.
    let before = listening.interval(&state);
    listening.hear(&mut state, before, 1e-6, 1e-8, 1e-7);
    assert!(listening.interval(&state) < before);
}

#[test]
fn the_interval_is_not_shorter_than_the_cost_allows() {
    // 1 % of 2.9 µW pays for 4 µJ each 138 s: the next power of two of 30 s is 240 s.
    let outcome = follow::<f64>(&correlated(&mut Random(3), 0.5, 60.0), 720, (schedule(), 1));
    let bound = 0.01 * 138.0 / 240.0;
    assert!((outcome.share - bound).abs() < 0.3 * bound, "{}", outcome.share);
}

#[test]
fn a_surprise_calls_for_a_listen_as_often_as_its_cost_is_saved() {
    let listening = schedule::<f64>();
    let mut state = listening.start();
    for _ in 0..20 {
        let elapsed = listening.interval(&state);
        listening.hear(&mut state, elapsed, 3e-6, 1e-7, COST);
    }
    let interval = listening.interval(&state);
    assert!(interval >= 240 && !listening.is_due(&state, interval / 2, 2.9));
    assert!(listening.is_due(&state, interval / 2, 3.1));
    // Surprises one after the other: what was saved is spent after two of them.
    let mut early = 0;
    while listening.is_due(&state, STEP, 10.0) && listening.interval(&state) > STEP {
        listening.hear(&mut state, STEP, 3e-6, 1e-7, COST);
        early += 1;
        assert!(early < 4, "surprises cost without end");
    }
    assert!(early >= 1);
}

#[test]
fn numbers_that_are_no_powers_are_refused() {
    let listening = schedule::<f32>();
    let mut state = listening.start();
    listening.hear(&mut state, 0, 3e-6, 0.0, 1e-6);
    let before = state;
    for bad in [f32::NAN, f32::INFINITY, -1.0, 2e9] {
        assert_eq!(listening.hear(&mut state, 60, bad, 0.0, 1e-6), None);
        assert_eq!(listening.hear(&mut state, 60, 1e-6, bad, 1e-6), None);
        assert_eq!(listening.hear(&mut state, 60, 1e-6, 0.0, bad), None);
        assert_eq!(state, before);
    }
    let parameters =
        ListeningParameters { share: 0.0_f32, error: 0.02, horizon: 3600.0, shortest: 60, doublings: 4 };
    assert_eq!(parameters.build().map_err(|error| error.field), Err("share"));
    let parameters =
        ListeningParameters { share: 0.01_f32, error: 0.02, horizon: 3600.0, shortest: 0, doublings: 4 };
    assert_eq!(parameters.build().map_err(|error| error.field), Err("shortest"));
}

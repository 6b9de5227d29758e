//! The filter against closed forms of its covariances, and over random incomes.

use super::covariance::{ALL, POWER};
use super::filter::{Filter, FilterState, Growth, StoreReading};
use super::heard::PowerMeasurement;
use crate::energy::{Capacitor, Storage, StorageParameters};
use crate::scalar::Scalar;
use crate::snapshot;

/// Random numbers by SplitMix64.
#[derive(Debug, Clone, Copy)]
pub(super) struct Random(pub(super) u64);

impl Random {
    /// Even from 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normal with the variance 1, as the sum of twelve.
    pub(super) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform() - 0.5).sum()
    }
}

/// The growth of a power that walks.
pub(super) fn only<S: Scalar>(walk: S) -> Growth<S> {
    Growth { power: walk, income: S::ZERO }
}

/// A modelled power that lasts, and is not known to follow the one before.
fn steady(modelled: f64, deviation: f64) -> PowerMeasurement<f64> {
    PowerMeasurement {
        modelled,
        lasting: modelled,
        change: 0.0,
        variance: deviation * deviation,
        of_gain: 1.0,
    }
}

pub(super) const CELL: f64 = 5.0 / 4096.0;

pub(super) fn storage<S: Scalar>(capacitance: S) -> Storage<S> {
    StorageParameters {
        capacitor: Capacitor { capacitance, leakage_resistance: S::INFINITY },
        charging_efficiency: S::ONE,
        discharging_efficiency: S::ONE,
        highest_voltage: S::from_f64(4.9),
        lock_out_voltage: S::ONE,
        turn_on_voltage: S::from_f64(2.0),
    }
    .build()
    .expect("within bounds")
}

pub(super) fn filter(capacitance: f64) -> Filter<f64> {
    Filter {
        storage: storage(capacitance),
        standing: 1e-6,
        standing_variance: 0.0,
        draw_drift: 0.0,
        spent: 0.0,
        cell: CELL,
        noise: 0.5 * CELL,
        lasting: 0.0,
        full_code: 4095,
        gain_variance: 1.0,
        gain_drift: 0.0,
        power: 1e-4,
    }
}

fn code(voltage: f64) -> u32 {
    (voltage / CELL).round() as u32
}

#[test]
fn between_two_listens_the_income_is_the_trapezoid_with_the_variance_of_the_walk() {
    // Without a reading, and with a gain that is known.
    let filter = Filter { gain_variance: 0.0, ..filter(1e-3) };
    let (walk, time) = (1e-16, 600);
    let mut state = filter.start();
    filter.hear(&mut state, 0, steady(3e-6, 0.0));
    state.close_hour();
    for _ in 0..10 {
        filter.predict(&mut state, time / 10, true, 0.0, only(walk));
    }
    let t = f64::from(time);
    let held = state.hour();
    assert!((held.mean / (3e-6 * t) - 1.0).abs() < 1e-9);
    assert!((held.deviation() / (walk * t * t * t / 3.0).sqrt() - 1.0).abs() < 1e-3, "{held:?}");
    filter.hear(&mut state, time, steady(3.2e-6, 0.0));
    let found = state.hour();
    assert!((found.mean / (0.5 * (3e-6 + 3.2e-6) * t) - 1.0).abs() < 1e-9, "{found:?}");
    assert!((found.deviation() / (walk * t * t * t / 12.0).sqrt() - 1.0).abs() < 1e-3, "{found:?}");
}

#[test]
fn two_readings_know_the_income_to_the_error_of_both() {
    // √2 ΔV C V, the contract of an instrument of energy.
    let filter = filter(1e-3);
    let mut state = filter.start();
    filter.observe(&mut state, code(3.0), false);
    state.close_hour();
    filter.predict(&mut state, 3600, true, 0.0, only(1e-12));
    let end = (9.0 + 2.0 * (1.5e-6 - 1e-6) * 3600.0 / 1e-3_f64).sqrt();
    filter.observe(&mut state, code(end), false);
    let hour = state.hour();
    let of_reading = (CELL * CELL / 12.0 + 0.25 * CELL * CELL).sqrt();
    let expected = of_reading * 1e-3 * (9.0 + end * end).sqrt();
    assert!((hour.mean - 1.5e-6 * 3600.0).abs() < 3.0 * hour.deviation(), "{hour:?}");
    assert!((hour.deviation() / expected - 1.0).abs() < 0.1, "{hour:?} {expected}");
}

#[test]
fn of_an_income_that_jumps_in_an_hour_without_a_reading_what_leaks_is_told_too() {
    // 47 mF behind 4 MΩ lose 2 % of an even income in the hour in which it comes.
    let capacitor = Capacitor { capacitance: 47e-3, leakage_resistance: 4e6 };
    let lossy = StorageParameters { capacitor, charging_efficiency: 0.8, ..*storage(47e-3).parameters() };
    // The power is known to be small.
    let filter = Filter { storage: lossy.build().expect("within bounds"), power: 1e-9, ..filter(47e-3) };
    let (power, start, seconds) = (45e-6, 2.3_f64, 3600.0);
    let ratio = 2.0 * seconds / (47e-3 * 4e6);
    let kept = f64::exp(-ratio);
    let net = (0.8 * power - filter.standing) * seconds;
    let end = 0.5 * 47e-3 * start * start * kept + net * (1.0 - kept) / ratio;
    let last = (2.0 * end / 47e-3).sqrt();
    // What the cells of both readings are off by.
    let off = f64::from(code(last)) * CELL - last - (f64::from(code(start)) * CELL - start);
    let mut state = filter.start();
    filter.observe(&mut state, code(start), false);
    state.close_hour();
    filter.predict(&mut state, 3600, true, 0.0, only(1e-20));
    state.confirm();
    assert_eq!(filter.observe(&mut state, code(last), false).0, StoreReading::Jump);
    let told = state.hour();
    let of_cells = off.abs() * 47e-3 * last / 0.8;
    let departure = (told.mean - power * seconds).abs();
    assert!(departure < of_cells + 1e-3 * power * seconds, "{departure} {told:?}");
    assert!(departure < 2.5 * told.deviation(), "{departure} {told:?}");
}

#[test]
fn a_listen_learns_the_gain_from_a_power_that_the_storage_has_shown() {
    let filter = filter(4e-3);
    let mut state = filter.start();
    let (mut random, mut energy) = (Random(7), 0.5 * 4e-3 * 9.0_f64);
    for minute in 0..600 {
        if minute % 10 == 0 {
            filter.hear(&mut state, 600, steady(4e-6, 4e-8));
        }
        energy += (1.7 * 4e-6 - 1e-6) * 60.0;
        let spent = if minute % 60 == 59 { 0.02 } else { 0.0 };
        energy -= spent;
        filter.predict(&mut state, 60, true, spent, only(1e-19));
        let before = state.gain();
        filter.observe(&mut state, code((2.0 * energy / 4e-3).sqrt() + 0.5 * CELL * random.normal()), false);
        assert_eq!(state.gain().mean, before.mean, "a reading alone may be of another shaking");
    }
    let gain = state.gain();
    assert!((gain.mean - 1.7).abs() < 3.0 * gain.deviation() && gain.deviation() < 0.05, "{gain:?}");
}

#[test]
fn the_draw_is_learnt_while_the_harvester_rests() {
    let filter = Filter { standing_variance: 0.09e-12, ..filter(1e-3) };
    let mut state = filter.start();
    let mut energy = 0.5e-3 * 9.0_f64;
    let mut random = Random(3);
    for minute in 0..180 {
        // In the first hour the harvester yields a power that nothing tells.
        let power = if minute < 60 { 3e-6 } else { 0.0 };
        energy += (power - 1.25e-6) * 60.0;
        filter.predict(&mut state, 60, true, 0.0, only(1e-17));
        if minute == 60 {
            state.widen_power(1e-11);
            // The income less the draw is known, neither of them alone.
            assert!(state.draw().deviation() > 0.29e-6, "{:?}", state.draw());
        }
        if minute >= 60 && minute % 10 == 0 {
            filter.hear(&mut state, 600, steady(0.0, 1e-9));
        }
        filter.observe(&mut state, code((2e3 * energy).sqrt() + 0.5 * CELL * random.normal()), false);
    }
    let draw = state.draw();
    assert!(draw.deviation() < 0.03e-6 && (draw.mean - 0.25e-6).abs() < 3.0 * draw.deviation(), "{draw:?}");
}

#[test]
fn a_full_storage_says_nothing_about_the_income() {
    let filter = filter(1e-3);
    let mut state = filter.start();
    filter.hear(&mut state, 0, steady(4e-6, 0.0));
    let (before, power) = (state.gain(), state.power().mean);
    for _ in 0..50 {
        filter.predict(&mut state, 60, true, 0.0, only(0.0));
        assert_eq!(filter.observe(&mut state, code(4.9), true).0, StoreReading::Silent);
        assert!(state.was_full());
    }
    let after = state.gain();
    assert!((after.mean - before.mean).abs() < 1e-12 && after.deviation() >= before.deviation(), "{after:?}");
    assert!((state.all().mean - power * 3000.0).abs() < 1e-9);
}

#[test]
fn of_two_new_motions_the_power_covers_both_whatever_was_known() {
    for (before, of_before) in [(4e-6, 1e-7), (10e-6, 1e-7), (16e-6, 1e-7), (40e-6, 1e-6), (0.0, 1e-9)] {
        for gain_variance in [0.0, 0.01, 0.25] {
            let filter = Filter { gain_variance, ..filter(1e-3) };
            let mut state = filter.start();
            filter.hear(&mut state, 0, PowerMeasurement { of_gain: 0.0, ..steady(before, of_before) });
            filter.predict(&mut state, 600, true, 0.0, only(1e-20));
            let gain = state.gain();
            filter.hear_either(&mut state, 600, [16e-6, 8e-6]);
            let power = state.power();
            for possible in [8e-6, 24e-6] {
                let departure = (power.mean - possible).abs();
                assert!(departure <= 2.5 * power.deviation(), "{before} W: {power:?} {possible} W");
            }
            assert!(power.deviation() < 30e-6, "{power:?}");
            assert_eq!(state.gain().mean, gain.mean);
            assert!((state.gain().variance - gain.variance).abs() <= 1e-9 * gain.variance);
        }
    }
}

/// A filter at 3 V, a minute after its last reading, and what it says of these codes, one a second.
fn after(codes: &[u32]) -> (FilterState<f64>, Vec<StoreReading>) {
    // Of a power that is known to a microwatt: a minute is uncertain by 16 codes.
    let filter = Filter { power: 1e-6, ..filter(1e-3) };
    let mut state = filter.start();
    filter.observe(&mut state, code(3.0), false);
    filter.predict(&mut state, 59, true, 0.0, only(1e-19));
    let read = codes.iter().map(|&code| {
        filter.predict(&mut state, 1, true, 0.0, only(1e-19));
        filter.observe(&mut state, code, false).0
    });
    let read = read.collect();
    (state, read)
}

#[test]
fn a_doubted_reading_is_confirmed_by_one_like_it_and_by_no_other() {
    use StoreReading::{Jump, Refused, Used};
    let steady = code(3.0);
    for (codes, expected) in [
        // Two readings that agree are a jump, in either direction and as it goes on.
        (vec![2000, 2001], vec![Refused, Jump]),
        (vec![3200, 3300], vec![Refused, Jump]),
        // One at the end of the converter, or elsewhere, confirms no glitch.
        (vec![4095, 500, steady], vec![Refused, Refused, Used]),
        (vec![500, 4095, steady], vec![Refused, Refused, Used]),
        (vec![500, 3800, steady], vec![Refused, Refused, Used]),
        (vec![3800, 500, 4095, 500, steady], vec![Refused, Refused, Refused, Refused, Used]),
        // Nothing confirms a code of 0.
        (vec![0, 0, steady], vec![Refused, Refused, Used]),
    ] {
        let (state, read) = after(&codes);
        assert_eq!(read, expected, "{codes:?}");
        assert!(state.is_located() && !state.is_doubted(), "{codes:?}");
    }
}

#[test]
fn two_readings_at_the_end_of_the_converter_say_that_the_storage_may_be_full() {
    let (state, read) = after(&[4095, 4095]);
    assert_eq!(read, [StoreReading::Refused, StoreReading::Silent]);
    assert!(state.is_located() && state.was_full());
    // At the start too.
    let filter = filter(1e-3);
    let mut state = filter.start();
    assert_eq!(filter.observe(&mut state, 4095, false).0, StoreReading::Refused);
    assert!(!state.is_located() && state.is_doubted());
    assert_eq!(filter.observe(&mut state, 4095, false).0, StoreReading::Silent);
    assert!(state.is_located() && state.was_full() && !state.is_doubted());
    let [capacity, stored] = [filter.storage.capacity(), state.store().mean];
    assert!((stored / capacity - 1.0).abs() < 1e-9, "{stored} {capacity}");
}

/// A random walk of the power; gives squares of errors in deviations, and shares within two, of each hour.
fn hours(capacitance: f64, listen_every: u32, cases: u64) -> (f64, f64, f64) {
    let (mut squares, mut inside, mut count, mut relative) = (0.0, 0.0, 0.0, 0.0);
    for case in 0..cases {
        let mut random = Random(case + 1);
        let filter = Filter { gain_variance: 0.25, standing_variance: 0.04e-12, ..filter(capacitance) };
        let (gain, draw) =
            (1.0 + 0.4 * random.normal().clamp(-2.0, 2.0), 1e-6 * (1.0 + 0.2 * random.normal()));
        let walk: f64 = 1e-16;
        let (mut power, mut energy) = (6e-6_f64, 0.5 * capacitance * 9.0);
        let mut state: FilterState<f64> = filter.start();
        filter.observe(&mut state, code(3.0), false);
        let mut income = 0.0;
        for minute in 1..=240_u32 {
            if (minute - 1) % listen_every == 0 {
                filter.hear(&mut state, 60 * listen_every, steady(power / gain, 0.0));
            }
            for _ in 0..60 {
                power = (power + walk.sqrt() * random.normal()).max(1e-6);
                income += power;
                energy += power - draw;
            }
            filter.predict(&mut state, 60, true, 0.0, only(walk));
            filter.observe(
                &mut state,
                code((2.0 * energy / capacitance).sqrt() + 0.5 * CELL * random.normal()),
                false,
            );
            // Spend what came in, so that the storage does not fill up.
            if minute % 60 == 0 {
                let hour = state.hour();
                let error = hour.mean - income;
                squares += (error / hour.deviation()).powi(2);
                inside += f64::from(error.abs() <= 2.0 * hour.deviation());
                relative += (error / income).abs();
                count += 1.0;
                state.close_hour();
                income = 0.0;
                filter.predict(&mut state, 0, true, 0.01, only(0.0));
                energy -= 0.01;
            }
        }
    }
    (inside / count, (squares / count).sqrt(), relative / count)
}

#[test]
fn the_stated_deviation_is_that_of_the_errors_over_random_incomes() {
    for (capacitance, listen_every) in [(10e-3, 10), (0.1, 10), (0.1, 30)] {
        let (inside, ratio, relative) = hours(capacitance, listen_every, 100);
        println!("{capacitance} F, {listen_every} min: {inside} {ratio} {relative}");
        assert!(inside > 0.92 && (0.6..1.2).contains(&ratio), "{capacitance}: {inside} {ratio} {relative}");
    }
}

#[test]
fn an_image_takes_the_state_of_a_filter_that_has_known_nothing_for_years() {
    // A harvester of up to 1 kW in a storage that cannot be read, and a jump as large as a number.
    let filter = Filter { power: 1e3, ..filter(1e-3) };
    for (jump, days) in [(0.0, 1), (0.0, 3650), (1e16, 1), (1e30, 1)] {
        let mut state = filter.start();
        state.widen_power(jump);
        for _ in 0..days {
            filter.predict(&mut state, 86_400, true, 0.0, only(1e-3));
        }
        let mut bytes = [0; 512];
        snapshot::save(&state, 0, &mut bytes).expect("room");
        assert_eq!(snapshot::restore(0, &bytes), Ok(state), "{jump} {days}");
        assert!(state.power().deviation() > 5e2 && state.all().deviation() > 9e6, "{:?}", state.all());
        // The power and its integral stay correlated.
        let [power, all] = [POWER, ALL].map(|index| state.covariance.variance(index));
        let correlation = state.covariance.row(POWER)[ALL] / (power * all).sqrt();
        assert!(correlation > 0.8 && correlation <= 1.0 + 1e-9, "{correlation}");
    }
}

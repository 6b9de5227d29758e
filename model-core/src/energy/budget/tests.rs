use super::super::storage::tests::example;
use super::*;
use crate::part::storage::Capacitor;

fn budget<S: Scalar>() -> Budget<S, 48> {
    with(example())
}

fn with<S: Scalar>(storage: StorageParameters<S>) -> Budget<S, 48> {
    let income = IncomeParameters { time_constant: S::from_f64(7200.0), day_weight: S::from_f64(0.5) };
    let parameters = BudgetParameters { storage, income, standing_power: S::from_f64(2e-6) };
    parameters.build().expect("within bounds")
}

/// Capacities of ten times the income of a day, and of a fiftieth of it.
fn storages<S: Scalar>() -> [StorageParameters<S>; 2] {
    let large = StorageParameters {
        capacitor: Capacitor { capacitance: S::from_f64(1.0), leakage_resistance: S::from_f64(1e6) },
        ..example()
    };
    [large, example()]
}

/// A day of updates of `interval` seconds with an uneven income, and an action every ten minutes.
fn day<S: Scalar>(budget: &Budget<S, 48>, interval: u32) -> BudgetState<S, 48> {
    let mut state = budget.start(0);
    budget.correct(&mut state, S::from_f64(0.5) * budget.storage.capacity(), S::ZERO);
    for k in 0..86_400 / interval {
        let (minute, seconds) = (k * interval / 60, S::from_u32(interval));
        // Up to 60 µW: the storage is full at times, and nearly empty at others.
        let income = S::from_u32((k * 7919) % 101 * (minute / 120 % 3)) * S::from_f64(3e-7) * seconds;
        let spent = if (k * interval) % 600 < interval { S::from_f64(6e-3) } else { S::ZERO };
        budget.update(&mut state, interval, income, spent);
    }
    state
}

#[test]
fn single_precision_ends_a_day_where_double_does() {
    for (narrow, wide) in storages().into_iter().zip(storages()) {
        for interval in [60, 1] {
            let capacity = with(wide).storage().capacity();
            let (single, double) = (day(&with::<f32>(narrow), interval), day(&with::<f64>(wide), interval));
            let off = |a: f32, b: f64| (f64::from(a) - b).abs() / capacity;
            println!(
                "{capacity:.4} J, {interval} s: {:.1e} of the capacity off, {:.1e} and {:.1e} uncertain",
                off(single.energy(), double.energy()),
                f64::from(single.uncertainty) / capacity,
                double.uncertainty / capacity,
            );
            assert!(off(single.energy(), double.energy()) < 3e-7, "{capacity} J, {interval} s");
        }
    }
}

#[test]
fn the_account_adds_up_to_what_is_in_the_store() {
    for (storage, interval) in storages().into_iter().flat_map(|storage| [(storage, 60), (storage, 1)]) {
        let state = day(&with::<f32>(storage), interval);
        let account = state.account();
        let turned_over = account.income + account.corrected;
        let off = (account.balance - state.energy()).abs() / turned_over;
        println!(
            "{} F, {interval} s: {off:.1e} of what came in is not accounted for",
            storage.capacitor.capacitance
        );
        assert!(off < 1e-6 && account.leaked > 0.0, "{interval}: {account:?}");
    }
    let account = day(&budget::<f32>(), 60).account();
    assert!(account.shunted > 0.0 && account.unserved > 0.0);
}

#[test]
fn an_action_is_affordable_down_to_the_last_microjoule() {
    let budget = budget::<f64>();
    let storage = budget.storage();
    let action = Action::new("transmit", 300e-6, 2.0).expect("finite");
    let after = |seconds: f64| (-2.0 * seconds / (220e-6 * 10e6)).exp();
    let cost = |seconds: f64| (300e-6 + 2e-6 * seconds) / 0.9;
    let mut state = budget.start(100);
    assert!(!budget.can_afford(&state, &action, 100), "nothing is known");
    for (now, seconds) in [(100, 2.0), (130, 32.0), (90, 2.0)] {
        let just = (storage.lock_out() + cost(seconds)) / after(seconds);
        for (energy, expected) in [(just + 1e-9, true), (just - 1e-9, false)] {
            budget.correct(&mut state, energy, 0.0);
            assert_eq!(budget.can_afford(&state, &action, now), expected);
            // Uncertain energy and spent energy do not count.
            budget.correct(&mut state, energy + 1e-5, 1e-5);
            assert_eq!(budget.can_afford(&state, &action, now), expected);
            budget.correct(&mut state, energy, 0.0);
            state.raise_uncertainty(1e-8);
            assert!(!budget.can_afford(&state, &action, now));
            budget.correct(&mut state, energy + 1e-4, 0.0);
            budget.spend(&mut state, 0.9 * 1e-4 / after(seconds).recip());
            assert_eq!(budget.can_afford(&state, &action, now), expected);
        }
    }
}

#[test]
fn the_lower_end_is_that_of_all_income_first_and_all_expenditure_last() {
    let storage = StorageParameters {
        capacitor: Capacitor { leakage_resistance: 500e3, ..example::<f64>().capacitor },
        ..example::<f64>()
    };
    let budget = with(storage);
    let remaining = (-2.0 * 60.0 / (500e3 * 220e-6_f64)).exp();
    let capacity = budget.storage().capacity();
    // With room for the income and without, and down to the lock-out.
    for (start, income, spent) in [(1.5e-3, 2e-4, 1e-4), (2.2e-3, 9e-4, 2e-4), (1.2e-3, 0.0, 9e-4)] {
        let mut state = budget.start(0);
        budget.correct(&mut state, start, 1e-5);
        budget.update(&mut state, 60, income / 0.8, spent * 0.9);
        let least = start - 1e-5 + income;
        let expected = (least.min(capacity) * remaining - spent - 2e-6 * 60.0 / 0.9)
            .max(least.min(budget.storage().lock_out()) * remaining);
        assert!((state.certain_energy() - expected).abs() < 1e-14, "{start}: {state:?} {expected:e}");
    }
}

#[test]
fn what_is_no_amount_of_energy_is_refused_and_never_helps() {
    let budget = budget::<f32>();
    let action = Action::new("measure", 1e-6, 0.1).expect("finite");
    for wrong in [f32::NAN, f32::INFINITY, -1.0] {
        let mut state = budget.start(0);
        budget.correct_by_voltage(&mut state, 4.0, 0.01);
        budget.update(&mut state, 60, wrong, 0.0);
        assert!(budget.can_afford(&state, &action, 60) && state.account().income == 0.0);
        let mut blind = state;
        budget.update(&mut blind, 60, 0.0, wrong);
        assert!(!budget.can_afford(&blind, &action, 120), "it may have emptied the storage");
        let mut doubtful = state;
        doubtful.raise_uncertainty(wrong);
        assert!(!budget.can_afford(&doubtful, &action, 60));
        let mut unmeasured = state;
        budget.correct(&mut unmeasured, wrong, 0.0);
        assert_eq!(unmeasured.energy(), state.energy());
        for refused in [blind, doubtful, unmeasured] {
            assert_eq!(refused.account().refused, 2);
        }
        assert!(Action::new("wrong", wrong, 0.0).is_err() && Action::new("wrong", 0.0, wrong).is_err());
    }
}

#[test]
fn a_reading_that_is_none_is_refused() {
    let budget = budget::<f32>();
    let mut state = budget.start(0);
    budget.correct_by_voltage(&mut state, 3.0, 2e-3);
    let sound = state;
    let pegged = 1.1 * budget.storage().parameters().highest_voltage;
    for (voltage, error) in
        [(f32::INFINITY, 2e-3), (f32::NAN, 2e-3), (-0.1, 2e-3), (3.0, -1e-3), (3.0, f32::NAN), (pegged, 2e-3)]
    {
        budget.correct_by_voltage(&mut state, voltage, error);
        assert_eq!(state.energy(), sound.energy(), "{voltage} {error}");
        assert_eq!(state.certain_energy(), sound.certain_energy(), "{voltage} {error}");
    }
    assert_eq!(state.account().refused, 6);
}

//! The published measurements: the bounds within which the models meet them, and the numbers of other derivations.

use cross_crate_tests::assert_close;
use host_bench::validation::{Figure, figures};

fn figure<'a>(all: &'a [Figure], quantity: &str, start: Option<&str>) -> &'a Figure {
    let found = all.iter().find(|figure| figure.quantity.starts_with(quantity) && figure.start == start);
    found.unwrap_or_else(|| panic!("{quantity}"))
}

/// Capacitances in F apart and in touch, and the frequency in Hz.
const DEVICE: ([f64; 2], f64) = ([24e-12, 96e-12], 1.7);

/// Power in W into an empty capacitor in each of eight cycles by the balance of charge: a stroke moves what is left of `whole` in C
/// behind the charge of the device at the voltage of the capacitor, to one side and to the other. `charge` is that at the
/// start in touch.
fn cycles(capacitance: f64, whole: f64, charge: f64) -> Vec<f64> {
    let ([apart, touch], frequency) = DEVICE;
    let mut voltage = charge / (capacitance + touch);
    let mut held = touch * voltage;
    // The capacitor is empty before the charge of the start.
    let mut energy = 0.0;
    let mut stroke = |voltage: &mut f64, pushed: f64, device: f64, sign: f64| {
        let after = (pushed + sign * -held + capacitance * *voltage) / (capacitance + device);
        if after > *voltage {
            *voltage = after;
            held = if sign > 0.0 { whole - device * after } else { device * after };
        }
    };
    let mut powers = Vec::new();
    for _ in 0..8 {
        stroke(&mut voltage, whole, apart, 1.0);
        stroke(&mut voltage, 0.0, touch, -1.0);
        let after = 0.5 * capacitance * voltage * voltage;
        powers.push((after - energy) * frequency);
        energy = after;
    }
    powers
}

#[test]
fn the_published_figures_are_met_within_their_bounds() {
    let all = figures().expect("the shipped scenes run");
    // Relative bounds of what the one-mode theory is off itself, and our own numbers by another program with four modes.
    for (quantity, bound, other, tolerance) in [
        ("short-circuit resonance", 0.01, 45.705, 1e-4),
        ("short-circuit best load", 0.12, 36.10e3, 1e-3),
        ("short-circuit peak power", 0.04, 24.282e-3, 1e-3),
        ("open-circuit resonance", 0.01, 48.115, 1e-4),
        ("open-circuit best load", 0.12, 166.92e3, 1e-3),
        ("open-circuit peak power", 0.04, 24.329e-3, 1e-3),
    ] {
        let found = figure(&all, quantity, None);
        assert!(found.relative_difference.abs() < bound && !found.fitted, "{found:?}");
        assert_close(quantity, found.ours, other, tolerance);
        assert_close(quantity, 1.0 + found.relative_difference, found.ours / found.measured, 1e-12);
    }
    let touch = |quantity: &str| figure(&all, quantity, Some("touch"));
    assert!(touch("power in cycle 2, 1.7 Hz").fitted);
    assert_eq!(all.iter().filter(|figure| figure.fitted).count(), 1);
    assert_close("fitted", touch("power in cycle 2, 1.7 Hz").ours, 900e-9, 2e-3);
    assert_close("5 Hz", touch("power in cycle 2, 5 Hz").ours, 2.7e-6, 0.03);
    assert_eq!(touch("cycle of most power, 390 pF").ours, 2.0);
    assert_eq!(touch("cycle of most power, 2.2 nF").ours, 7.0);
    assert_close("best capacitor", touch("best capacitor").ours, 390e-12, 0.35);
    // What the model does not meet: a capacitor 30 % smaller has less than nine tenths.
    assert!(touch("power of 273 pF").ours < 0.9 && touch("power of 507 pF").ours > 0.9);
}

/// A mount of 200 Hz leaves the stroke prescribed: the cycles of the core are those of the balance of charge.
#[test]
fn the_cycles_are_those_of_the_balance_of_charge() {
    let all = figures().expect("the shipped scenes run");
    // 2.1296e-6 C/m² on 7.22822e-3 m², of which three quarters move between 96 and 24 pF.
    let whole = 0.75 * 2.1296e-6 * 7.228_22e-3;
    for (start, charge) in [("touch", 0.0), ("apart", whole)] {
        let most = |capacitance: f64| {
            let powers = cycles(capacitance, whole, charge);
            let most = powers.iter().copied().fold(0.0, f64::max);
            (most, 1 + powers.iter().position(|power| *power == most).expect("one of them"))
        };
        let found = |quantity: &str| figure(&all, quantity, Some(start)).ours;
        let (power, cycle) = most(390e-12);
        assert_eq!(found("cycle of most power, 390 pF"), cycle as f64);
        assert_eq!(found("cycle of most power, 2.2 nF"), most(2.2e-9).1 as f64);
        assert_close(start, found("power of 273 pF"), most(273e-12).0 / power, 3e-3);
        assert_close(start, found("power of 507 pF"), most(507e-12).0 / power, 3e-3);
        let second = |capacitance: f64| cycles(capacitance, whole, charge)[1];
        let best = (100..2000)
            .map(|pico| f64::from(pico) * 1e-12)
            .fold(0.0, |best, at| if second(at) > second(best) { at } else { best });
        assert_close(start, found("best capacitor"), best, 2e-2);
        if start == "touch" {
            assert_close("power", found("power in cycle 2, 1.7 Hz"), power, 3e-3);
        }
    }
}

//! Orders of convergence with fixed steps, against the same method with a tenth of the shortest step, and of the ledgers.

use super::{Found, order, run};
use crate::bridge::sine;
use crate::common::harvesters::{contact_parameters, sliding_parameters};
use crate::common::{adaptive, fixed};
use model_core::integrate::ExponentialRadau;
use model_core::part::force_law::AnyForceLaw;
use model_core::part::restitution::{AnyRestitution, ConstantRestitution};
use model_core::scene::sliding::AnyLateralForce;
use model_core::scene::{contact_separation, sliding};

const LAWS: [AnyForceLaw; 2] = [AnyForceLaw::TransferredCharge, AnyForceLaw::GapField];

/// How a contact-separation scene is driven.
#[derive(Debug, Clone, Copy)]
struct Contact {
    law: AnyForceLaw,
    parasitic: f64,
    resistance: f64,
    gravities: f64,
    frequency: f64,
    seconds: f64,
}

impl Contact {
    fn scene(&self) -> crate::common::harvesters::Contact<f64> {
        let mut parameters = contact_parameters();
        parameters.choices.load.resistance = self.resistance;
        parameters.choices.force_law = self.law;
        parameters.choices.parasitic.capacitance = self.parasitic;
        parameters.choices.restitution = AnyRestitution::Constant(ConstantRestitution { coefficient: 0.7 });
        parameters.build().expect("in bounds")
    }

    fn at(&self, step: f64) -> Found {
        let control = fixed(step);
        let vibration = sine(self.gravities, self.frequency);
        let start = contact_separation::Start::default();
        run(self.scene(), &start, ExponentialRadau, control, &vibration, self.seconds)
    }
}

fn slide(lateral: bool, friction: f64, resistance: f64, law: AnyForceLaw, step: f64) -> Found {
    let mut parameters = sliding_parameters();
    parameters.choices.load.resistance = resistance;
    parameters.choices.force_law = law;
    parameters.choices.friction.static_active = friction;
    parameters.choices.friction.static_inert = friction;
    parameters.choices.friction.kinetic_active = friction;
    parameters.choices.friction.kinetic_inert = 0.7 * friction;
    if lateral {
        parameters.choices.lateral_force = AnyLateralForce::Field;
    }
    let control = fixed(step);
    let scene = parameters.build().expect("in bounds");
    run(scene, &sliding::Start::default(), ExponentialRadau, control, &sine(0.36, 18.373), 0.6)
}

/// Orders in mean power, final state and first impact.
#[derive(Debug)]
struct Orders {
    power: f64,
    state: f64,
    impact: Option<f64>,
    /// Relative error of the mean power at the longest and the shortest step.
    errors: [f64; 2],
}

/// Orders over steps of `longest` seconds divided by powers of √2.
fn orders(longest: f64, at: impl Fn(f64) -> Found) -> Orders {
    let steps: [f64; 5] = core::array::from_fn(|k| longest * 0.5f64.powf(0.5 * k as f64));
    let exact = at(0.1 * steps[4]);
    let found = steps.map(&at);
    let size = exact.state[1].abs().max(0.05);
    let power = found.each_ref().map(|found| (found.power / exact.power - 1.0).abs());
    let state = found.each_ref().map(|found| {
        let [position, velocity] = [0, 1].map(|i| (found.state[i] - exact.state[i]).abs());
        (position * 100.0).max(velocity) / size
    });
    let impact = exact.first_impact.map(|first| {
        let errors = found
            .each_ref()
            .map(|found| (found.first_impact.expect("impacts") / first - 1.0).abs().max(1e-16));
        order(&steps, &errors)
    });
    Orders {
        power: order(&steps, &power),
        state: order(&steps, &state),
        impact,
        errors: [power[0], power[4]],
    }
}

#[test]
fn below_impact_the_order_is_four_and_more() {
    for law in LAWS {
        for parasitic in [0.0, 1e-12] {
            for resistance in [1e8, 1e3] {
                let contact =
                    Contact { law, parasitic, resistance, gravities: 0.05, frequency: 22.0, seconds: 0.5 };
                let found = orders(3.2e-3, |step| contact.at(step));
                println!("{law:?}, {parasitic} F, {resistance} Ω: {found:?}");
                assert!(found.impact.is_none());
                assert!(found.power > 3.6 && found.state > 3.8 && found.errors[1] < 2e-7, "{found:?}");
            }
        }
    }
}

#[test]
fn with_impacts_the_order_is_four() {
    for law in LAWS {
        let contact =
            Contact { law, parasitic: 1e-12, resistance: 1e8, gravities: 0.3, frequency: 20.0, seconds: 0.4 };
        let found = orders(3.2e-3, |step| contact.at(step));
        println!("{law:?}: {found:?}");
        assert!(found.power > 3.8 && found.state > 3.8, "{found:?}");
        assert!(found.impact.is_some_and(|impact| impact > 3.8), "{found:?}");
    }
}

/// Fixed steps longer than the spike of the current at contact resolve it to first order only.
#[test]
fn with_impacts_into_a_stiff_load_the_order_is_low() {
    let contact = Contact {
        law: AnyForceLaw::TransferredCharge,
        parasitic: 1e-12,
        resistance: 1e3,
        gravities: 0.3,
        frequency: 20.0,
        seconds: 0.4,
    };
    let found = orders(3.2e-3, |step| contact.at(step));
    println!("{found:?}");
    assert!(
        (1.0..3.0).contains(&found.power) && found.impact.is_some_and(|impact| impact > 3.0),
        "{found:?}"
    );
}

#[test]
fn sliding_is_of_order_four_and_near_the_load_of_the_most_power_its_error_is_smaller() {
    for lateral in [false, true] {
        let at = |load| orders(3.2e-3, |h| slide(lateral, 0.3, load, AnyForceLaw::TransferredCharge, h));
        let [fast, slow] = [at(3e7), at(1e8)];
        assert!(fast.power > 3.8 && fast.errors[1] < 5e-8, "{fast:?}");
        // Without the correction of the energy 4e-6.
        assert!(slow.errors[0] < 1e-6 && slow.errors[1] < 5e-9, "{slow:?}");
    }
}

/// At a tolerance of 1e-4, over all loads.
#[test]
fn ledgers_are_small_over_all_loads() {
    let control = || adaptive(1e-4);
    for resistance in [0.0, 1.0, 1e3, 1e5, 1e6, 1e7, 1e8, 1e10, f64::INFINITY] {
        let contact = Contact {
            law: AnyForceLaw::GapField,
            parasitic: 1e-12,
            resistance,
            gravities: 0.3,
            frequency: 20.0,
            seconds: 2.0,
        };
        let (start, vibration) = (contact_separation::Start::default(), sine(0.3, 20.0));
        let of_contact = run(contact.scene(), &start, ExponentialRadau, control(), &vibration, 2.0).residual;
        let scene = crate::bridge::slider(resistance);
        let start = sliding::Start::default();
        let of_slide = run(scene, &start, ExponentialRadau, control(), &sine(0.36, 18.373), 2.0).residual;
        println!("{resistance:e} Ω: contact {of_contact:.1e}, sliding {of_slide:.1e}");
        assert!(of_contact < 1e-4 && of_slide < 1e-4, "{resistance}: {of_contact} {of_slide}");
    }
}

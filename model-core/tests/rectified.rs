//! Both triboelectric scenes behind a full bridge: energy ledgers, limits, closed forms.

use model_core::clock::Instant;
use model_core::energy::{Ledger, RunMeter};
use model_core::excitation::{Excitation, Sine};
use model_core::hybrid::{Automaton, Driver, Event, HybridState, Observer, Span};
use model_core::integrate::{Adaptive, AnyStepControl, FixedStep, Method, RungeKutta4, TrBdf2};
use model_core::part::draw::{AnyDraw, CurrentDraw, Lockout, NoDraw, PowerDraw, ResistiveDraw};
use model_core::part::force_law::AnyForceLaw;
use model_core::part::load::AnyLoad;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::{AnyRestitution, ConstantRestitution};
use model_core::part::stick_charge::AnyStickCharge;
use model_core::part::store::{Capacitor, DcBus, Reservoir};
use model_core::scalar::{Mathematics, Polynomial, Scalar};
use model_core::scene::rectified::{BridgeRegime, FullBridge, Mode, Rectified, STATES, Terminals};
use model_core::scene::{Harvester, account, contact_separation as contact, sliding};

const WHOLE: usize = account::WHOLE;
const GRAVITY: f64 = 9.81;
const VACUUM_PERMITTIVITY: f64 = 8.854_187_812_8e-12;

type Contact<S> = contact::ContactSeparation<S, contact::AnyParts>;
type Slider<S> = sliding::Sliding<S, sliding::AnyParts>;

/// The mass over a dielectric of Table 2.
fn pad<S: Scalar>(ohms: f64, force_law: AnyForceLaw) -> Contact<S>
where
    Polynomial: Mathematics<S>,
{
    let number = S::literal;
    contact::Parameters {
        mass: number(5e-3),
        stiffness: number(80.0),
        damping_ratio: number(0.005),
        initial_gap: number(3e-3),
        electrode_area: number(4e-4),
        dielectric_thickness: number(5e-5),
        relative_permittivity: number(2.0),
        charge_density: number(50e-6),
        parasitic: ParasiticCapacitance { farads: number(1e-12) },
        load: AnyLoad { ohms: number(ohms) },
        force_law,
        restitution: AnyRestitution::Constant(ConstantRestitution { coefficient: number(0.7) }),
        sticking: AnyStickCharge::Frozen,
    }
    .build()
    .expect("in bounds")
}

/// The slider of Table 1, with the field's lateral force so that the ledger closes as a whole.
fn slider<S: Scalar>(ohms: f64) -> Slider<S> {
    let number = S::literal;
    sliding::Parameters {
        beam_length: number(0.1),
        beam_width: number(0.02),
        beam_thickness: number(5e-4),
        young_modulus: number(210e9),
        density: number(7800.0),
        damping_ratio: number(0.0035),
        slider_mass: number(8e-3),
        patch_radius: number(0.01),
        friction: sliding::PatchFriction {
            static_active: number(0.35),
            static_inert: number(0.25),
            kinetic_active: number(0.30),
            kinetic_inert: number(0.20),
        },
        dielectric_thickness: number(5e-5),
        relative_permittivity: number(2.0),
        charge_density: number(80e-6),
        load: AnyLoad { ohms: number(ohms) },
        force_law: AnyForceLaw::TransferredCharge,
        sticking: AnyStickCharge::Frozen,
        lateral_force: sliding::AnyLateralForce::Field,
    }
    .build()
    .expect("in bounds")
}

fn store<S: Scalar>(farads: f64, volts: f64) -> Capacitor<S, AnyDraw<S>> {
    Capacitor {
        farads: S::literal(farads),
        leakage_ohms: S::literal(1e9),
        initial_voltage: S::literal(volts),
        draw: AnyDraw::None,
    }
}

fn behind<S: Scalar, H: Terminals<S>, R: Reservoir<S>>(
    harvester: H,
    reservoir: R,
    drop: f64,
) -> Rectified<S, H, R> {
    Rectified::new(harvester, FullBridge { diode_drop: S::literal(drop), reservoir }).expect("in bounds")
}

fn sine<S: Scalar>(gravities: f64, hertz: f64) -> Sine<S>
where
    Polynomial: Mathematics<S>,
{
    Sine::new(S::literal(gravities * GRAVITY), S::literal(hertz), S::ZERO).expect("in bounds")
}

fn fixed<S: Scalar>(seconds: f64) -> AnyStepControl<S> {
    AnyStepControl::Fixed(FixedStep::of_seconds(S::literal(seconds)))
}

fn adaptive<S: Scalar>(tolerance: f64) -> AnyStepControl<S> {
    AnyStepControl::Adaptive(Adaptive::new(S::literal(tolerance)))
}

/// Runs from the harvester's default start.
fn run<S, H, R, M, E, O>(
    scene: &Rectified<S, H, R>,
    start: &H::Start,
    shaking: &E,
    driver: &Driver<M, AnyStepControl<S>>,
    seconds: f64,
    observer: &mut O,
) -> HybridState<S, Mode<<H as Automaton<S, 3, 0>>::Mode>, STATES, WHOLE>
where
    S: Scalar,
    H: Terminals<S> + Harvester<S, 3, 0>,
    R: Reservoir<S>,
    M: Method<S>,
    E: Excitation<S>,
    O: Observer<S, Mode<<H as Automaton<S, 3, 0>>::Mode>, STATES, WHOLE>,
{
    let mut state = scene.start::<_, _, WHOLE>(start, shaking, &driver.control).expect("in bounds");
    let end = Instant::from_seconds(seconds).expect("in range");
    driver.advance(scene, &mut state, shaking, end, u32::MAX, observer).expect("runs");
    state
}

/// What is left over in the ledgers of a run, relative: the sum of mechanics and field, and the store.
fn residuals<S, H, R, M, E>(
    scene: &Rectified<S, H, R>,
    start: &H::Start,
    shaking: &E,
    driver: &Driver<M, AnyStepControl<S>>,
    seconds: f64,
) -> [f64; 2]
where
    S: Scalar,
    H: Terminals<S>,
    R: Reservoir<S>,
    M: Method<S>,
    E: Excitation<S>,
{
    let opening = scene.start::<_, _, WHOLE>(start, shaking, &driver.control).expect("in bounds");
    let mut ledger = Ledger::open(scene, &opening);
    run(scene, start, shaking, driver, seconds, &mut ledger);
    let left = ledger.residual();
    let scale = left.scale.to_f64();
    [(left.mechanical + left.electrical).to_f64() / scale, left.store.to_f64() / scale].map(f64::abs)
}

/// The mean order by which errors fall at each halving of the step.
fn order(errors: &[f64]) -> f64 {
    let (first, last) = (errors[0], errors[errors.len() - 1]);
    (first / last).log2() / (errors.len() - 1) as f64
}

#[test]
fn ledgers_close_at_second_order() {
    let pad = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::GapField), store(1e-7, 1.0), 0.3);
    let slider = behind(slider::<f64>(f64::INFINITY), store(1e-7, 1.0), 0.3);
    let divisions = [800.0, 1600.0, 3200.0, 6400.0];
    let of_pad = divisions.map(|division| {
        let driver = Driver::new(TrBdf2, fixed(0.05 / division));
        residuals(&pad, &contact::Start::default(), &sine(0.2, 20.5), &driver, 3.0)
    });
    let of_slider = divisions.map(|division| {
        let driver = Driver::new(TrBdf2, fixed(0.054 / division));
        residuals(&slider, &sliding::Start::default(), &sine(0.36, 18.373), &driver, 1.0)
    });
    for (name, found) in [("contact", of_pad), ("sliding", of_slider)] {
        for which in 0..2 {
            let errors = found.map(|residuals| residuals[which]);
            println!("{name}, {}: {errors:?}, order {:.2}", ["harvester", "store"][which], order(&errors));
        }
    }
}

#[test]
fn explore() {
    let pad = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::TransferredCharge), store(1e-7, 1.0), 0.3);
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        let driver = Driver::new(TrBdf2, adaptive(tolerance));
        let mut meter = RunMeter::new(&pad);
        let mut state =
            pad.start::<_, _, WHOLE>(&contact::Start::default(), &sine(0.2, 20.0), &driver.control).unwrap();
        let a = driver
            .advance(
                &pad,
                &mut state,
                &sine(0.2, 20.0),
                Instant::from_whole_seconds(10),
                u32::MAX,
                &mut meter,
            )
            .unwrap();
        println!(
            "{tolerance:e}: {:?} V {:.9} E {:.9e} impacts {} peak {:?}",
            a.work,
            pad.store_voltage(state.mode, &state.point.state),
            meter.delivered_energy(),
            meter.impacts(),
            meter.coordinate()
        );
    }
    let slider = behind(slider::<f64>(f64::INFINITY), store(1e-7, 1.0), 0.3);
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        let driver = Driver::new(TrBdf2, adaptive(tolerance));
        let mut meter = RunMeter::new(&slider);
        let mut state = slider
            .start::<_, _, WHOLE>(&sliding::Start::default(), &sine(0.36, 18.373), &driver.control)
            .unwrap();
        let a = driver
            .advance(
                &slider,
                &mut state,
                &sine(0.36, 18.373),
                Instant::from_whole_seconds(10),
                u32::MAX,
                &mut meter,
            )
            .unwrap();
        println!(
            "{tolerance:e}: {:?} V {:.9} E {:.9e} peak {:?}",
            a.work,
            slider.store_voltage(state.mode, &state.point.state),
            meter.delivered_energy(),
            meter.coordinate()
        );
    }
}

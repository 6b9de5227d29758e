//! Both triboelectric scenes behind a full bridge: energy ledgers, limits, closed forms.

use model_core::clock::Instant;
use model_core::energy::{Ledger, RunMeter};
use model_core::excitation::{Excitation, Sine};
use model_core::hybrid::{Automaton, Driver, Event, HybridState, Observer, Span};
use model_core::integrate::{Adaptive, AnyStepControl, FixedStep, Method, RungeKutta4, TrBdf2};
use model_core::part::draw::{AnyDraw, CurrentDraw, Lockout, PowerDraw, ResistiveDraw};
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
        let [harvester, store] = [0, 1].map(|which| found.map(|residuals| residuals[which]));
        println!("{name}: harvester {harvester:?}, order {:.2}; store {store:?}", order(&harvester));
        assert!((1.7..=2.3).contains(&order(&harvester)), "{name}: {harvester:?}");
        assert!(harvester[3] < 1e-6 && store[3] < 1e-6, "{name}: {harvester:?} {store:?}");
    }
    // The pulses of contact are where the store's own ledger shows the step.
    let store = of_pad.map(|[_, store]| store);
    assert!((1.7..=2.3).contains(&order(&store)), "{store:?}");
}

#[test]
fn ledgers_close_in_single_precision_too() {
    let pad = behind(pad::<f32>(f64::INFINITY, AnyForceLaw::GapField), store(1e-7, 1.0), 0.3);
    let slider = behind(slider::<f32>(f64::INFINITY), store(1e-7, 1.0), 0.3);
    let driver = Driver::new(TrBdf2, fixed(1.5e-5));
    let of_pad = residuals(&pad, &contact::Start::default(), &sine(0.2, 20.5), &driver, 3.0);
    let of_slider = residuals(&slider, &sliding::Start::default(), &sine(0.36, 18.373), &driver, 3.0);
    println!("contact {of_pad:?}, sliding {of_slider:?}");
    for residual in of_pad.into_iter().chain(of_slider) {
        assert!(residual < 1e-4, "contact {of_pad:?}, sliding {of_slider:?}");
    }
}

/// Looks whether each regime is what it says at the end of every step.
struct Regimes<'a, H, R> {
    scene: &'a Rectified<f64, H, R>,
    steps: [u32; 3],
    begun: u32,
    highest: f64,
}

impl<'a, H, R> Regimes<'a, H, R> {
    fn of(scene: &'a Rectified<f64, H, R>) -> Self {
        Self { scene, steps: [0; 3], begun: 0, highest: 0.0 }
    }
}

impl<H, R, Q> Observer<f64, Mode<Q>, STATES, WHOLE> for Regimes<'_, H, R>
where
    H: Terminals<f64> + Automaton<f64, 3, 0, Mode = Q>,
    R: Reservoir<f64>,
    Q: Copy,
{
    fn step(&mut self, span: &Span<'_, f64, Mode<Q>, STATES, WHOLE>) {
        let (mode, state) = (span.mode, &span.end.state);
        let [position, velocity, charge] = self.scene.harvester_state(mode, state);
        let store = self.scene.store_voltage(mode, state);
        let threshold = self.scene.bridge().threshold(store);
        let terminal = self.scene.harvester().terminal_voltage(mode.inner, position, charge);
        // A step that ends a regime ends a tick or two beyond it.
        let rounding = 1e-13 * terminal.magnitude + 2e-12 * (terminal.by_position * velocity).abs();
        // Nothing leaks, nothing is drawn: the store never falls by more than the end of a regime is late.
        assert!(store >= self.highest * (1.0 - 1e-12), "{store} {}", self.highest);
        self.highest = store.max(self.highest);
        match mode.regime {
            BridgeRegime::Blocked => {
                self.steps[0] += 1;
                assert!(terminal.value.abs() <= threshold + rounding, "{} {threshold}", terminal.value);
            }
            BridgeRegime::Forward | BridgeRegime::Backward => {
                let sign: f64 = mode.regime.sign();
                self.steps[if sign > 0.0 { 1 } else { 2 }] += 1;
                assert!((terminal.value - sign * threshold).abs() <= rounding);
                // The voltage would rise beyond the threshold but for the current.
                let drive = sign * terminal.by_position * velocity;
                assert!(drive > -1e-6 * terminal.by_position.abs(), "{drive}");
            }
        }
    }

    fn event(&mut self, event: &Event<'_, f64, Mode<Q>, STATES, WHOLE>) {
        let blocked = BridgeRegime::Blocked;
        self.begun += u32::from(event.before.regime == blocked && event.after.regime != blocked);
        // No event moves charge or energy: what conduction has brought is taken up as it ends. An impact
        // ends a fraction of a picometre beyond contact, and is taken back to it.
        let [before, after] =
            [(event.before, event.reached), (event.after, event.left)].map(|(mode, point)| {
                let [_, _, charge] = self.scene.harvester_state(mode, &point.state);
                (charge, self.scene.store_voltage(mode, &point.state))
            });
        assert!((before.0 - after.0).abs() <= 1e-7 * before.0.abs().max(1.0), "{before:?} {after:?}");
        assert!((before.1 - after.1).abs() <= 1e-7 * before.1, "{before:?} {after:?}");
    }
}

#[test]
fn each_regime_is_what_it_says() {
    let tight = || Capacitor { leakage_ohms: f64::INFINITY, ..store(1e-8, 1.0) };
    let driver = Driver::new(TrBdf2, adaptive(1e-4));
    let scene = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::TransferredCharge), tight(), 0.3);
    let mut regimes = Regimes::of(&scene);
    run(&scene, &contact::Start::default(), &sine(0.2, 20.0), &driver, 4.0, &mut regimes);
    println!("contact {:?}, {} conductions, {} V", regimes.steps, regimes.begun, regimes.highest);
    assert!(regimes.begun > 120 && regimes.steps.iter().all(|&steps| steps > 1000) && regimes.highest > 10.0);
    let scene = behind(slider::<f64>(f64::INFINITY), tight(), 0.3);
    let mut regimes = Regimes::of(&scene);
    run(&scene, &sliding::Start::default(), &sine(0.36, 18.373), &driver, 4.0, &mut regimes);
    println!("sliding {:?}, {} conductions, {} V", regimes.steps, regimes.begun, regimes.highest);
    assert!(regimes.begun > 120 && regimes.steps.iter().all(|&steps| steps > 1000) && regimes.highest > 10.0);
}

/// A bus and diodes without voltage short the terminals: the charge follows the position as at 0 Ω.
#[test]
fn a_bus_without_voltage_is_a_short_circuit() {
    let driver = Driver::new(TrBdf2, adaptive(1e-7));
    let law = AnyForceLaw::TransferredCharge;
    let (bus, shaking) = (DcBus { volts: 0.0 }, sine::<f64>(0.2, 20.0));
    let end = Instant::from_whole_seconds(1);
    let shorted = pad::<f64>(0.0, law);
    let mut state = shorted
        .start::<_, _, WHOLE>(&contact::Start::default(), &shaking, &driver.control)
        .expect("in bounds");
    driver.advance(&shorted, &mut state, &shaking, end, u32::MAX, &mut ()).expect("runs");
    let scene = behind(pad::<f64>(f64::INFINITY, law), bus, 0.0);
    let found = run(&scene, &contact::Start::default(), &shaking, &driver, 1.0, &mut ());
    compare(
        "contact",
        [found.point.state[0], found.point.state[1]],
        [state.point.state[0], state.point.state[1]],
        [3e-3, 0.4],
    );

    let shaking = sine::<f64>(0.36, 18.373);
    let shorted = slider::<f64>(0.0);
    let mut state = shorted
        .start::<_, _, WHOLE>(&sliding::Start::default(), &shaking, &driver.control)
        .expect("in bounds");
    driver.advance(&shorted, &mut state, &shaking, end, u32::MAX, &mut ()).expect("runs");
    let scene = behind(slider::<f64>(f64::INFINITY), bus, 0.0);
    let found = run(&scene, &sliding::Start::default(), &shaking, &driver, 1.0, &mut ());
    compare(
        "sliding",
        [found.point.state[0], found.point.state[1]],
        [state.point.state[0], state.point.state[1]],
        [1e-2, 1.0],
    );
}

fn compare(name: &str, found: [f64; 2], expected: [f64; 2], sizes: [f64; 2]) {
    for ((found, expected), size) in found.into_iter().zip(expected).zip(sizes) {
        let error = (found - expected).abs() / size;
        println!("{name}: {found} {expected}, off by {error:.1e} of {size}");
        assert!(error < 3e-5, "{name}: {found} {expected}");
    }
}

/// A bus beyond the reach of the harvester is an open circuit, bit for bit.
#[test]
fn a_bus_out_of_reach_is_an_open_circuit() {
    let driver = Driver::new(TrBdf2, adaptive(1e-4));
    let law = AnyForceLaw::TransferredCharge;
    let (bus, shaking) = (DcBus { volts: 1e6_f32 }, sine::<f32>(0.2, 20.0));
    let end = Instant::from_whole_seconds(2);
    let open = pad::<f32>(f64::INFINITY, law);
    let mut state =
        open.start::<_, _, WHOLE>(&contact::Start::default(), &shaking, &driver.control).expect("in bounds");
    let alone = driver.advance(&open, &mut state, &shaking, end, u32::MAX, &mut ()).expect("runs");
    let scene = behind(open, bus, 0.3);
    let mut found =
        scene.start::<_, _, WHOLE>(&contact::Start::default(), &shaking, &driver.control).expect("in bounds");
    let bridged = driver.advance(&scene, &mut found, &shaking, end, u32::MAX, &mut ()).expect("runs");
    assert!(alone.work.events > 10);
    assert_eq!(bridged.work, alone.work);
    assert_eq!(found.point.state[..3], state.point.state);
    assert_eq!(found.point.remainder[..3], state.point.remainder);
}

#[test]
fn the_bits_do_not_depend_on_how_a_run_is_divided() {
    let scene = behind(pad::<f32>(f64::INFINITY, AnyForceLaw::GapField), store(1e-8, 1.0), 0.3);
    let shaking = sine::<f32>(0.2, 20.0);
    let whole = Driver::new(TrBdf2, adaptive(1e-3));
    let expected = run(&scene, &contact::Start::default(), &shaking, &whole, 2.0, &mut ());
    let pausing = Driver { pause_at_events: true, ..whole };
    let mut found =
        scene.start::<_, _, WHOLE>(&contact::Start::default(), &shaking, &whole.control).expect("in bounds");
    let end = Instant::from_whole_seconds(2);
    while found.clock < end {
        pausing.advance(&scene, &mut found, &shaking, end, 50, &mut ()).expect("runs");
    }
    assert_eq!(found, expected);
}

/// A large store in `f32`: each conduction brings it less than a rounding of its voltage.
#[test]
fn a_supercapacitor_fills_in_single_precision() {
    let shaking = (sine::<f64>(0.2, 20.0), sine::<f32>(0.2, 20.0));
    let law = AnyForceLaw::TransferredCharge;
    let double = behind(pad::<f64>(f64::INFINITY, law), store(1.0, 3.0), 0.3);
    let single = behind(pad::<f32>(f64::INFINITY, law), store(1.0, 3.0), 0.3);
    let start = (contact::Start::default(), contact::Start::default());
    let (mut exact, mut meter) = (RunMeter::new(&double), RunMeter::new(&single));
    let end = run(&double, &start.0, &shaking.0, &Driver::new(TrBdf2, fixed(1e-5)), 4.0, &mut exact);
    let found = run(&single, &start.1, &shaking.1, &Driver::new(TrBdf2, fixed(1e-5)), 4.0, &mut meter);
    let gained = double.store_gain_from(&end, 3.0);
    let in_single = single.store_gain_from(&found, 3.0);
    println!("{gained:e} J and {in_single:e} J stored, {:e} J delivered", exact.delivered_energy());
    assert!((in_single / gained - 1.0).abs() < 1e-3);
    // What leaks in 4 s through a gigaohm at 3 V is 36 nJ.
    assert!(((gained + 4.0 * 9.0 / 1e9) / exact.delivered_energy() - 1.0).abs() < 1e-4);
    assert!(single.store_voltage(found.mode, &found.point.state) - 3.0 < 1e-5);
}

/// Energy in J that the store of a scene has gained since `volts`.
trait Gain<S, M> {
    fn store_gain_from(&self, state: &HybridState<S, M, STATES, WHOLE>, volts: f64) -> f64;
}

impl<S: Scalar, H, R, M> Gain<S, M> for Rectified<S, H, R>
where
    Self: Harvester<S, STATES, WHOLE, Mode = M>,
    M: Copy,
{
    fn store_gain_from(&self, state: &HybridState<S, M, STATES, WHOLE>, volts: f64) -> f64 {
        let voltage = self.compensated_store_voltage(state.mode, &state.point);
        self.store_gain([S::literal(volts), S::ZERO], voltage).expect("a store").to_f64()
    }
}

/// What a bus receives in a period of a smooth motion is given by the extremes of that motion alone: the
/// charge follows the rectangle's sides in the plane of charge and voltage.
#[test]
fn a_bus_receives_what_the_extremes_of_the_motion_say() {
    let (volts, drop) = (3.0, 0.3);
    let threshold = volts + 2.0 * drop;
    let scene = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::TransferredCharge), DcBus { volts }, drop);
    let hertz = 18.0;
    let shaking = sine::<f64>(0.05, hertz);
    let (area, thickness) = (VACUUM_PERMITTIVITY * 4e-4, 5e-5 / 2.0);
    // Q = q − C_p V at a gap and a voltage.
    let charge = |gap: f64, voltage: f64| {
        let distance = gap + thickness;
        (50e-6 * 4e-4 * gap - voltage * (area + 1e-12 * distance)) / distance
    };
    let settled = Instant::from_seconds(600.0 / hertz).expect("in range");
    let end = Instant::from_seconds(610.0 / hertz).expect("in range");
    let implicit = Driver::new(TrBdf2, adaptive(1e-6));
    let mut state = scene
        .start::<_, _, WHOLE>(&contact::Start::default(), &shaking, &implicit.control)
        .expect("in bounds");
    let mut meter = RunMeter::new(&scene);
    implicit.advance(&scene, &mut state, &shaking, settled, u32::MAX, &mut ()).expect("runs");
    implicit.advance(&scene, &mut state, &shaking, end, u32::MAX, &mut meter).expect("runs");
    let gap = meter.coordinate();
    let passed = charge(gap.highest, threshold) - charge(gap.lowest, -threshold);
    let expected = 10.0 * 2.0 * passed * volts;
    println!("gap {gap:?}: {:e} J, expected {expected:e} J", meter.delivered_energy());
    assert!(passed > 0.0 && meter.impacts() == 0);
    assert!((meter.delivered_energy() / expected - 1.0).abs() < 1e-5);
    let lost = meter.integrals().integral(account::DIODES);
    assert!((lost / (expected * 2.0 * drop / volts) - 1.0).abs() < 1e-5);
    assert!((meter.charge_moved() / (20.0 * passed) - 1.0).abs() < 1e-5);
}

/// The same of the slider, whose voltage has an extreme at the centre too; by an explicit method, for which the
/// circuit is not stiff.
#[test]
fn an_explicit_method_finds_the_same_of_the_slider() {
    let (volts, drop) = (20.0, 0.3);
    let threshold = volts + 2.0 * drop;
    let scene = behind(slider::<f64>(f64::INFINITY), DcBus { volts }, drop);
    let hertz = 18.373;
    let shaking = sine::<f64>(0.36, hertz);
    let patch = core::f64::consts::PI * 1e-4;
    let overlap = |x: f64| {
        let away = x.abs() / 0.02;
        (away.acos() - away * (1.0 - away * away).sqrt()) * core::f64::consts::FRAC_2_PI
    };
    let charge = |x: f64, voltage: f64| {
        let capacitance = VACUUM_PERMITTIVITY * 2.0 * patch * overlap(x) / 5e-5;
        80e-6 * patch * (1.0 - overlap(x)) - capacitance * voltage
    };
    let settled = Instant::from_seconds(1000.0 / hertz).expect("in range");
    let end = Instant::from_seconds(1010.0 / hertz).expect("in range");
    let explicit = Driver::new(RungeKutta4, fixed(0.05 / 800.0));
    let mut state = scene
        .start::<_, _, WHOLE>(&sliding::Start::default(), &shaking, &explicit.control)
        .expect("in bounds");
    let mut meter = RunMeter::new(&scene);
    explicit.advance(&scene, &mut state, &shaking, settled, u32::MAX, &mut ()).expect("runs");
    explicit.advance(&scene, &mut state, &shaking, end, u32::MAX, &mut meter).expect("runs");
    let reach = meter.coordinate();
    // Forward to either side, backward into the middle from each.
    let passed: f64 =
        [reach.lowest, reach.highest].map(|x| charge(x, threshold) - charge(0.0, -threshold)).iter().sum();
    let expected = 10.0 * 2.0 * passed * volts;
    println!("reach {reach:?}: {:e} J, expected {expected:e} J", meter.delivered_energy());
    assert!((meter.delivered_energy() / expected - 1.0).abs() < 1e-5);
}

/// A harvester that starts charged beyond the threshold shares its charge with the store at once: what the field
/// gives is in the store or lost in the diodes.
#[test]
fn a_charge_beyond_the_threshold_is_shared_at_once() {
    let (volts, farads, gap) = (10.0, 1e-11, 3e-3);
    let reservoir = Capacitor { leakage_ohms: f64::INFINITY, ..store(farads, 1.0) };
    let scene = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::GapField), reservoir, 0.3);
    let distance = gap + 5e-5 / 2.0;
    let capacitance = VACUUM_PERMITTIVITY * 4e-4 / distance;
    let charge = 50e-6 * 4e-4 * gap / distance - capacitance * volts;
    let start = contact::Start { charge: Some(charge), ..contact::Start::default() };
    let driver = Driver::new(TrBdf2, fixed(1e-9));
    let still = sine::<f64>(0.0, 20.0);
    let opening = scene.start::<_, _, WHOLE>(&start, &still, &driver.control).expect("in bounds");
    let mut ledger = Ledger::open(&scene, &opening);
    let end = run(&scene, &start, &still, &driver, 1e-8, &mut ledger);
    // The capacitance at the terminals and the store's, joined from 10 V and 1.6 V.
    let joined = capacitance + 1e-12;
    let passed = (volts - 1.6) * joined * farads / (joined + farads);
    let (delivered, lost) = (passed * (1.0 + 0.5 * passed / farads), passed * (0.6 + 0.5 * (volts - 1.6)));
    let found = [account::LOAD, account::DIODES].map(|entry| ledger.integrals().integral(entry));
    println!("{found:?} J, expected {delivered:e} J and {lost:e} J");
    assert!((scene.store_voltage(end.mode, &end.point.state) - 1.0 - passed / farads).abs() < 1e-6);
    assert!((found[0] / delivered - 1.0).abs() < 1e-6 && (found[1] / lost - 1.0).abs() < 1e-6);
    let residual = ledger.residual();
    assert!(residual.electrical.abs().max(residual.store.abs()) < 1e-6 * delivered, "{residual:?}");
}

/// A store with a draw and a harvester at rest: how long it lasts is known in closed form.
#[test]
fn a_draw_empties_the_store_on_time_and_comes_back_at_the_higher_voltage() {
    let lockout = Lockout { turn_on: 3.0, turn_off: 2.0 };
    let (farads, full) = (1e-6, 3.0_f64);
    let draws = [
        (AnyDraw::Power(PowerDraw { watts: 5e-6, lockout }), farads * (full * full - 4.0) / (2.0 * 5e-6)),
        (AnyDraw::Current(CurrentDraw { amperes: 2e-6, lockout }), farads * (full - 2.0) / 2e-6),
        (
            AnyDraw::Resistor(ResistiveDraw { ohms: 1e6, lockout: Some(lockout) }),
            1e6 * farads * (full / 2.0).ln(),
        ),
    ];
    let driver = Driver { pause_at_events: true, ..Driver::new(TrBdf2, adaptive(1e-6)) };
    let still = sine::<f64>(0.0, 20.0);
    for (draw, seconds) in draws {
        let reservoir = Capacitor { farads, leakage_ohms: f64::INFINITY, initial_voltage: full, draw };
        let scene = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::GapField), reservoir, 0.3);
        let mut state = scene
            .start::<_, _, WHOLE>(&contact::Start::default(), &still, &driver.control)
            .expect("in bounds");
        assert!(state.mode.connected);
        let mut meter = RunMeter::new(&scene);
        let end = Instant::from_whole_seconds(3);
        driver.advance(&scene, &mut state, &still, end, u32::MAX, &mut meter).expect("runs");
        let found = state.clock.seconds::<f64>();
        println!("{draw:?}: {found} s, expected {seconds} s");
        assert!(!state.mode.connected && (found / seconds - 1.0).abs() < 1e-6, "{draw:?}");
        let drawn = meter.integrals().integral(account::DRAWN);
        assert!((drawn / (0.5 * farads * (full * full - 4.0)) - 1.0).abs() < 1e-6, "{draw:?}: {drawn:e}");
    }
    // Charged from below: connected at each rise to the upper voltage, and not before.
    let draw = PowerDraw { watts: 2e-4, lockout };
    let reservoir = Capacitor { farads: 2e-8, leakage_ohms: f64::INFINITY, initial_voltage: 2.5, draw };
    let scene = behind(pad::<f32>(f64::INFINITY, AnyForceLaw::TransferredCharge), single(reservoir), 0.3);
    let shaking = sine::<f32>(0.2, 20.0);
    let driver = Driver { pause_at_events: true, ..Driver::new(TrBdf2, adaptive::<f32>(1e-4)) };
    let mut state =
        scene.start::<_, _, WHOLE>(&contact::Start::default(), &shaking, &driver.control).expect("in bounds");
    assert!(!state.mode.connected);
    let mut toggles = 0;
    let end = Instant::from_whole_seconds(4);
    while state.clock < end {
        let before = state.mode.connected;
        driver.advance(&scene, &mut state, &shaking, end, u32::MAX, &mut ()).expect("runs");
        if state.mode.connected != before {
            toggles += 1;
            let level = if before { 2.0 } else { 3.0 };
            let volts = scene.store_voltage(state.mode, &state.point.state);
            assert!((volts - level).abs() < 1e-5, "{volts} {level}");
        }
    }
    println!("{toggles} toggles");
    assert!(toggles > 10);
}

fn single(store: Capacitor<f64, PowerDraw<f64>>) -> Capacitor<f32, PowerDraw<f32>> {
    let Lockout { turn_on, turn_off } = store.draw.lockout;
    Capacitor {
        farads: store.farads as f32,
        leakage_ohms: f32::INFINITY,
        initial_voltage: store.initial_voltage as f32,
        draw: PowerDraw {
            watts: store.draw.watts as f32,
            lockout: Lockout { turn_on: turn_on as f32, turn_off: turn_off as f32 },
        },
    }
}

#[test]
fn what_is_out_of_bounds_is_refused_by_name() {
    let law = AnyForceLaw::GapField;
    let bridge = |diode_drop| FullBridge { diode_drop, reservoir: DcBus { volts: 5.0_f64 } };
    let field = |found: Result<_, model_core::scene::ParameterError<f64>>| {
        found.err().map(|error| (error.field, error.value))
    };
    assert_eq!(field(Rectified::new(pad(f64::INFINITY, law), bridge(0.3)).map(|_| ())), None);
    assert_eq!(field(Rectified::new(pad(1e8, law), bridge(0.3)).map(|_| ())), Some(("resistance", 1e8)));
    assert_eq!(field(Rectified::new(slider(0.0), bridge(0.3)).map(|_| ())), Some(("resistance", 0.0)));
    let refused = Rectified::new(pad(f64::INFINITY, law), bridge(-0.1)).map(|_| ());
    assert_eq!(field(refused), Some(("diode_drop", -0.1)));
}

/// The derivatives from which the current and its rate are made, against differences of the voltage.
#[test]
fn derivatives_of_the_terminal_voltage_are_those_of_its_values() {
    let pad = pad::<f64>(f64::INFINITY, AnyForceLaw::GapField);
    let slider = slider::<f64>(f64::INFINITY);
    for gap in [0.0, 2e-5, 3e-3] {
        derivatives(&pad, contact::Mode::Free, gap, 1e-8);
    }
    for (ahead, displacement) in [(true, 3e-3), (false, -3e-3), (true, 0.015), (false, -0.018)] {
        derivatives(&slider, sliding::Mode::Sliding { forward: true, ahead }, displacement, 1e-7);
    }
}

fn derivatives<H: Terminals<f64>>(harvester: &H, mode: H::Mode, position: f64, step: f64) {
    for charge in [-0.05, 0.0, 0.1] {
        let at = |position, charge| harvester.terminal_voltage(mode, position, charge);
        let [here, before, after] = [0.0, -step, step].map(|shift| at(position + shift, charge));
        let more = at(position, charge + 1.0);
        let close = |what: &str, found: f64, expected: f64, scale: f64| {
            assert!((found - expected).abs() < 1e-6 * scale, "{what} at {position}: {found} {expected}");
        };
        let slope = here.by_position.abs();
        close("dV/dx", (after.value - before.value) / (2.0 * step), here.by_position, slope);
        close("dV/dQ", more.value - here.value, here.by_charge, here.by_charge.abs());
        let bend = (after.by_position - before.by_position) / (2.0 * step);
        close("d2V/dx2", bend, here.curvature, here.curvature.abs() + slope * 1e3);
        close("d2V/dx dQ", more.by_position - here.by_position, here.by_both, here.by_both.abs());
        assert!(here.magnitude >= here.value.abs() * 0.5 && here.by_charge < 0.0);
    }
}

//! Both triboelectric scenes behind a full bridge: energy ledgers, the three regimes, equal bits.

use crate::bridge::{
    GRAVITY, VACUUM_PERMITTIVITY, WHOLE, adaptive, begin, behind, fixed, pad, run, sine, slider, storage,
};
use crate::common::harvesters;
use model_core::clock::{Instant, TICKS_PER_SECOND};
use model_core::energy::{Ledger, RunMeter};
use model_core::excitation::{Excitation, Sine};
use model_core::hybrid::{Automaton, Driver, HybridState};
use model_core::integrate::{AnyStepControl, ExponentialRadau, Method, TrBdf2};
use model_core::observer::{AcceptedStep, Event, Observer, Outputs};
use model_core::part::force_law::AnyForceLaw;
use model_core::part::storage::{Capacitor, DcBus, StorageCapacitor, StorageElement};
use model_core::scalar::Scalar;
use model_core::scene::rectified::{BridgeRegime, ElectricalPort, FullBridge, Mode, Rectified, STATES};
use model_core::scene::{Scene, contact_separation as contact, sliding};

/// What is left over in the ledgers of a run, relative: the sum of mechanics and field, and the storage.
fn residuals<S, H, R, M, E>(
    scene: &Rectified<S, H, R>,
    start: &H::Start,
    vibration: &E,
    driver: &Driver<M, AnyStepControl<S>>,
    seconds: f64,
) -> [f64; 2]
where
    S: Scalar,
    H: ElectricalPort<S>,
    R: StorageElement<S>,
    M: Method<S>,
    E: Excitation<S>,
{
    let opening = scene.start::<_, _, WHOLE>(start, vibration, &driver.control).expect("in bounds");
    let mut ledger =
        Ledger::open(&Automaton::<S, STATES, WHOLE>::outputs(scene, opening.mode, &opening.point));
    run(scene, start, vibration, driver, seconds, &mut ledger);
    let left = ledger.residual();
    let scale = left.scale.to_f64();
    [(left.mechanical + left.electrical).to_f64() / scale, left.storage.to_f64() / scale].map(f64::abs)
}

/// The mean order by which errors fall at each halving of the step.
fn order(errors: &[f64]) -> f64 {
    let (first, last) = (errors[0], errors[errors.len() - 1]);
    (first / last).log2() / (errors.len() - 1) as f64
}

/// Largest difference within a step between the mean current by the charge and by the rates, and the largest current.
#[derive(Default)]
struct Currents {
    off: f64,
    largest: f64,
}

impl Observer<f64> for Currents {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        let (start, end) = (step.start.charge, step.end.charge);
        let mean = (end.value - start.value) / step.step;
        self.off = self.off.max((mean - 0.5 * (start.rate + end.rate)).abs());
        self.largest = self.largest.max(mean.abs());
    }
}

#[test]
fn the_current_of_the_outputs_is_the_rate_of_their_charge() {
    let pad = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::GapField), storage(1e-7, 1.0), 0.3);
    let slider = behind(slider::<f64>(f64::INFINITY), storage(1e-7, 1.0), 0.3);
    let driver = Driver::new(TrBdf2, fixed(1e-5));
    let [mut of_pad, mut of_slider] = [Currents::default(), Currents::default()];
    run(&pad, &contact::Start::default(), &sine(0.2, 20.5), &driver, 0.3, &mut of_pad);
    run(&slider, &sliding::Start::default(), &sine(0.36, 18.373), &driver, 0.3, &mut of_slider);
    for (name, found) in [("contact", of_pad), ("sliding", of_slider)] {
        println!("{name}: {:e} A of {:e} A", found.off, found.largest);
        assert!(found.largest > 1e-9 && found.off < 1e-2 * found.largest, "{name}");
    }
}

/// The current through the bridge ends within nanoseconds of a turn of the slider. Neither takes a step of its own, and at a
/// loose tolerance the first attempt at an event ends there: 242 attempts for 140 events.
#[test]
fn events_behind_a_bridge_take_few_attempts_and_charge_the_storage_as_short_steps_do() {
    let slider = behind(slider::<f64>(f64::INFINITY), storage(1e-6, 5.0), 0.3);
    let vibration = sine(0.36, 18.373);
    let [loose, tight] = [1e-1, 1e-6].map(|tolerance| {
        let driver = Driver::new(ExponentialRadau, adaptive(tolerance));
        let mut state = begin(&slider, &vibration, &driver);
        let work = driver.advance(&slider, &mut state, &vibration, WHOLE_SECOND, u32::MAX, &mut ());
        (work.expect("runs").work, slider.storage_voltage(state.mode, &state.point.state) - 5.0)
    });
    println!("{loose:?}, {tight:?}");
    let (work, gain) = loose;
    assert!(work.events > 100 && work.attempts() * 10 < work.events * 16, "{work:?}");
    assert!(gain > 0.1 && (gain / tight.1 - 1.0).abs() < 1e-4, "{gain}");
}

/// An attempt is extended to an event by its tangent and by a second line, neither beyond the end of a run.
#[test]
fn a_run_to_an_instant_near_an_event_ends_there() {
    #[derive(Default)]
    struct Events(Vec<Instant>);
    impl Observer<f64> for Events {
        fn step(&mut self, _: &AcceptedStep<'_, f64>) {}

        fn event(&mut self, event: &Event<'_, f64>) {
            self.0.push(event.at);
        }
    }
    let slider = behind(slider::<f64>(f64::INFINITY), storage(1e-6, 5.0), 0.3);
    let vibration = sine(0.36, 18.373);
    let driver = Driver::new(ExponentialRadau, adaptive(1e-1));
    let start = sliding::Start::default();
    let mut events = Events::default();
    run(&slider, &start, &vibration, &driver, 0.3, &mut events);
    assert!(events.0.len() > 30, "{}", events.0.len());
    for at in &events.0[20..] {
        for before in [1, 1 << 4, 1 << 8, 1 << 12, 1 << 16, 1 << 20, 1 << 24] {
            let until = Instant::from_ticks(at.ticks() - before);
            let mut state =
                slider.start::<_, _, WHOLE>(&start, &vibration, &driver.control).expect("in bounds");
            driver.advance(&slider, &mut state, &vibration, until, u32::MAX, &mut ()).expect("runs");
            assert_eq!(state.clock, until, "{before} ticks before {at:?}");
        }
    }
}

/// One second.
const WHOLE_SECOND: Instant = Instant::from_whole_seconds(1);

/// In a stick with a frozen charge only the excitation limits a step: three steps of 15.6 ms to a release after 43 ms.
#[test]
fn a_stick_with_a_frozen_charge_takes_three_steps() {
    #[derive(Default)]
    struct Sticks([u32; 2]);
    impl Observer<f64> for Sticks {
        fn step(&mut self, step: &AcceptedStep<'_, f64>) {
            self.0[0] += u32::from(step.start.stick);
        }

        fn event(&mut self, event: &Event<'_, f64>) {
            self.0[1] += u32::from(event.before.stick);
        }
    }
    let (slider, vibration) = (slider::<f64>(1e8), sine(0.30, 6.0));
    let driver = Driver::new(ExponentialRadau, adaptive(1e-2));
    let mut state = begin(&slider, &vibration, &driver);
    let mut sticks = Sticks::default();
    driver.advance(&slider, &mut state, &vibration, WHOLE_SECOND, u32::MAX, &mut sticks).expect("runs");
    let Sticks([steps, releases]) = sticks;
    assert!(releases >= 11 && steps <= 3 * releases + 3, "{steps} {releases}");
}

/// Without a diode drop an empty storage conducts from the first roundings of the voltage on. The guard is a stair of them,
/// which Newton's iteration leaves on either side.
#[test]
fn a_threshold_within_the_roundings_of_the_voltage_costs_no_steps() {
    let work = |drop, [amplitude, frequency]: [f64; 2]| {
        let pad = behind(pad::<f32>(f64::INFINITY, AnyForceLaw::GapField), storage(4.9e-9, 0.0), drop);
        let driver = Driver::new(ExponentialRadau, adaptive(1e-5));
        let vibration = sine(amplitude, frequency);
        let mut state = begin(&pad, &vibration, &driver);
        let end = Instant::from_seconds(0.1).expect("in range");
        driver.advance(&pad, &mut state, &vibration, end, u32::MAX, &mut ()).expect("runs").work
    };
    for vibration in [[0.2, 20.5], [0.5, 4278.0], [0.05, 700.0], [0.2, 60.0]] {
        let [none, some] = [0.0, 0.01].map(|drop| work(drop, vibration));
        println!("{vibration:?}: {none:?}, {some:?}");
        assert!(
            none.events >= some.events && none.attempts() < 2 * some.attempts() + 200,
            "{none:?} {some:?}"
        );
    }
}

/// The impacts in s, and the highest voltage in V.
#[derive(Default)]
struct Impacts {
    at: Vec<f64>,
    highest: f64,
}

impl Observer<f64> for Impacts {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        self.highest = self.highest.max(step.start.voltage.abs()).max(step.end.voltage.abs());
    }

    fn event(&mut self, event: &Event<'_, f64>) {
        if event.impact_speed.is_some() {
            self.at.push(event.at.seconds());
        }
    }
}

/// A parasitic capacitance gives the voltage a pole at a gap of -7 mm, where a long step of a fast mass can end: beyond
/// the impact the voltage seems to reach the other threshold.
#[test]
fn a_bridge_conducts_before_the_impact_that_ends_a_step() {
    let mut parameters = harvesters::contact_parameters::<f64>();
    (parameters.mass, parameters.stiffness, parameters.damping_ratio) = (2.713e-2, 697.7, 2.122e-2);
    (parameters.initial_gap, parameters.electrode_area) = (1.687e-3, 1.105e-4);
    (parameters.dielectric_thickness, parameters.relative_permittivity) = (5.701e-6, 46.72);
    parameters.charge_density = 4.552e-4;
    parameters.choices.load.resistance = f64::INFINITY;
    parameters.choices.force_law = AnyForceLaw::None;
    parameters.choices.parasitic.capacitance = 1.382e-13;
    let scene = behind(parameters.build().expect("in bounds"), storage(1.135e-4, 4.094e-3), 0.3);
    let driver = Driver::new(ExponentialRadau, adaptive(1e-6));
    let start = contact::Start::default();
    let end = Instant::from_seconds(0.2).expect("in range");
    for gravities in [50.0, 61.86, 80.0, 120.0] {
        let vibration = Sine::<f64>::new(gravities * GRAVITY, 20.76, -2.157).expect("in bounds");
        let (mut open, mut bridged) = (Impacts::default(), Impacts::default());
        let mut state =
            scene.harvester().start::<_, _, WHOLE>(&start, &vibration, &driver.control).expect("in bounds");
        driver.advance(scene.harvester(), &mut state, &vibration, end, u32::MAX, &mut open).expect("runs");
        run(&scene, &start, &vibration, &driver, 0.2, &mut bridged);
        println!("{gravities} g: {} impacts, first {} s, {} V", open.at.len(), open.at[0], bridged.highest);
        // Without a force on the mass the circuit does not change the motion.
        assert_eq!(open.at.len(), bridged.at.len());
        assert!(open.at.iter().zip(&bridged.at).all(|(open, bridged)| (open - bridged).abs() < 1e-9));
        assert!(bridged.highest < 0.7, "{} V", bridged.highest);
    }
}

/// A start above the threshold drives a charge forward at once. The plates close, so that conduction ends at once too, and goes on
/// backward from the other threshold. By `V S ε0 = σ S x − Q (x + d_e)` at both thresholds the bus takes its voltage times both.
#[test]
fn a_start_above_the_threshold_of_closing_plates_charges_the_bus_once() {
    let mut parameters = harvesters::contact_parameters::<f64>();
    parameters.choices.load.resistance = f64::INFINITY;
    parameters.choices.parasitic.capacitance = 0.0;
    let area = parameters.electrode_area;
    let surface = parameters.charge_density * area;
    let thickness = parameters.dielectric_thickness / parameters.relative_permittivity;
    let volts = 5e-3;
    let scene = behind(parameters.build().expect("in bounds"), DcBus { voltage: volts }, 0.0);
    let (gap, velocity) = (2.6e-6, -0.2);
    let start = contact::Start { gap: Some(gap), velocity: Some(velocity), charge: Some(0.0) };
    let mut meter = RunMeter::new();
    let driver = Driver::new(ExponentialRadau, adaptive(1e-3));
    let seconds = 1e-5;
    let state = run(&scene, &start, &sine(0.2, 20.0), &driver, seconds, &mut meter);
    let closed = state.point.state[0];
    assert!((closed - gap - velocity * seconds).abs() < 1e-8, "{closed}");
    let charge_at =
        |gap: f64, volts: f64| (surface * gap - volts * VACUUM_PERMITTIVITY * area) / (gap + thickness);
    let [forward, backward] = [charge_at(gap, volts), charge_at(closed, -volts)];
    let expected = volts * (2.0 * forward - backward);
    let found = meter.delivered_energy();
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
}

#[test]
fn ledgers_close_at_second_order() {
    let pad = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::GapField), storage(1e-7, 1.0), 0.3);
    let slider = behind(slider::<f64>(f64::INFINITY), storage(1e-7, 1.0), 0.3);
    let divisions = [800.0, 1600.0, 3200.0, 6400.0];
    let of_pad = divisions.map(|division| {
        let driver = Driver::new(TrBdf2, fixed(0.05 / division));
        residuals(&pad, &contact::Start::default(), &sine(0.2, 20.5), &driver, 1.0)
    });
    let of_slider = divisions.map(|division| {
        let driver = Driver::new(TrBdf2, fixed(0.054 / division));
        residuals(&slider, &sliding::Start::default(), &sine(0.36, 18.373), &driver, 0.5)
    });
    for (name, found) in [("contact", of_pad), ("sliding", of_slider)] {
        let [harvester, storage] = [0, 1].map(|which| found.map(|residuals| residuals[which]));
        println!("{name}: harvester {harvester:?}, order {:.2}; storage {storage:?}", order(&harvester));
        assert!((1.7..=2.3).contains(&order(&harvester)), "{name}: {harvester:?}");
        assert!(harvester[3] < 1e-6, "{name}: {harvester:?}");
        // What enters the storage follows from the charge that has passed: only what leaks is a quadrature.
        assert!(storage.iter().all(|residual| *residual < 1e-9), "{name}: {storage:?}");
    }
}

const TICK: f64 = 1.0 / TICKS_PER_SECOND as f64;

/// Looks whether each regime is what it says at the end of every step.
struct Regimes<'a, H: Automaton<f64, 3, 0>, R> {
    scene: &'a Rectified<f64, H, R>,
    /// The harvester's own mode of a number.
    inner: fn(u8) -> H::Mode,
    steps: [u32; 3],
    begun: u32,
    highest: f64,
}

impl<'a, H: ElectricalPort<f64>, R: StorageElement<f64>> Regimes<'a, H, R> {
    fn of(scene: &'a Rectified<f64, H, R>, inner: fn(u8) -> H::Mode) -> Self {
        Self { scene, inner, steps: [0; 3], begun: 0, highest: 0.0 }
    }

    /// The mode of which outputs give the number.
    fn mode(&self, outputs: &Outputs<'_, f64>) -> Mode<H::Mode> {
        let regime = match outputs.mode & 48 {
            0 => BridgeRegime::Blocked,
            16 => BridgeRegime::Forward,
            32 => BridgeRegime::Backward,
            other => panic!("no regime {other}"),
        };
        Mode { inner: (self.inner)(outputs.mode & 15), regime, connected: outputs.mode & 64 != 0 }
    }

    /// The harvester's own state, and the voltage of the storage.
    fn at(&self, outputs: &Outputs<'_, f64>) -> ([f64; 3], f64) {
        let (mode, state) = (self.mode(outputs), outputs.state.try_into().expect("four states"));
        let storage = outputs.storage.expect("a storage").voltage;
        assert!((storage / self.scene.storage_voltage(mode, state) - 1.0).abs() < 1e-14);
        (self.scene.harvester_state(mode, state), storage)
    }
}

fn contact_mode(number: u8) -> contact::Mode {
    [contact::Mode::Free, contact::Mode::Stick][usize::from(number)]
}

fn sliding_mode(number: u8) -> sliding::Mode {
    match number {
        4 => sliding::Mode::Stick,
        _ => sliding::Mode::Sliding { forward: number & 1 != 0, ahead: number & 2 != 0 },
    }
}

impl<H: ElectricalPort<f64>, R: StorageElement<f64>> Observer<f64> for Regimes<'_, H, R> {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        let mode = self.mode(&step.end);
        let ([position, velocity, charge], storage) = self.at(&step.end);
        let threshold = storage + 2.0 * self.scene.bridge().diode_drop;
        let terminal = self.scene.harvester().port_voltage(mode.inner, position, charge);
        // A step that ends a regime ends a tick or two beyond it.
        let rounding = 1e-13 * terminal.magnitude + 2.0 * TICK * (terminal.by_position * velocity).abs();
        // Nothing leaks, nothing is drawn: the storage never falls by more than the end of a regime is late.
        assert!(storage >= self.highest * (1.0 - 1e-8), "{storage} {}", self.highest);
        self.highest = storage.max(self.highest);
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

    fn event(&mut self, event: &Event<'_, f64>) {
        let blocked = BridgeRegime::Blocked;
        let [before, after] = [&event.before, &event.after].map(|outputs| self.mode(outputs).regime);
        self.begun += u32::from(before == blocked && after != blocked);
        // No event moves charge or energy: what conduction has brought is taken up as it ends. An impact
        // ends a fraction of a picometre beyond contact, and is taken back to it.
        let [before, after] = [&event.before, &event.after].map(|outputs| {
            let ([_, _, charge], storage) = self.at(outputs);
            (charge, storage)
        });
        assert!((before.0 - after.0).abs() <= 1e-7 * before.0.abs().max(1.0), "{before:?} {after:?}");
        assert!((before.1 - after.1).abs() <= 1e-7 * before.1, "{before:?} {after:?}");
    }
}

#[test]
fn each_regime_is_what_it_says() {
    let tight = || StorageCapacitor {
        capacitor: Capacitor { leakage_resistance: f64::INFINITY, ..storage(1e-8, 1.0).capacitor },
        ..storage(1e-8, 1.0)
    };
    let driver = Driver::new(TrBdf2, adaptive(1e-4));
    let scene = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::TransferredCharge), tight(), 0.3);
    let mut regimes = Regimes::of(&scene, contact_mode);
    run(&scene, &contact::Start::default(), &sine(0.2, 20.0), &driver, 4.0, &mut regimes);
    println!("contact {:?}, {} conductions, {} V", regimes.steps, regimes.begun, regimes.highest);
    assert!(regimes.begun > 120 && regimes.steps.iter().all(|&steps| steps > 1000) && regimes.highest > 10.0);
    let scene = behind(slider::<f64>(f64::INFINITY), tight(), 0.3);
    let mut regimes = Regimes::of(&scene, sliding_mode);
    run(&scene, &sliding::Start::default(), &sine(0.36, 18.373), &driver, 4.0, &mut regimes);
    println!("sliding {:?}, {} conductions, {} V", regimes.steps, regimes.begun, regimes.highest);
    assert!(regimes.begun > 120 && regimes.steps.iter().all(|&steps| steps > 1000) && regimes.highest > 10.0);
}

#[test]
fn the_bits_do_not_depend_on_how_a_run_is_divided() {
    let scene = behind(pad::<f32>(f64::INFINITY, AnyForceLaw::GapField), storage(1e-8, 1.0), 0.3);
    let vibration = sine::<f32>(0.2, 20.0);
    let whole = Driver::new(TrBdf2, adaptive(1e-3));
    let expected = run(&scene, &contact::Start::default(), &vibration, &whole, 2.0, &mut ());
    let pausing = Driver { pause_at_events: true, ..whole };
    let mut found = begin(&scene, &vibration, &whole);
    let end = Instant::from_whole_seconds(2);
    while found.clock < end {
        pausing.advance(&scene, &mut found, &vibration, end, 50, &mut ()).expect("runs");
    }
    assert_eq!(found, expected);
}

/// A large storage in `f32`: each conduction brings it less than a rounding of its voltage.
#[test]
fn a_supercapacitor_fills_in_single_precision() {
    let vibration = (sine::<f64>(0.2, 20.0), sine::<f32>(0.2, 20.0));
    let law = AnyForceLaw::TransferredCharge;
    let double = behind(pad::<f64>(f64::INFINITY, law), storage(1.0, 3.0), 0.3);
    let single = behind(pad::<f32>(f64::INFINITY, law), storage(1.0, 3.0), 0.3);
    let start = (contact::Start::default(), contact::Start::default());
    let (mut exact, mut meter) = (RunMeter::new(), RunMeter::new());
    let end = run(&double, &start.0, &vibration.0, &Driver::new(TrBdf2, fixed(1e-5)), 1.0, &mut exact);
    let found = run(&single, &start.1, &vibration.1, &Driver::new(TrBdf2, fixed(1e-5)), 1.0, &mut meter);
    let gained = store_gain_from(&double, &end, 3.0);
    let in_single = store_gain_from(&single, &found, 3.0);
    println!("{gained:e} J and {in_single:e} J stored, {:e} J delivered", exact.delivered_energy());
    assert!((in_single / gained - 1.0).abs() < 1e-3);
    // What leaks in a second through a gigaohm at 3 V is 9 nJ.
    assert!(((gained + 9.0 / 1e9) / exact.delivered_energy() - 1.0).abs() < 1e-4);
    assert!(single.storage_voltage(found.mode, &found.point.state) - 3.0 < 1e-5);
}

/// Energy in J that the storage of a scene has gained since `volts`.
fn store_gain_from<S, A>(scene: &A, state: &HybridState<S, A::Mode, STATES, WHOLE>, volts: f64) -> f64
where
    S: Scalar,
    A: Scene<S, STATES, WHOLE>,
{
    let now = scene.outputs(state.mode, &state.point).storage.expect("a storage");
    let mut earlier = now;
    (earlier.voltage, earlier.remainder) = (S::from_f64(volts), S::ZERO);
    now.gained_since(&earlier).expect("no bus").to_f64()
}

#[test]
fn what_is_out_of_bounds_is_refused_by_name() {
    let law = AnyForceLaw::GapField;
    let bridge = |diode_drop| FullBridge { diode_drop, storage: DcBus { voltage: 5.0_f64 } };
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

fn derivatives<H: ElectricalPort<f64>>(harvester: &H, mode: H::Mode, position: f64, step: f64) {
    for charge in [-0.05, 0.0, 0.1] {
        let at = |position, charge| harvester.port_voltage(mode, position, charge);
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

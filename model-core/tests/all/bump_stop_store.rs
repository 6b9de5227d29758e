//! The bump-stop harvester behind a full bridge: the trajectory of another program through six regimes, the energy
//! ledger with the storage, bits, and the cost of the step lengths.

use crate::bridged::{AnyBridge, Bridged, advance, baseline, close, resistor, seconds, storage, vibration};
use model_core::energy::{Ledger, RunMeter};
use model_core::excitation::Silence;
use model_core::observer::{AcceptedStep, Observer, PowerIndex};
use model_core::part::draw::{AnyDraw, CurrentDraw, Lockout, NoDraw, PowerDraw, ResistiveDraw};
use model_core::part::load::OpenCircuit;
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::{AnyStorage, Capacitor, DcBus, StorageCapacitor};
use model_core::part::storage_step::StorageState;
use model_core::scalar::Scalar;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{
    AnyChoices, AnyContact, AnyCoupling, Circuit, Resistive, Restitution, Start, State, StateOf, Stepper,
};

/// Open or in contact, blocked or conducting either way: 0.2 µF at 0.2 V under 2 MΩ, diodes of 0.05 V, a gap
/// of 5 µm.
fn six_regimes<S: Scalar>(short: f64, long: f64) -> Stepper<S, Bridged<S>, 4, 1> {
    let mut parameters = baseline(storage(0.2e-6, 0.2, resistor(2e6), 0.05));
    parameters.choices.stop.gap = S::from_f64(5e-6);
    Stepper::new(parameters.build().expect("valid"), S::from_f64(short), S::from_f64(long))
        .expect("in bounds")
}

/// Storage voltage and terminal voltage after 12 ms from rest, and the steps taken.
fn after_12_ms<S: Scalar>(stepper: &Stepper<S, Bridged<S>, 4, 1>) -> ([f64; 2], u32) {
    let excitation = vibration(220.0);
    let mut state = stepper.scene().start(&Start::default(), &excitation).expect("valid");
    let taken = stepper.advance(&mut state, &excitation, seconds(12e-3), u32::MAX, &mut ()).expect("runs");
    let voltages = [state.circuit.voltage, stepper.scene().voltage(&state)];
    (voltages.map(S::to_f64), taken.work.steps)
}

/// Another program, not in this repository: event-driven, in NumPy, by the eigenvectors of the six regimes; 54
/// events.
const STORE_VOLTS: f64 = 0.675_257_0;
const TERMINAL_VOLTS: f64 = 0.216_503_9;

#[test]
fn the_published_trajectory_is_approached_in_second_order() {
    let steps = [1e-6, 0.5e-6, 0.1e-6, 0.05e-6];
    let errors = steps.map(|step| {
        let ([storage, terminals], _) = after_12_ms(&six_regimes::<f64>(step, step));
        println!("{step:e}: {:e} {:e}", storage - STORE_VOLTS, terminals - TERMINAL_VOLTS);
        [(storage - STORE_VOLTS).abs(), (terminals - TERMINAL_VOLTS).abs()]
    });
    // As good at each step as the same method in another program.
    for (found, published) in errors.iter().zip([2.3e-4, 5.7e-5, 2.3e-6, 6.2e-7]) {
        assert!(found[0] < 1.02 * published, "{found:?}");
    }
    let order = |from: f64, to: f64, ratio: f64| (from / to).ln() / ratio.ln();
    for part in [0, 1] {
        assert!((order(errors[0][part], errors[1][part], 2.0) - 2.0).abs() < 0.1);
        assert!((order(errors[1][part], errors[2][part], 5.0) - 2.0).abs() < 0.1);
    }
}

#[test]
fn single_precision_follows_double_precision() {
    let ([fine, _], _) = after_12_ms(&six_regimes::<f64>(1e-6, 1e-6));
    let ([coarse, _], _) = after_12_ms(&six_regimes::<f32>(1e-6, 1e-6));
    close("six regimes", coarse, fine, 1e-4);
    // Half a second, and a storage that gains less than a rounding of its voltage in most steps.
    for farads in [4.7e-6, 1e-2] {
        let (coarse, fine) = (charged::<f32>(farads), charged::<f64>(farads));
        // A motion that chatters forgets its last digits: what is charged is a statistic.
        close(&format!("{farads} F"), coarse, fine, 2e-2);
    }
}

/// How far a storage rises from 1 V in half a second, the stop at mid-span; the ledger has to close.
fn charged<S: Scalar>(farads: f64) -> f64 {
    let mut parameters = baseline(storage::<S>(farads, 1.0, AnyDraw::None, 0.3));
    parameters.choices.stop.position = S::from_f64(0.025);
    let scene = parameters.build::<4, 1>().expect("valid");
    let stepper = Stepper::with_all_powers(scene, S::from_f64(1e-6), S::from_f64(2e-5)).expect("in bounds");
    let excitation = vibration(220.0);
    let mut state = scene.start(&Start::default(), &excitation).expect("valid");
    let mut ledger = Ledger::open(&stepper.outputs(&state));
    stepper.advance(&mut state, &excitation, seconds(0.5), u32::MAX, &mut ledger).expect("runs");
    let residual = ledger.residual().total().expect("work").to_f64();
    println!("{farads} F: residual {residual:e}");
    assert!(residual < 1e-3, "{residual}");
    state.circuit.voltage.to_f64() - 1.0
}

/// A long step in which the voltage or the current turns is not taken: the others change the voltage of the storage by less
/// than a part in five thousand, and all steps are a quarter of the short ones.
#[test]
fn long_steps_keep_the_store_voltage() {
    let ([single, _], all) = after_12_ms(&six_regimes::<f64>(1e-6, 1e-6));
    for long in [5e-6, 1e-5, 2e-5, 4e-5, 8e-5] {
        let ([storage, _], steps) = after_12_ms(&six_regimes::<f64>(1e-6, long));
        println!("{long:e}: {:e} in {steps} of {all} steps", storage - single);
        assert!(
            (storage - single).abs() < 2e-4 * single && steps < all / 4,
            "{long} {storage} {single} {steps}"
        );
    }
}

const LOCKOUT: Lockout<f64> = Lockout { turn_on: 0.45, turn_off: 0.3 };

#[test]
fn the_ledger_of_harvester_and_store_closes() {
    let drawn_by = |draw| (draw, AnyCoupling::TwoWay, AnyContact::ResidualFlexibility, 2e-5);
    let resistive = |coupling, contact, long| (resistor(2e6), coupling, contact, long);
    let restitution = AnyContact::Restitution(Restitution { coefficient: 0.5 });
    for (draw, coupling, contact, long) in [
        drawn_by(AnyDraw::None),
        drawn_by(resistor(2e6)),
        drawn_by(AnyDraw::Resistor(ResistiveDraw { resistance: 1e4, lockout: Some(LOCKOUT) })),
        drawn_by(AnyDraw::Current(CurrentDraw { current: 3e-5, lockout: LOCKOUT })),
        drawn_by(AnyDraw::Power(PowerDraw { power: 1e-5, lockout: LOCKOUT })),
        resistive(AnyCoupling::TwoWay, restitution, 1e-6),
        resistive(AnyCoupling::TwoWay, AnyContact::DisplacementConstraint, 1e-6),
        resistive(AnyCoupling::OneWay, AnyContact::ResidualFlexibility, 2e-5),
        resistive(AnyCoupling::TwoWay, AnyContact::NoStop, 8e-5),
    ] {
        let mut bridge = storage(0.2e-6, 0.2, draw, 0.05);
        if let AnyStorage::Capacitor(storage) = &mut bridge.storage {
            storage.capacitor.leakage_resistance = 5e6;
        }
        let mut parameters = baseline(bridge);
        parameters.choices.coupling = coupling;
        parameters.choices.stop.contact = contact;
        let scene = parameters.build::<4, 1>().expect("valid");
        let stepper = Stepper::with_all_powers(scene, 1e-6, long).expect("in bounds");
        let excitation = vibration(220.0);
        let mut state = scene.start(&Start::default(), &excitation).expect("valid");
        let mut ledger = Ledger::open(&stepper.outputs(&state));
        let mut meter = RunMeter::new();
        let mut both = (&mut ledger, &mut meter);
        stepper.advance(&mut state, &excitation, seconds(0.05), u32::MAX, &mut both).expect("runs");
        let residual = ledger.residual();
        let relative = residual.largest().expect("work");
        assert!(relative < 1e-10, "{draw:?} {coupling:?} {contact:?}: {residual:?}");
        // And against the storage's own energy, which the scale leaves out.
        let delivered = meter.delivered_energy();
        let [diodes, leaked, drawn] = [PowerIndex::Diodes, PowerIndex::Leakage, PowerIndex::Draw]
            .map(|power| meter.integrals().integral(power));
        assert!(residual.storage.abs() < 1e-10 * delivered, "{residual:?} {delivered}");
        let gained = 0.1e-6 * (state.circuit.voltage.powi(2) - 0.04);
        let left = delivered - leaked - drawn;
        assert!((gained - left).abs() < 1e-10 * delivered, "{gained} {left}");
        assert!(diodes > 0.0 && leaked > 0.0);
        assert!((drawn > 0.0) == (draw != AnyDraw::None));
    }
}

/// With neither damping nor shaking, what the motion has goes into storage and diodes and nowhere else, and no
/// step of any length makes energy; also where the coupling is far stronger than any material's.
#[test]
fn no_step_of_any_length_makes_energy() {
    for permittivity in [15.93e-9, 0.5e-9] {
        for step in [1e-7, 1e-6, 1e-5, 1e-4, 1e-3] {
            let mut parameters = baseline(storage(0.2e-6, 0.05, AnyDraw::None, 0.05));
            parameters.damping_ratio = 0.0;
            parameters.piezo_permittivity = permittivity;
            let scene = parameters.build::<6, 2>().expect("valid");
            let stepper = Stepper::with_all_powers(scene, step, step).expect("in bounds");
            let mut start = Start::default();
            start.beam[0] = [-30e-6 / 31.974_430_7, 0.0];
            let mut state = scene.start(&start, &Silence).expect("valid");
            let mut meter = RunMeter::new();
            let mut energy: f64 = stepper.outputs(&state).stored.total();
            let before = energy;
            let mut spent = 0.0;
            for k in 1..=20 {
                let end = f64::from(k) * if step < 5e-6 { 1e-3 } else { 2e-2 };
                stepper.advance(&mut state, &Silence, seconds(end), u32::MAX, &mut meter).expect("runs");
                let now = stepper.outputs(&state).stored.total();
                let diodes = meter.integrals().integral(PowerIndex::Diodes);
                let newly = meter.delivered_energy() + diodes - spent;
                assert!(newly >= 0.0 && (energy - now - newly).abs() < 1e-10 * before, "{step} {k}");
                (energy, spent) = (now, spent + newly);
            }
            assert!(spent > 0.01 * before, "{permittivity:e} {step}: {spent} of {before}");
        }
    }
}

/// A threshold that is never reached is an open circuit.
#[test]
fn behind_a_bus_out_of_reach_the_terminals_are_open_to_the_bit() {
    let bus = FullBridge { diode_drop: 0.3_f32, storage: DcBus { voltage: 1e6 } };
    fn run<L: Circuit<f32>>(load: L) -> ([[f32; 2]; 4], [[f32; 2]; 1], f32, f32, u32) {
        let stepper =
            Stepper::new(baseline(load).build::<4, 1>().expect("valid"), 1e-6, 2e-5).expect("in bounds");
        let excitation = vibration(220.0);
        let mut state: StateOf<f32, AnyChoices<f32, L>, 4, 1> =
            stepper.scene().start(&Start::default(), &excitation).expect("valid");
        let steps = stepper.advance(&mut state, &excitation, seconds(0.05), u32::MAX, &mut ()).expect("runs");
        (state.beam, state.rod, state.gap(), stepper.scene().voltage(&state), steps.work.steps)
    }
    assert_eq!(run(bus), run(Resistive(OpenCircuit)));
}

#[test]
fn a_store_chosen_when_compiling_has_the_bits_of_one_chosen_when_running() {
    let fixed = FullBridge {
        diode_drop: 0.3,
        storage: StorageCapacitor {
            capacitor: Capacitor { capacitance: 1e-6, leakage_resistance: f64::INFINITY },
            initial_voltage: 0.5,
            draw: NoDraw,
        },
    };
    let chosen: AnyBridge<f64> = storage(1e-6, 0.5, AnyDraw::None, 0.3);
    fn run<R: model_core::part::storage::StorageElement<f64>>(
        bridge: FullBridge<f64, R>,
    ) -> State<f64, 4, 1, StorageState<f64>> {
        let stepper =
            Stepper::new(baseline(bridge).build::<4, 1>().expect("valid"), 1e-6, 2e-5).expect("in bounds");
        let excitation = vibration(220.0);
        let mut state = stepper.scene().start(&Start::default(), &excitation).expect("valid");
        advance(&stepper, &mut state, &excitation, 0.03);
        state
    }
    let found = run(fixed);
    assert_eq!(found, run(chosen));
    assert!(found.circuit.voltage > 0.5);
}

#[test]
fn a_run_has_the_same_bits_however_budgets_divide_it() {
    // The second long step is hardly longer than the short one.
    for long in [2e-5, 1.000_002e-6] {
        let stepper = six_regimes::<f32>(1e-6, long);
        let excitation = vibration(220.0);
        let start = stepper.scene().start(&Start::default(), &excitation).expect("valid");
        let run = |budget| {
            let mut state = start;
            let mut calls = 0;
            while state.clock < seconds(0.05) {
                stepper.advance(&mut state, &excitation, seconds(0.05), budget, &mut ()).expect("runs");
                calls += 1;
            }
            (state, calls)
        };
        let (whole, once) = run(u32::MAX);
        for budget in [1, 100, 333] {
            let (divided, calls) = run(budget);
            assert_eq!(divided, whole);
            assert!(once == 1 && calls > 10);
        }
    }
}

/// Notes how a draw is switched.
#[derive(Default)]
struct Switching {
    /// Storage voltage in V at each connection and disconnection.
    on: Vec<f64>,
    off: Vec<f64>,
}

impl Observer<f64> for Switching {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        let [from, to] = [&step.start, &step.end].map(|outputs| outputs.storage.expect("a storage"));
        match (from.connected, to.connected) {
            (false, true) => self.on.push(to.voltage),
            (true, false) => self.off.push(to.voltage),
            _ => {}
        }
    }
}

#[test]
fn a_draw_is_connected_and_disconnected_at_its_thresholds() {
    let always = storage::<f64>(1e-6, 0.0, resistor(1e6), 0.05);
    assert!(Circuit::<f64>::start(&always).connected, "a resistor without lock-out");
    let (turn_on, turn_off) = (1.2, 0.8);
    let lockout = Lockout { turn_on, turn_off };
    let amperes = 4e-5;
    let draw = AnyDraw::Current(CurrentDraw { current: amperes, lockout });
    let mut parameters = baseline(storage(1e-6, 1.0, draw, 0.05));
    parameters.choices.stop.position = 0.025;
    let scene = parameters.build::<4, 1>().expect("valid");
    let stepper = Stepper::new(scene, 1e-6, 2e-5).expect("in bounds");
    let excitation = vibration(220.0);
    let mut state = scene.start(&Start::default(), &excitation).expect("valid");
    assert!(!state.circuit.connected);
    let mut seen = Switching::default();
    stepper.advance(&mut state, &excitation, seconds(1.0), u32::MAX, &mut seen).expect("runs");
    println!("{} on, {} off", seen.on.len(), seen.off.len());
    assert!(seen.on.len() > 3 && seen.on.len().abs_diff(seen.off.len()) <= 1);
    // Looked at where a step ends: within what a step brings or takes.
    assert!(seen.off.iter().all(|volts| (turn_off - amperes * 2e-5 / 1e-6..=turn_off).contains(volts)));
    assert!(seen.on.iter().all(|volts| (turn_on..turn_on + 0.05).contains(volts)));
}

//! A mass on a spring with a stiff elastic stop: `x'' = −x`, and `x'' = −x − K (x − 1/2)` while `x > 1/2`, from rest
//! at `x = −1`.
//!
//! Closed form: the mass reaches the stop at `2π/3` with the speed `√3/2`. In contact the motion is harmonic with `Ω²
//! = 1 + K` about `p = −1/(2 Ω²)`, which gives its duration and its depth. Energy is conserved, so the motion is
//! periodic.
//!
//! Asserted for `K = 10⁴, 10⁶, 10⁸`, in both precisions: all of these with adaptive steps; with fixed steps, the
//! order of the method for the duration, and one order more for the energy, the dissipation of a method on a harmonic
//! motion (`|R(iz)| − 1`).
//!
//! The coordinate is the penetration `p = x − 1/2`, so that single precision resolves the contact.

use crate::common::{Leap, Problem, Run, adaptive, fixed, precision};
use model_core::clock::{LONGEST_STEP_S, TICKS_PER_SECOND};
use model_core::excitation::Silence;
use model_core::integrate::{Method, RungeKutta4, StepControl, TrBdf2};
use model_core::scalar::Scalar;

const GAP: f64 = 0.5;
const TICK: f64 = 1.0 / TICKS_PER_SECOND as f64;

/// How late TR-BDF2 is on a harmonic motion, per radian and square of the step in radians: `(3√2 − 4)/6`.
const LATE: f64 = 0.040_440;
/// What part of the energy it loses, per radian and cube of the step: `(17 − 12√2)/4`.
const LOSS: f64 = 0.007_359;

/// Bounds of what free flight in steps of `radians` adds to the time and the speed of the first hit, the period, and the
/// energy after three periods.
fn free_flight(radians: f64) -> [f64; 4] {
    let to_hit = core::f64::consts::TAU / 3.0;
    let (late, loss) = (1.05 * LATE * radians.powi(2), 1.05 * LOSS * radians.powi(3));
    // The energy is 1/2 and the speed √(3/4).
    [late * to_hit, loss * to_hit * 0.5 / 0.75f64.sqrt(), late * 2.0 * to_hit, loss * 6.0 * to_hit]
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    Open,
    Contact,
}

#[derive(Debug, Clone, Copy)]
struct Stop {
    stiffness: f64,
}

impl Stop {
    fn stiffness(&self, mode: Mode) -> f64 {
        if mode == Mode::Contact { 1.0 + self.stiffness } else { 1.0 }
    }
}

impl<S: Scalar> Problem<S, 2> for Stop {
    type Mode = Mode;

    fn number(&self, mode: Mode) -> u8 {
        mode as u8
    }

    fn rate(&self, mode: Mode, y: &[S; 2], _input: S) -> [S; 2] {
        [y[1], -S::from_f64(self.stiffness(mode)) * y[0] - S::from_f64(GAP)]
    }

    fn jacobian(&self, mode: Mode, _y: &[S; 2], _input: S) -> [[S; 2]; 2] {
        [[S::ZERO, S::ONE], [-S::from_f64(self.stiffness(mode)), S::ZERO]]
    }

    fn sizes(&self, mode: Mode, _y: &[S; 2]) -> [S; 2] {
        // What an energy of one half is as a deflection and as a speed.
        [S::from_f64(1.0 / self.stiffness(mode).sqrt()), S::ONE]
    }

    fn guards(&self, _mode: Mode) -> usize {
        1
    }

    fn guard(&self, mode: Mode, _index: usize, _armed: bool, y: &[S; 2], rate: &[S; 2]) -> [S; 2] {
        if mode == Mode::Open { [-y[0], -rate[0]] } else { [y[0], rate[0]] }
    }

    fn leap(&self, mode: Mode, _index: usize, y: &[S; 2]) -> Leap<S, Mode, 2> {
        let mode = if mode == Mode::Open { Mode::Contact } else { Mode::Open };
        Leap { mode, state: *y, armed: true }
    }
}

/// Contact time, period and penetration, from the closed form.
fn exact(stiffness: f64) -> [f64; 3] {
    let speed = (1.0 - GAP * GAP).sqrt();
    let omega = (1.0 + stiffness).sqrt();
    // In contact p = −c + A cos(Ω t − φ) with c = GAP/Ω²: met and left where p = 0.
    let centre = GAP / (omega * omega);
    let amplitude = centre.hypot(speed / omega);
    let contact = 2.0 / omega * (centre / amplitude).acos();
    let free = core::f64::consts::TAU - 2.0 * GAP.acos();
    [contact, free + contact, amplitude - centre]
}

const PRINTED: [(f64, [f64; 3]); 3] = [
    (1e4, [0.031_298_898_632_102, 4.220_089_103_418_493, 8.609_970_371_832_643e-3]),
    (1e6, [0.003_140_436_383_539, 4.191_930_641_169_930, 8.655_251_156e-4]),
    (1e8, [3.141_477_167_828_822e-4, 4.189_104_352_503_174, 8.659_754_009e-5]),
];

#[derive(Debug, Clone, Copy)]
struct Errors {
    hit_time: f64,
    hit_speed: f64,
    /// Relative to the contact.
    contact: f64,
    period: f64,
    /// Relative; of the largest value at the end of a step, which may stop short of the peak.
    penetration: f64,
    /// Energy gained over three contacts, relative.
    energy: f64,
}

fn measure<S: Scalar>(
    name: &str,
    stiffness: f64,
    method: impl Method<S>,
    control: impl StepControl<S>,
) -> Errors {
    let start = [S::from_f64(-1.0 - GAP), S::ZERO];
    let mut run = Run::start(Stop { stiffness }, Mode::Open, start, Silence, method, control);
    let [contact, period, penetration] = exact(stiffness);
    let work = run.to(3.0 * period).expect("smooth");
    let events = &run.log.events;
    assert_eq!(events.len(), 6, "three contacts, each met and left");
    let energy = |p: f64, v: f64| 0.5 * (v * v + (p + GAP) * (p + GAP));
    let errors = Errors {
        hit_time: events[0].at - core::f64::consts::TAU / 3.0,
        hit_speed: events[0].reached[1] - 0.75f64.sqrt(),
        contact: (events[1].at - events[0].at) / contact - 1.0,
        period: 0.5 * (events[4].at - events[0].at) - period,
        penetration: run.log.highest / penetration - 1.0,
        energy: energy(run.entry(0), run.entry(1)) / 0.5 - 1.0,
    };
    println!(
        "stop {stiffness:.0e} {name} {}: hit {:.1e} s, {:.1e} m/s, contact {:.1e}, period {:.1e} s, depth {:.1e}, energy {:.1e}; {} steps",
        precision::<S>(),
        errors.hit_time,
        errors.hit_speed,
        errors.contact,
        errors.period,
        errors.penetration,
        errors.energy,
        work.steps
    );
    errors
}

impl Errors {
    /// Fails unless each error is below its bound; in the order of the fields.
    fn assert_below(&self, bounds: [f64; 6]) {
        let errors =
            [self.hit_time, self.hit_speed, self.contact, self.period, self.penetration, self.energy];
        for (error, bound) in errors.iter().zip(bounds) {
            assert!(error.abs() < bound, "{self:?}, bounds {bounds:?}");
        }
    }
}

#[test]
fn adaptive_steps_follow_a_contact_of_any_stiffness() {
    for (stiffness, printed) in PRINTED {
        for (exact, printed) in exact(stiffness).into_iter().zip(printed) {
            assert!((exact / printed - 1.0).abs() < 1e-9, "{exact} {printed}");
        }
        for tolerance in [1e-3, 1e-4, 1e-5] {
            let name = format!("adaptive {tolerance:.0e}");
            // A step is allowed a twentieth of the tolerance per radian.
            let step = (tolerance / 20.0 / LATE).sqrt().min(LONGEST_STEP_S);
            let [late, slow, period, energy] = free_flight(step);
            measure::<f64>(&name, stiffness, TrBdf2, adaptive(tolerance))
                .assert_below([late, slow, 1e-6, period, 1e-6, energy]);
            // The few roundings that a step is allowed take over: it is the longest of the clock.
            let [late, slow, period, energy] = free_flight(LONGEST_STEP_S);
            measure::<f32>(&name, stiffness, TrBdf2, adaptive(tolerance)).assert_below([
                late + 7e-7,
                slow + 4e-8,
                5e-5,
                period + 2e-6,
                5e-5,
                energy + 1e-6,
            ]);
        }
    }
}

fn assert_orders<M: Method<f64> + Method<f32> + Copy>(name: &str, method: M, order: f64) {
    // The stiffest takes ten times the steps.
    for &(stiffness, _) in &PRINTED[..2] {
        // 16 steps in a contact, and 31: their errors are far above a tick.
        let lengths = [0.2, 0.1];
        let [coarse, fine] = lengths.map(|radians| {
            let step = radians / stiffness.sqrt();
            let double = measure::<f64>(name, stiffness, method, fixed(step));
            let single = measure::<f32>(name, stiffness, method, fixed(step));
            // Rounding adds little to what the method does.
            assert!((double.contact - single.contact).abs() < 1e-6, "{double:?} {single:?}");
            assert!((double.period - single.period).abs() < 1e-6, "{double:?} {single:?}");
            assert!((double.energy - single.energy).abs() < 4e-7, "{double:?} {single:?}");
            double
        });
        for (errors, radians) in [coarse, fine].into_iter().zip(lengths) {
            let [late, slow, ..] = free_flight(radians / stiffness.sqrt());
            let within = errors.hit_time.abs() < late + TICK && errors.hit_speed.abs() < slow + TICK;
            assert!(within, "{errors:?}");
            // No motion gains energy.
            assert!(errors.energy < 0.0, "{errors:?}");
        }
        let contact = (coarse.contact / fine.contact).log2();
        let energy = (coarse.energy / fine.energy).log2();
        println!("stop {stiffness:.0e} {name}: order of the contact {contact:.3}, of the energy {energy:.3}");
        assert!((contact - order).abs() < 0.1, "{contact}");
        assert!((energy - order - 1.0).abs() < 0.1, "{energy}");
    }
}

#[test]
fn fixed_steps_keep_the_order_of_the_method_through_contacts() {
    assert_orders("TR-BDF2", TrBdf2, 2.0);
    assert_orders("RK4", RungeKutta4, 4.0);
}

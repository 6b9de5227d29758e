//! A split system of the user: a magnet on a spring in a coil, whose circuit is driven by the velocity.
//!
//! ```text
//! m x'' + c x' + k x + T i = −m a        L i' + R i = T x'
//! ```

use super::order;
use crate::bridge::sine;
use crate::common::{adaptive, fixed};
use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::Excitation;
use model_core::hybrid::{Automaton, Driver, HybridState};
use model_core::integrate::{
    CircuitEquation, DenseFactor, ErrorScale, ExponentialRadau, Method, Point, Stage, StepControl, System,
    TrBdf2,
};
use model_core::oscillator::Oscillator;

/// Units: kg, N s/m, N/m, N/A, H, Ω.
#[rustfmt::skip]
#[derive(Debug, Clone, Copy)]
struct Coil { m: f64, c: f64, k: f64, t: f64, l: f64, r: f64 }

impl System<f64, 3, 1> for &Coil {
    type Factor = DenseFactor<f64, 3>;

    fn flow(&self, &[x, v, i]: &[f64; 3], a: f64) -> [f64; 3] {
        [v, -(self.c * v + self.k * x + self.t * i) / self.m - a, (self.t * v - self.r * i) / self.l]
    }

    fn factor(&self, _state: &[f64; 3], _a: f64, weight: f64) -> Option<Self::Factor> {
        let Coil { m, c, k, t, l, r } = **self;
        DenseFactor::new(&[[0.0, 1.0, 0.0], [-k / m, -c / m, -t / m], [0.0, t / l, -r / l]], weight)
    }

    fn solve(&self, factor: &Self::Factor, right: [f64; 3]) -> [f64; 3] {
        factor.solve(&right)
    }

    fn powers(&self, &[_, _, i]: &[f64; 3], _derivative: &[f64; 3], _a: f64) -> [f64; 1] {
        [self.r * i * i]
    }

    const SPLIT: bool = true;

    fn oscillator(&self) -> Option<Oscillator<f64>> {
        let Coil { m, c, k, .. } = **self;
        Some(Oscillator { stiffness: k / m, damping: c / m, rest: 0.0, base_coupling: 1.0 })
    }

    fn force_rate(&self, _state: &[f64; 3], &[_, _, current_rate]: &[f64; 3]) -> f64 {
        -self.t * current_rate / self.m
    }

    fn stage(&self, start: &Point<f64, 3, 1>, _displacement: f64, velocity: f64) -> Stage<f64> {
        let Coil { m, t, l, r, .. } = **self;
        let [_, before, current] = start.state;
        let drive = l * start.derivative[2] + t * (velocity - before);
        let circuit = CircuitEquation { inertia: l, stiffness: r, drive };
        Stage { circuit: Some(circuit), force: [-t * current / m, -t / m, 0.0] }
    }

    fn error_norm(&self, _state: &[f64; 3], change: &[f64; 3]) -> f64 {
        let speed = 1e-3 * (self.k / self.m).sqrt();
        let sizes = [1e-3, speed, self.t * speed / self.r];
        change.iter().zip(sizes).fold(0.0, |largest, (part, size)| f64::max(largest, (part / size).abs()))
    }
}

impl Automaton<f64, 3, 1> for Coil {
    type Mode = ();
    type Flow<'a> = &'a Coil;

    fn flow(&self, (): ()) -> &Coil {
        self
    }

    fn error_scale(&self) -> ErrorScale<f64> {
        ErrorScale { angular_frequency: (self.k / self.m).sqrt(), decay_rate: 0.0, energy_floor: 1e-12 }
    }
}

/// Mean power in W and state after a quarter of a second from a displacement of 1 mm.
fn shake(coil: &Coil, method: impl Method<f64>, control: impl StepControl<f64>) -> (f64, [f64; 3]) {
    let vibration = sine::<f64>(0.3, 23.0);
    assert!(vibration.angular_frequency() > 0.0);
    let mut state: HybridState<f64, (), 3, 1> =
        HybridState::start(coil, (), [1e-3, 0.0, 0.0], &vibration, &control);
    let mut meter = PowerMeter::new();
    let until = Instant::from_seconds(0.25).expect("in range");
    Driver::new(method, control)
        .advance(coil, &mut state, &vibration, until, u32::MAX, &mut meter)
        .expect("runs to its end");
    (meter.mean_power(), state.point.state)
}

/// A weakly coupled coil, a strongly coupled one, and a fast circuit.
const COILS: [Coil; 3] = [
    Coil { m: 5e-3, c: 0.02, k: 80.0, t: 1.0, l: 1e-2, r: 1e3 },
    Coil { m: 5e-3, c: 0.02, k: 80.0, t: 8.0, l: 1.0, r: 100.0 },
    Coil { m: 5e-3, c: 0.02, k: 80.0, t: 20.0, l: 1e-4, r: 1e3 },
];

#[test]
fn a_circuit_that_the_velocity_drives_agrees_with_tr_bdf2() {
    for coil in COILS {
        let (exact, at) = shake(&coil, TrBdf2, adaptive(1e-7));
        let (found, there) = shake(&coil, ExponentialRadau, adaptive(1e-6));
        let off = System::error_norm(&&coil, &at, &core::array::from_fn(|i| there[i] - at[i]));
        println!("{coil:?}: {found:e} W, off by {:.1e}, state {off:.1e}", found / exact - 1.0);
        assert!((found / exact - 1.0).abs() < 1e-5 && off < 1e-5, "{coil:?}");
    }
}

#[test]
fn its_order_is_three() {
    let steps = [3.2e-3, 2.26e-3, 1.6e-3, 1.13e-3];
    for coil in COILS {
        let at = |step| shake(&coil, ExponentialRadau, fixed(step)).0;
        let exact = at(5e-5);
        let errors = steps.map(|step| (at(step) / exact - 1.0).abs());
        let order = order(&steps, &errors);
        println!("{coil:?}: {errors:?}, order {order:.2}");
        assert!(order > 2.7, "{coil:?}: {errors:?}");
    }
}

//! A user-defined harvester: a base-excited magnet on a spring in a coil, with an end stop.
//!
//! ```text
//! m x'' + c x' + k x + T i = −m a        L i' + R i = T x'        at x = travel: x' → −e x'
//! ```
//!
//! `x`: displacement relative to the housing in m, `i`: current in A, `a`: base acceleration in m/s², `R`: load in Ω.
use model_core::clock::Instant;
use model_core::energy::estimator::{Interpolation, SampleFormat, Settings};
use model_core::energy::{Estimator, Ledger, RunMeter};
use model_core::excitation::{Excitation, Sine};
use model_core::hybrid::{Automaton, Guard, HybridState, InputAt, Jump};
use model_core::integrate::{Adaptive, DenseFactor, ErrorScale, Point, StepControl, System, TrBdf2};
use model_core::observer::{ALL_POWERS, Motion, Outputs, PowerIndex};
use model_core::scene::{Harvester, ParameterError, Scene, Simulation};
use model_core::snapshot::Fingerprint;

/// Units: kg, N s/m, N/m, N/A, H, Ω, m; the restitution `e` is 0 to 1.
#[rustfmt::skip]
#[derive(Debug, Clone, Copy)]
struct Coil { m: f32, c: f32, k: f32, t: f32, l: f32, r: f32, travel: f32, e: f32 }

type At = Point<f32, 3, ALL_POWERS>;

impl System<f32, 3, ALL_POWERS> for &Coil {
    type Factor = DenseFactor<f32, 3>;
    fn flow(&self, &[x, v, i]: &[f32; 3], a: f32) -> [f32; 3] {
        [v, -(self.c * v + self.k * x + self.t * i) / self.m - a, (self.t * v - self.r * i) / self.l]
    }
    fn factor(&self, _state: &[f32; 3], _a: f32, weight: f32) -> Option<Self::Factor> {
        let Coil { m, c, k, t, l, r, .. } = **self;
        let jacobian = [[0.0, 1.0, 0.0], [-k / m, -c / m, -t / m], [0.0, t / l, -r / l]];
        DenseFactor::new(&jacobian, weight)
    }
    fn solve(&self, factor: &Self::Factor, right: [f32; 3]) -> [f32; 3] {
        factor.solve(&right)
    }
    fn powers(&self, &[_, v, i]: &[f32; 3], _derivative: &[f32; 3], a: f32) -> [f32; ALL_POWERS] {
        let mut powers = [0.0; ALL_POWERS];
        powers[PowerIndex::Load as usize] = self.r * i * i;
        powers[PowerIndex::Base as usize] = -self.m * v * a;
        powers[PowerIndex::BaseMagnitude as usize] = (self.m * v * a).abs();
        powers[PowerIndex::Dissipation as usize] = self.c * v * v;
        powers[PowerIndex::ElectrostaticWork as usize] = self.t * i * v;
        powers[PowerIndex::FieldWork as usize] = self.t * i * v;
        powers
    }
    fn error_norm(&self, _state: &[f32; 3], change: &[f32; 3]) -> f32 {
        let speed = self.travel * (self.k / self.m).sqrt();
        let sizes = [self.travel, speed, self.t * speed / self.r];
        change.iter().zip(sizes).fold(0.0, |largest, (part, size)| f32::max(largest, (part / size).abs()))
    }
}

impl Automaton<f32, 3, ALL_POWERS> for Coil {
    type Mode = ();
    type Flow<'a> = &'a Coil;
    #[rustfmt::skip]
    fn flow(&self, (): ()) -> &Coil { self }
    #[rustfmt::skip]
    fn guards(&self, (): ()) -> usize { 1 }
    fn guard<E: Excitation<f32>>(&self, (): (), _: usize, _: bool, p: &At, _: &InputAt<'_, E>) -> Guard<f32> {
        Guard { value: self.travel - p.state[0], rate: -p.state[1] }
    }
    #[rustfmt::skip]
    fn jump<E: Excitation<f32>>(&self, (): (), _: usize, p: &At, a: &InputAt<'_, E>, _: f32) -> Jump<f32, (), 3> {
        let state = [self.travel, -self.e * p.state[1], p.state[2]];
        let derivative = System::flow(&self, &state, a.acceleration());
        let loss = 0.5 * self.m * (p.state[1] * p.state[1] - state[1] * state[1]);
        Jump { mode: (), state, remainder: [0.0; 3], derivative, loss, armed: true }
    }
    #[rustfmt::skip]
    fn is_impact(&self, (): (), _index: usize) -> bool { true }
    fn outputs<'a>(&self, (): (), point: &'a At) -> Outputs<'a, f32> {
        let [x, v, i] = point.state;
        let mut outputs = Outputs::of_state(&point.state);
        outputs.motions[0] = Motion { value: x, rate: v };
        outputs.voltage = self.r * i;
        outputs.stored.mechanical = 0.5 * (self.m * v * v + self.k * x * x);
        outputs.stored.electrical = 0.5 * self.l * i * i;
        outputs
    }
    fn error_scale(&self) -> ErrorScale<f32> {
        let [angular_frequency, decay_rate] = [(self.k / self.m).sqrt(), 0.5 * self.c / self.m];
        ErrorScale { angular_frequency, decay_rate, energy_floor: 1e-12 }
    }
}

impl Scene<f32, 3, ALL_POWERS> for Coil {
    type Start = [f32; 3];
    #[rustfmt::skip]
    fn start<E: Excitation<f32>, C: StepControl<f32>>(&self, start: &[f32; 3], excitation: &E, control: &C)
        -> Result<HybridState<f32, (), 3, ALL_POWERS>, ParameterError<f32>> {
        Ok(HybridState::start(self, (), *start, excitation, control))
    }
    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.numbers(&[self.m, self.c, self.k, self.t, self.l, self.r, self.travel, self.e]);
    }
}

fn main() -> Result<(), model_core::Error> {
    let coil = Coil { m: 5e-3, c: 0.02, k: 80.0, t: 4.0, l: 1e-2, r: 1e3, travel: 1e-3, e: 0.6 };
    let harvester = Simulation::with_all_powers(coil, TrBdf2, Adaptive::new(1e-3)?);
    let vibration = Sine::<f32>::new(3.0, 20.0, 0.0)?; // m/s², Hz, rad
    let mut state = harvester.start(&[0.0; 3], &vibration)?;
    let (mut meter, mut ledger) = (RunMeter::new(), Ledger::open(&harvester.outputs(&state)));
    let end = Instant::from_whole_seconds(2);
    harvester.advance(&mut state, &vibration, end, 1_000_000, &mut (&mut meter, &mut ledger))?;
    let residual = ledger.residual().largest();
    println!("{:.3e} W, {} impacts, ledger {residual:?}", meter.mean_power(), meter.report().impacts);
    assert!(residual.is_some_and(|residual| residual < 1e-3), "the energy ledger closes");
    let format = SampleFormat::accelerations(100.0, 0.0);
    let settings = Settings {
        rate: 1000.0,
        format,
        longest_gap: 0,
        settling_seconds: 0.0,
        rate_tolerance: 0.0,
        jitter: 0.0,
        interpolation: Interpolation::DroopCompensated,
        bias_seconds: None,
    };
    let mut estimator = Estimator::new(harvester, settings)?;
    for sample in 0..2000 {
        let at = Instant::from_seconds(sample as f32 / 1000.0).unwrap_or(Instant::START);
        let _ = estimator.push_acceleration(vibration.acceleration(at), u32::MAX)?;
    }
    println!("{:.3e} W from samples", estimator.estimate().mean_power);
    Ok(())
}

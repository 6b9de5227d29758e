//! What the parts of a node that steps its harvester's model add to the harvester: the bridge, the storage, the estimator.
//!
//! Each variant has the parts of those before it. The base moves as in [`PASSIVE`]; the estimator takes its acceleration as
//! samples.

use core::hint::black_box;

use model_core::clock::Instant;
use model_core::energy::Estimator;
use model_core::energy::estimator::{Interpolation, SampleFormat, Settings};
use model_core::excitation::{Excitation, Sine};
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::part::draw::NoDraw;
use model_core::part::load::OpenCircuit;
use model_core::part::storage::{Capacitor, DcBus, StorageCapacitor, StorageElement};
use model_core::scene::contact_separation::Start;
use model_core::scene::rectified::{FullBridge, Rectified};
use model_core::scene::{Harvester, Simulation};

use super::contact_separation::parts::{self, LOAD};
use super::contact_separation::{PASSIVE, TOLERANCE};
use super::run::{self, Run};
use super::{Progress, Visit, Workload, show};

/// Voltage in volts of the bus, and of the storage at the start.
pub const VOLTAGE: f32 = 2.6;
/// Capacitance of the storage in farads.
pub const CAPACITANCE: f32 = 22e-6;
/// Forward voltage in volts of each of the bridge's diodes.
pub const DIODE_DROP: f32 = 0.3;
/// Samples per second, and metres per second squared in a raw count: a range of 2 g in 16 bits.
const RATE_HZ: u32 = 400;
const SCALE: f32 = model_core::part::GRAVITY as f32 / 16384.0;
/// Samples in two periods of the base.
const PERIOD: usize = 39;
/// Whole seconds of a run.
const SECONDS: u32 = PASSIVE.quarters * PASSIVE.samples / 4;

/// The harvester with a resistor.
pub fn resistor(visit: Visit<'_>) -> Option<()> {
    let scene = black_box(parts::passive(LOAD)).build().ok()?;
    let harvester = Simulation::new(scene, ExponentialRadau, Adaptive::new(TOLERANCE).ok()?);
    show(visit, shaken(harvester))
}

/// The harvester behind a bridge into a bus of a constant voltage.
pub fn bus(visit: Visit<'_>) -> Option<()> {
    show(visit, shaken(behind_bridge(DcBus { voltage: VOLTAGE })?))
}

/// The harvester behind a bridge that charges a storage.
pub fn storage(visit: Visit<'_>) -> Option<()> {
    show(visit, shaken(charging()?))
}

/// The estimator of the harvester that charges a storage.
pub fn estimator(visit: Visit<'_>) -> Option<()> {
    let settings = Settings {
        rate: RATE_HZ as f32,
        format: SampleFormat::counts(SCALE, i16::MAX.unsigned_abs()),
        longest_gap: 4,
        settling_seconds: 0.0,
        rate_tolerance: 0.0,
        jitter: 0.0,
        interpolation: Interpolation::DroopCompensated,
        bias_seconds: None,
    };
    let sine = Sine::<f32>::new(black_box(PASSIVE.amplitude), black_box(PASSIVE.frequency), 0.0).ok()?;
    let mut counts = [0; PERIOD];
    for (place, count) in (0_u16..).zip(&mut counts) {
        let raw: f32 = sine.acceleration(Instant::from_seconds(f32::from(place) / RATE_HZ as f32)?) / SCALE;
        *count = raw as i16;
    }
    let estimator = Estimator::new(charging()?, settings).ok()?;
    show(visit, Some(Sampled { estimator, counts, place: 0, seconds: 0, energy: 0.0, bits: [0; 5] }))
}

#[inline(never)]
fn shaken<H: Harvester<f32, Start = Start<f32>>>(harvester: H) -> Option<impl Workload> {
    Run::new(PASSIVE, harvester, &Start::default(), run::outputs)
}

fn charging() -> Option<impl Harvester<f32, Start = Start<f32>>> {
    let capacitor = Capacitor { capacitance: CAPACITANCE, leakage_resistance: f32::INFINITY };
    behind_bridge(StorageCapacitor { capacitor, initial_voltage: VOLTAGE, draw: NoDraw })
}

/// The harvester behind a full bridge that charges `storage`.
fn behind_bridge(storage: impl StorageElement<f32>) -> Option<impl Harvester<f32, Start = Start<f32>>> {
    let bridge = FullBridge { diode_drop: DIODE_DROP, storage };
    // The bridge is what is at the terminals.
    let alone = black_box(parts::passive(OpenCircuit)).build().ok()?;
    let scene = Rectified::new(alone, black_box(bridge)).ok()?;
    Some(Simulation::new(scene, ExponentialRadau, Adaptive::new(TOLERANCE).ok()?))
}

/// An estimator that is fed a sine. A sample of the workload is a whole second.
#[derive(Debug)]
struct Sampled<H: Harvester<f32>> {
    estimator: Estimator<f32, H>,
    counts: [i16; PERIOD],
    place: usize,
    seconds: u32,
    /// Energy so far in J.
    energy: f32,
    bits: [u32; 5],
}

impl<H: Harvester<f32>> Sampled<H> {
    /// Takes a second of samples; gives the steps.
    fn second(&mut self) -> Option<u32> {
        let mut steps = 0;
        for _ in 0..RATE_HZ {
            let count = *self.counts.get(self.place)?;
            self.place = if self.place + 1 == PERIOD { 0 } else { self.place + 1 };
            steps += self.estimator.push_count(count, u32::MAX).ok()?.work.steps;
        }
        Some(steps)
    }
}

impl<H: Harvester<f32>> Workload for Sampled<H> {
    fn name(&self) -> &'static str {
        "node"
    }

    fn advance(&mut self) -> Progress {
        if self.seconds == SECONDS {
            return Progress::Finished;
        }
        self.seconds += 1;
        let Some(steps) = self.second() else { return Progress::Failed };
        let estimate = self.estimator.estimate();
        self.estimator.clear();
        self.energy += estimate.energy;
        let relative = estimate.uncertainty.relative.unwrap_or(f32::INFINITY);
        let [energy, power, relative] = [estimate.energy, estimate.mean_power, relative].map(f32::to_bits);
        self.bits = [energy, power, relative, self.seconds, self.energy.to_bits()];
        Progress::Sample { steps, simulated_us: 1_000_000 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

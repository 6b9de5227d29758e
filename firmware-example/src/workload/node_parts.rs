//! What the parts of a node add to its harvester: the bridge, the storage, the estimator, the budget, the snapshots.
//!
//! Each variant has the parts of those before it. The base moves as in [`PASSIVE`]; from the estimator on its
//! acceleration comes as samples.

use core::hint::black_box;

use model_core::clock::Instant;
use model_core::energy::Estimator;
use model_core::excitation::{Excitation, Sine};
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::part::storage::DcBus;
use model_core::scene::contact_separation::Start;
use model_core::scene::{Harvester, Simulation};

use super::contact_separation::parts::{self, LOAD};
use super::contact_separation::{PASSIVE, TOLERANCE};
use super::run::{self, Run};
use super::{Progress, Visit, Workload, show};
use crate::following::{
    Board, Decision, Following, RATE_HZ, SCALE, SLOT_BYTES, behind_bridge, charging, settings,
};

pub use crate::following::{CAPACITANCE, DIODE_DROP};

/// Voltage in volts of the bus, and of the storage at the start.
pub const VOLTAGE: f32 = 2.6;
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
    show(visit, shaken(behind_bridge(DcBus { voltage: VOLTAGE }).ok()?))
}

/// The harvester behind a bridge that charges a storage.
pub fn storage(visit: Visit<'_>) -> Option<()> {
    show(visit, shaken(charging(VOLTAGE).ok()?))
}

#[inline(never)]
fn shaken<H: Harvester<f32, Start = Start<f32>>>(harvester: H) -> Option<impl Workload> {
    Run::new(PASSIVE, harvester, &Start::default(), run::outputs)
}

/// The estimator of the harvester that charges a storage.
pub fn estimator(visit: Visit<'_>) -> Option<()> {
    let mut board = SineBoard::new()?;
    let mut estimator = Estimator::new(charging(VOLTAGE).ok()?, settings()).ok()?;
    each_second(visit, |_, energy, words| {
        let mut steps = 0;
        for _ in 0..RATE_HZ {
            steps += estimator.push_count(board.acceleration()?, u32::MAX).ok()?.work.steps;
        }
        let estimate = estimator.estimate();
        estimator.clear();
        *energy += estimate.energy;
        let relative = estimate.uncertainty.relative.unwrap_or(f32::INFINITY);
        *words = [estimate.energy, estimate.mean_power, relative].map(f32::to_bits);
        Some(steps)
    })
}

/// The same with the budget, and a decision each second.
pub fn budget(visit: Visit<'_>) -> Option<()> {
    let mut node = Following::new(SineBoard::new()?, charging(VOLTAGE).ok()?).ok()?;
    each_second(visit, |_, energy, words| {
        let report = node.second().ok()?;
        *energy += report.harvested;
        *words = [report.harvested.to_bits(), report.stored.to_bits(), report.decision as u32];
        Some(report.steps)
    })
}

/// The same with an image of all states each second.
pub fn snapshot(visit: Visit<'_>) -> Option<()> {
    let mut node = Following::new(SineBoard::new()?, charging(VOLTAGE).ok()?).ok()?;
    let mut slot = [0; SLOT_BYTES];
    each_second(visit, |second, energy, words| {
        let report = node.second().ok()?;
        *energy += report.harvested;
        let bytes = node.save(second, &mut slot).ok()?;
        // The CRC-32 of the image.
        let checksum = u32::from_le_bytes(*slot.get(..bytes)?.last_chunk()?);
        *words = [report.harvested.to_bits(), report.stored.to_bits(), checksum];
        Some(report.steps)
    })
}

/// A board whose base moves as in [`PASSIVE`].
#[derive(Debug)]
struct SineBoard {
    counts: [i16; PERIOD],
    place: usize,
    awake: bool,
}

impl SineBoard {
    fn new() -> Option<Self> {
        let sine = Sine::<f32>::new(black_box(PASSIVE.amplitude), black_box(PASSIVE.frequency), 0.0).ok()?;
        let mut counts = [0; PERIOD];
        for (place, count) in (0_u16..).zip(&mut counts) {
            let at = Instant::from_seconds(f32::from(place) / RATE_HZ as f32)?;
            let raw: f32 = sine.acceleration(at) / SCALE;
            *count = raw as i16;
        }
        Some(Self { counts, place: 0, awake: false })
    }
}

impl Board for SineBoard {
    fn acceleration(&mut self) -> Option<i16> {
        let count = self.counts.get(self.place).copied();
        self.place += 1;
        if self.place == PERIOD {
            self.place = 0;
        }
        count
    }

    fn storage_voltage(&mut self) -> Option<f32> {
        (!core::mem::replace(&mut self.awake, true)).then_some(VOLTAGE)
    }

    fn carry_out(&mut self, _decision: Decision) {}
}

/// Shows a workload whose samples are whole seconds. `second` takes the number of the second and the energy so far in J,
/// writes its words, and gives the steps.
fn each_second(
    visit: Visit<'_>,
    second: impl FnMut(u32, &mut f32, &mut [u32; 3]) -> Option<u32>,
) -> Option<()> {
    show(visit, Some(EachSecond { second, seconds: 0, energy: 0.0, bits: [0; 5] }))
}

/// A workload by seconds.
struct EachSecond<F> {
    second: F,
    seconds: u32,
    /// Energy so far in J.
    energy: f32,
    bits: [u32; 5],
}

impl<F: FnMut(u32, &mut f32, &mut [u32; 3]) -> Option<u32>> Workload for EachSecond<F> {
    fn name(&self) -> &'static str {
        "node"
    }

    fn advance(&mut self) -> Progress {
        if self.seconds == SECONDS {
            return Progress::Finished;
        }
        self.seconds += 1;
        let mut words = [0; 3];
        let Some(steps) = (self.second)(self.seconds, &mut self.energy, &mut words) else {
            return Progress::Failed;
        };
        let [one, two, three] = words;
        self.bits = [one, two, three, self.seconds, self.energy.to_bits()];
        Progress::Sample { steps, simulated_us: 1_000_000 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

//! A sensor node: acceleration samples in, mean harvested power out, once a second.
//!
//! What a developer replaces is [`Accelerometer`]: one method, which a driver's FIFO, a DMA buffer
//! or, here, a trace in flash can serve. The crate `accelerometer` has a trait for drivers, but of
//! three axes at once and on an old `micromath`, which brings vectors that nothing here needs.

mod trace;

use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::{AfterLastSample, Sampled};
use model_core::hybrid::{Driver, HybridState};
use model_core::integrate::{Adaptive, TrBdf2};
use model_core::scene::contact_separation::{ContactSeparation, Mode, STATES, Start};

use crate::workload::contact_separation::parts::{self, Whole};
use crate::workload::contact_separation::scenes::TOLERANCE;

pub use trace::FlashTrace;

/// Acceleration along the axis of the harvester, one sample after the other at a fixed rate.
pub trait Accelerometer {
    /// The next sample in m/s²; `None` where there are no more.
    fn sample(&mut self) -> Option<f32>;
}

/// Samples per second.
pub const RATE_HZ: u32 = 400;
/// Samples that are read at a time: a tenth of a second, as from a sensor's FIFO.
const BATCH: usize = 40;
const BATCHES_PER_SECOND: u64 = 10;
/// The batch that is stepped through and the one read for it share the ring.
const RING: usize = 2 * BATCH;

/// What the node knows after another second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Whole simulated seconds so far.
    pub second: u32,
    /// Mean power delivered to the load in the last of them, in watts.
    pub mean_power: f32,
    /// Steps that it took.
    pub steps: u32,
}

/// Why there is no report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodeError {
    /// The accelerometer has no more samples.
    NoSample,
    /// The harvester's parameters were refused, or it could not be stepped.
    Model,
}

/// A harvester that follows an accelerometer.
#[derive(Debug)]
pub struct Node<A> {
    accelerometer: A,
    scene: ContactSeparation<f32, Whole>,
    driver: Driver<TrBdf2, Adaptive<f32>>,
    state: HybridState<f32, Mode, STATES, 1>,
    /// Sample `n` stands in place `n % RING`: taken as a trace that repeats, the ring is a window
    /// that moves along the whole of the signal.
    ring: [f32; RING],
    /// Batches stepped through.
    batches: u32,
}

impl<A: Accelerometer> Node<A> {
    /// A node whose harvester is at rest when the first sample is taken.
    ///
    /// # Errors
    /// If the harvester's parameters are refused, or there is no sample.
    pub fn new(mut accelerometer: A) -> Result<Self, NodeError> {
        let scene = core::hint::black_box(parts::whole()).build().map_err(|_| NodeError::Model)?;
        let mut ring = [0.0; RING];
        ring[0] = accelerometer.sample().ok_or(NodeError::NoSample)?;
        let control = Adaptive::new(TOLERANCE);
        let excitation = window(&ring)?;
        let state = scene.start(&Start::default(), &excitation, &control).map_err(|_| NodeError::Model)?;
        Ok(Self { accelerometer, scene, driver: Driver::new(TrBdf2, control), state, ring, batches: 0 })
    }

    /// Follows the accelerometer for a second.
    ///
    /// # Errors
    /// If its samples end before the second does, or the harvester cannot be stepped.
    pub fn second(&mut self) -> Result<Report, NodeError> {
        let mut meter = PowerMeter::<f32, 1>::new();
        let mut steps = 0;
        for _ in 0..BATCHES_PER_SECOND {
            // The sample that ends this batch is the first of the next.
            let half = if self.batches.is_multiple_of(2) { 0 } else { BATCH };
            for place in half + 1..=half + BATCH {
                let sample = self.accelerometer.sample().ok_or(NodeError::NoSample)?;
                if let Some(slot) = self.ring.get_mut(if place == RING { 0 } else { place }) {
                    *slot = sample;
                }
            }
            self.batches += 1;
            let until = Instant::from_ticks((u64::from(self.batches) << 40) / BATCHES_PER_SECOND);
            let excitation = window(&self.ring)?;
            let advance = self
                .driver
                .advance(&self.scene, &mut self.state, &excitation, until, u32::MAX, &mut meter)
                .map_err(|_| NodeError::Model)?;
            steps += advance.work.steps;
        }
        let second = self.batches / BATCHES_PER_SECOND as u32;
        Ok(Report { second, mean_power: meter.mean_power(), steps })
    }
}

fn window(ring: &[f32; RING]) -> Result<Sampled<'_, f32>, NodeError> {
    Sampled::new(ring, RATE_HZ as f32, AfterLastSample::Repeat).map_err(|_| NodeError::Model)
}

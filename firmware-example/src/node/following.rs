//! The node that steps the harvester's model along the samples.

use model_core::energy::Estimator;
use model_core::energy::estimator::{EstimatorError, Model, SampleFormat, Settings};

use super::{Board, Economy, NodeError, RATE_HZ, Report, SCALE};

/// Attempted steps for a sample: some ten are usual, of which an impact takes a few.
const BUDGET: u32 = 200;

/// A node that follows its harvester.
#[derive(Debug, Clone, Copy)]
pub struct Following<B, M: Model<f32>> {
    board: B,
    estimator: Estimator<f32, M>,
    economy: Economy,
    seconds: u32,
}

impl<B: Board, M: Model<f32>> Following<B, M> {
    /// A node whose harvester is at rest when the first sample is taken.
    ///
    /// # Errors
    /// If a parameter is refused.
    pub fn new(mut board: B, model: M) -> Result<Self, NodeError> {
        let settings = Settings {
            rate: RATE_HZ as f32,
            format: SampleFormat::counts(SCALE, i16::MAX.unsigned_abs()),
            longest_gap: 4,
            settling_seconds: 0.0,
        };
        let estimator = Estimator::new(model, settings).map_err(|_| NodeError::Parameters)?;
        let mut economy = Economy::new()?;
        if let Some(volts) = board.store_voltage() {
            economy.read(volts);
        }
        let mut node = Self { board, estimator, economy, seconds: 0 };
        node.estimator.set_store_voltage(node.economy.store_voltage());
        Ok(node)
    }

    /// Follows the accelerometer for a second, and decides.
    ///
    /// # Errors
    /// If the harvester's model cannot start at rest.
    pub fn second(&mut self) -> Result<Report, NodeError> {
        let mut steps = 0;
        for _ in 0..RATE_HZ {
            let mut pushed = match self.board.acceleration() {
                Some(count) => self.estimator.push_count(count, BUDGET),
                None => self.estimator.push_missing(1, BUDGET),
            };
            loop {
                match pushed {
                    Ok(progress) => {
                        steps += progress.work.steps;
                        if progress.finished {
                            break;
                        }
                    }
                    // The estimator starts the harvester anew and counts the time as unknown.
                    Err(EstimatorError::Step(_)) => {}
                    Err(_) => return Err(NodeError::Model),
                }
                // Here a firmware may do something else.
                pushed = self.estimator.resume(BUDGET);
            }
        }
        let estimate = self.estimator.estimate();
        self.estimator.clear();
        if let Some(volts) = self.board.store_voltage() {
            self.economy.read(volts);
        }
        let harvested = estimate.energy;
        let decision = self.economy.second(harvested, harvested * estimate.uncertainty.relative);
        // What leaked and what is spent is gone from the harvester's store too.
        self.estimator.set_store_voltage(self.economy.store_voltage());
        self.board.carry_out(decision);
        self.seconds += 1;
        Ok(Report { second: self.seconds, harvested, stored: self.economy.stored(), decision, steps })
    }

    /// The budget of the node.
    #[must_use]
    pub fn economy(&self) -> &Economy {
        &self.economy
    }
}

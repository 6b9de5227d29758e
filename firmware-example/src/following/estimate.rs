//! The node that steps the harvester's model along the samples.

use model_core::energy::Estimator;
use model_core::energy::estimator::{EstimatorError, Interpolation, SampleFormat, Settings};
use model_core::scene::Harvester;
use model_core::snapshot::{self, Configuration, Fingerprint, Image, SnapshotError};

use super::{Board, NodeError, PowerManager, RATE_HZ, Report, SCALE};

/// Attempted steps for a sample: some ten are usual, of which an impact takes a few.
const BUDGET: u32 = 200;

/// How the estimator reads the accelerometer.
pub(crate) fn settings() -> Settings<f32> {
    Settings {
        rate: RATE_HZ as f32,
        format: SampleFormat::counts(SCALE, i16::MAX.unsigned_abs()),
        longest_gap: 4,
        settling_seconds: 0.0,
        // A timer of the node starts each sample.
        rate_tolerance: 0.0,
        jitter: 0.0,
        interpolation: Interpolation::DroopCompensated,
        bias_seconds: None,
    }
}

/// A node that follows its harvester.
#[derive(Debug, Clone, Copy)]
pub struct Following<B, H: Harvester<f32>> {
    board: B,
    estimator: Estimator<f32, H>,
    power_manager: PowerManager,
    seconds: u32,
}

impl<B: Board, H: Harvester<f32>> Following<B, H> {
    /// A node whose harvester is at rest when the first sample is taken.
    ///
    /// # Errors
    /// If a parameter is refused.
    pub fn new(mut board: B, harvester: H) -> Result<Self, NodeError> {
        let estimator = Estimator::new(harvester, settings()).map_err(|_| NodeError::Parameters)?;
        let mut power_manager = PowerManager::new()?;
        if let Some(voltage) = board.storage_voltage() {
            power_manager.read(voltage);
        }
        let mut node = Self { board, estimator, power_manager, seconds: 0 };
        node.estimator.set_storage_voltage(node.power_manager.storage_voltage());
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
        if let Some(voltage) = self.board.storage_voltage() {
            self.power_manager.read(voltage);
        }
        let harvested = estimate.energy;
        // Income of unknown uncertainty counts as no income.
        let uncertainty = harvested * estimate.uncertainty.relative.unwrap_or(1.0);
        let decision = self.power_manager.second(harvested, uncertainty);
        // What leaked and what is spent is gone from the harvester's storage too.
        self.estimator.set_storage_voltage(self.power_manager.storage_voltage());
        self.board.carry_out(decision);
        self.seconds += 1;
        Ok(Report { second: self.seconds, harvested, stored: self.power_manager.stored(), decision, steps })
    }

    /// The budget of the node.
    #[must_use]
    pub fn power_manager(&self) -> &PowerManager {
        &self.power_manager
    }

    /// The board, after power-down.
    #[must_use]
    pub fn into_board(self) -> B {
        self.board
    }

    /// Writes an image of all states with its number to the front of `slot`. Returns its size in bytes.
    ///
    /// # Errors
    /// If there is no room.
    pub fn save(&self, sequence: u32, slot: &mut [u8]) -> Result<usize, SnapshotError> {
        let states = (*self.estimator.state(), self.power_manager.state(), [self.seconds]);
        snapshot::save_image(&self.settings(), &states, sequence, slot)
    }

    /// Continues from the newest image of two slots, between two seconds. Returns the number and the slot of that image.
    ///
    /// # Errors
    /// If there is no image of this node; the node is then unchanged.
    pub fn resume(&mut self, slots: [&[u8]; 2]) -> Result<Image<()>, SnapshotError> {
        let Image { state: (estimator, power_manager, [seconds]), sequence, slot } =
            snapshot::newest_image(&self.settings(), slots)?;
        self.estimator.set_state(estimator);
        self.power_manager.set_state(power_manager);
        self.seconds = seconds;
        Ok(Image { state: (), sequence, slot })
    }

    fn settings(&self) -> (&Estimator<f32, H>, &PowerManager, Seconds) {
        (&self.estimator, &self.power_manager, Seconds)
    }
}

/// The counter of whole seconds, in an image beside the states of the node's parts.
struct Seconds;

impl Configuration for Seconds {
    type State = [u32; 1];

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("seconds");
    }
}

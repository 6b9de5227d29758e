//! The node that asks a closed form about the strongest sine of the samples.

use model_core::excitation::{ToneMeter, ToneMeterState};
use model_core::scalar::Polynomial;
use model_core::snapshot::{self, Image, SnapshotError};

use super::harvester::Beam;
use super::{Board, NodeError, PowerManager, RATE_HZ, Report, SCALE, Seconds};

/// Part of the signal's mean square that the line must have: with less the harvester hears something else.
const LEAST_PURITY: f32 = 0.5;
/// What a closed form is taken to be off by, relative.
const CLOSED_FORM_ERROR: f32 = 0.1;

/// A node that listens to the vibration and does not follow its harvester.
#[derive(Debug, Clone, Copy)]
pub struct Listening<B> {
    board: B,
    beam: Beam,
    meter: ToneMeter<f32>,
    tone: ToneMeterState<f32>,
    power_manager: PowerManager,
    seconds: u32,
}

impl<B: Board> Listening<B> {
    /// A node that has heard nothing yet.
    ///
    /// # Errors
    /// If a parameter is refused.
    pub fn new(mut board: B, beam: Beam) -> Result<Self, NodeError> {
        let meter = ToneMeter::new(RATE_HZ as f32, RATE_HZ).map_err(|_| NodeError::Parameters)?;
        let mut power_manager = PowerManager::new()?;
        if let Some(voltage) = board.storage_voltage() {
            power_manager.read(voltage);
        }
        Ok(Self { board, beam, tone: meter.start(), meter, power_manager, seconds: 0 })
    }

    /// Listens for a second, and decides. A line that the closed form does not hold for brings nothing.
    pub fn second(&mut self) -> Report {
        let mut line = None;
        for _ in 0..RATE_HZ {
            // A lost sample is not a number, and taken as the one before.
            let sample = self.board.acceleration().map_or(f32::NAN, |count| SCALE * f32::from(count));
            line = self.meter.push::<Polynomial>(&mut self.tone, sample).or(line);
        }
        let heard = line.filter(|line| line.purity >= LEAST_PURITY);
        let harvested = heard.map_or(0.0, |line| {
            self.beam.energy_in_a_second(line.amplitude, line.frequency, self.power_manager.storage_voltage())
        });
        if let Some(voltage) = self.board.storage_voltage() {
            self.power_manager.read(voltage);
        }
        let decision = self.power_manager.second(harvested, CLOSED_FORM_ERROR * harvested);
        self.board.carry_out(decision);
        self.seconds += 1;
        Report { second: self.seconds, harvested, stored: self.power_manager.stored(), decision, steps: 0 }
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
        let states = ((), self.tone, self.power_manager.state(), [self.seconds]);
        snapshot::save_image(&self.settings(), &states, sequence, slot)
    }

    /// Continues from the newest image of two slots, between two seconds. Returns the number and the slot of that image.
    ///
    /// # Errors
    /// If there is no image of this node; the node is then unchanged.
    pub fn resume(&mut self, slots: [&[u8]; 2]) -> Result<Image<()>, SnapshotError> {
        let Image { state: ((), tone, power_manager, [seconds]), sequence, slot } =
            snapshot::newest_image(&self.settings(), slots)?;
        self.tone = tone;
        self.power_manager.set_state(power_manager);
        self.seconds = seconds;
        Ok(Image { state: (), sequence, slot })
    }

    fn settings(&self) -> (&Beam, &ToneMeter<f32>, &PowerManager, Seconds) {
        (&self.beam, &self.meter, &self.power_manager, Seconds)
    }
}

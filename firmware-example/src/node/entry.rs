//! The log of the node: the same text by `defmt` on a microcontroller and by `Display` on the host. The checksum of
//! an image is that of each bit of the node's state.

use core::fmt;

use model_core::node::{IncomeOfTime, Tier};

use super::parts::{ACTIONS, ExampleNode, ExampleState};
use super::plant::Plant;

/// An entry of the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Entry {
    /// What the node knows.
    State(State),
    /// An hour is over.
    Hour(Hour),
    /// An image was written.
    Image {
        /// Its number.
        sequence: u32,
        /// Its size.
        bytes: u32,
        /// Its last four bytes: the CRC-32 of the others, and so of each bit of the state.
        checksum: u32,
    },
    /// The node has started from an image.
    Resumed {
        /// Losses of power so far.
        losses: u32,
        /// Number of the image.
        sequence: u32,
        /// Second of the day at which it was written.
        second: u32,
    },
}

/// What the node knows, and what it did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Second of the day.
    pub second: u32,
    /// The last code of the converter.
    pub code: u32,
    /// Stored energy and its bound in J.
    pub stored: [f32; 2],
    /// The income since midnight.
    pub estimated: IncomeOfTime,
    /// The true one in pJ.
    pub income: u64,
    /// Energy in J that was spent on estimation.
    pub estimation: f32,
    /// Readings of the voltage, and bursts.
    pub instruments: [u32; 2],
    /// Runs of each action.
    pub ran: [u32; ACTIONS],
}

/// The estimate of an hour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hour {
    /// Second of the day at its end.
    pub second: u32,
    /// What the node says.
    pub estimated: IncomeOfTime,
    /// The true income in pJ.
    pub income: u64,
}

impl State {
    pub(super) fn new(node: &ExampleNode, state: &ExampleState, plant: &Plant) -> Self {
        let status = node.status(state);
        Self {
            second: ExampleNode::second(state),
            code: plant.code,
            stored: [status.energy, status.energy_bound],
            estimated: node.overall(state),
            income: plant.income,
            estimation: node.spent_on_estimation(state),
            instruments: [state.voltage().readings(), state.bursts()],
            ran: plant.ran,
        }
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State(state) => {
                let State { second, code, income, .. } = state;
                let ([readings, bursts], [measured, transmitted]) = (state.instruments, state.ran);
                let IncomeOfTime { energy, bound, silent, .. } = state.estimated;
                let [stored, within, energy, bound, estimation] =
                    [state.stored[0], state.stored[1], energy, bound, state.estimation].map(picojoules);
                write!(
                    f,
                    "second {second}: code {code}, {stored} pJ stored, bound {within}, {energy} pJ in, \
                     bound {bound}, {silent} s silent, {income} pJ true, {estimation} pJ on estimation, \
                     {readings} readings, {bursts} bursts, {measured} measured, {transmitted} transmitted"
                )
            }
            Self::Hour(Hour { second, estimated, income }) => {
                let IncomeOfTime { seconds, energy, bound, silent } = estimated;
                let [energy, bound] = [*energy, *bound].map(picojoules);
                write!(
                    f,
                    "hour until {second}: {seconds} s, {energy} pJ in, bound {bound}, {silent} s silent, \
                     {income} pJ true"
                )
            }
            Self::Image { sequence, bytes, checksum } => {
                write!(f, "image {sequence}: {bytes} bytes, checksum {checksum}")
            }
            Self::Resumed { losses, sequence, second } => {
                write!(f, "power lost {losses} times, resumed from image {sequence} at second {second}")
            }
        }
    }
}

/// An energy in whole pJ: the decoder of the log and the host write some numbers with other last digits.
fn picojoules(joules: f32) -> u64 {
    (1e12 * joules) as u64
}

/// Writes an entry to the log.
#[cfg(target_os = "none")]
pub(super) fn log(entry: &Entry) {
    match entry {
        Entry::State(state) => {
            let State { second, code, income, .. } = state;
            let ([readings, bursts], [measured, transmitted]) = (state.instruments, state.ran);
            let IncomeOfTime { energy, bound, silent, .. } = state.estimated;
            let [stored, within, energy, bound, estimation] =
                [state.stored[0], state.stored[1], energy, bound, state.estimation].map(picojoules);
            defmt::info!(
                "second {=u32}: code {=u32}, {=u64} pJ stored, bound {=u64}, {=u64} pJ in, bound {=u64}, {=u32} s silent, {=u64} pJ true, {=u64} pJ on estimation, {=u32} readings, {=u32} bursts, {=u32} measured, {=u32} transmitted",
                second,
                code,
                stored,
                within,
                energy,
                bound,
                silent,
                income,
                estimation,
                readings,
                bursts,
                measured,
                transmitted
            );
        }
        Entry::Hour(Hour { second, estimated, income }) => {
            let IncomeOfTime { seconds, energy, bound, silent } = estimated;
            let [energy, bound] = [*energy, *bound].map(picojoules);
            defmt::info!(
                "hour until {=u32}: {=u32} s, {=u64} pJ in, bound {=u64}, {=u32} s silent, {=u64} pJ true",
                second,
                seconds,
                energy,
                bound,
                silent,
                income
            );
        }
        Entry::Image { sequence, bytes, checksum } => {
            defmt::info!("image {=u32}: {=u32} bytes, checksum {=u32}", sequence, bytes, checksum);
        }
        Entry::Resumed { losses, sequence, second } => {
            defmt::info!(
                "power lost {=u32} times, resumed from image {=u32} at second {=u32}",
                losses,
                sequence,
                second
            );
        }
    }
}

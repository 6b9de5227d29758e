//! A day of a harvester that is not as designed, as `host-bench on-target --day` writes it with the full model.

/// A minute of the day.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Minute {
    /// Amplitude in mm/s² and frequency in mHz of each of two sines that shake the harvester; without a second sine, and at
    /// rest, 0 and 0.
    pub lines: [[u16; 2]; 2],
    /// Harvested energy in nJ.
    pub energy: u32,
}

// `DAY: [Minute; 1440]`, by the build script from `trace/day.csv`.
include!(concat!(env!("OUT_DIR"), "/day.rs"));

/// Seconds of the day.
pub const SECONDS: u32 = 60 * DAY.len() as u32;

/// The minute with the given second of the day; at rest after its end.
pub(super) fn minute(second: u32) -> Minute {
    const REST: Minute = Minute { lines: [[0; 2]; 2], energy: 0 };
    DAY.get((second / 60) as usize).copied().unwrap_or(REST)
}

/// Energy in pJ that is harvested in all of the day.
#[must_use]
pub fn income() -> u64 {
    DAY.iter().map(|minute| 1000 * u64::from(minute.energy)).sum()
}

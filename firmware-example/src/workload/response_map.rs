//! The cost of estimating an income without a trajectory: a look-up in a response map, and the lines of a resonance's band.
//!
//! A step in the log is a look-up, or a sample.

use core::hint::black_box;

use model_core::energy::ResponseMap;
use model_core::excitation::{LineBank, LineBankState};

use super::{Progress, Visit, Workload};

/// The map of the contact-separation scene, as `host-bench map` writes it.
#[path = "../../map/contact_separation.rs"]
pub mod contact_separation;

/// Samples of a section and sections of a block.
const SECTION: usize = 80;
const SECTIONS: usize = 16;
/// m/s² of a count: a range of 4 g in 16 bits.
const UNIT: f32 = model_core::part::GRAVITY as f32 / 8192.0;
/// Samples that the FIFO hands over at once: eight periods.
const BURST: usize = 160;
/// Blocks that are logged.
const BLOCKS: u32 = 2;
/// Look-ups in an entry of the log.
const CALLS: u32 = 64;

/// The look-up and the bank.
pub fn all(visit: Visit<'_>) -> Option<()> {
    let map =
        ResponseMap::new(black_box(&contact_separation::MAP[..]), contact_separation::FINGERPRINT).ok()?;
    visit(&mut LookUp::new("look-up, one motion", map, [0.2, 19.7]));
    visit(&mut LookUp::new("look-up, two motions", map, TWO_MOTIONS));
    let bank = LineBank::new(black_box(400.0), 20.13, 0.1, UNIT).ok()?;
    visit(&mut BurstBench::new(bank));
    Some(())
}

/// Amplitude in m/s² and frequency in Hz of a place with two motions in the map.
const TWO_MOTIONS: [f32; 2] = [1.2, 20.6];

struct LookUp {
    name: &'static str,
    map: ResponseMap<&'static [u16]>,
    place: [f32; 2],
    entries: u32,
    bits: [u32; 3],
}

impl LookUp {
    fn new(name: &'static str, map: ResponseMap<&'static [u16]>, place: [f32; 2]) -> Self {
        Self { name, map, place, entries: 0, bits: [0; 3] }
    }
}

impl Workload for LookUp {
    fn name(&self) -> &'static str {
        self.name
    }

    fn advance(&mut self) -> Progress {
        if self.entries == 2 {
            return Progress::Finished;
        }
        self.entries = self.entries.wrapping_add(1);
        for _ in 0..CALLS {
            let [amplitude, frequency] = black_box(self.place);
            let Some(income) = self.map.at(amplitude, frequency).income() else { return Progress::Failed };
            self.bits = [income.value, income.low, income.high].map(f32::to_bits);
        }
        Progress::Sample { steps: CALLS, simulated_us: CALLS * 1_000_000 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

struct BurstBench {
    bank: LineBank<SECTION, SECTIONS>,
    state: LineBankState<SECTIONS>,
    blocks: u32,
    burst: [i16; BURST],
    bits: [u32; 3],
}

impl BurstBench {
    /// With a square wave of 20 Hz on gravity, with noise: the cost hardly depends on the values.
    fn new(bank: LineBank<SECTION, SECTIONS>) -> Self {
        let (mut burst, mut seed) = ([0; BURST], 1_u32);
        for (n, sample) in (0..BURST).zip(&mut burst) {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *sample = 8192 + (seed >> 26) as i16 + if n % 20 < 10 { 1600 } else { -1600 };
        }
        Self { state: bank.start(), bank, blocks: 0, burst, bits: [0; 3] }
    }
}

impl Workload for BurstBench {
    fn name(&self) -> &'static str {
        "lines of the band"
    }

    fn advance(&mut self) -> Progress {
        if self.blocks == BLOCKS {
            return Progress::Finished;
        }
        self.blocks = self.blocks.wrapping_add(1);
        let burst = black_box(&self.burst);
        let samples = self.bank.block() as u32;
        let mut left = samples;
        while left > 0 {
            let count = (left as usize).min(burst.len());
            let Some(part) = burst.get(..count) else { return Progress::Failed };
            let (taken, lines) = self.bank.take(&mut self.state, part);
            if let Some(lines) = lines {
                self.bits = [lines.amplitude, lines.frequency, lines.density].map(f32::to_bits);
            }
            left = left.wrapping_sub(taken as u32);
        }
        Progress::Sample { steps: samples, simulated_us: samples.wrapping_mul(2500) }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

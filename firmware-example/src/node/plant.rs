//! The true node: what its storage holds, what its converter reads, what its accelerometer samples.
//!
//! All of it is integer arithmetic but for one root, so that it costs little on a core without floating point. Energies are
//! whole pJ.

use model_core::node::MapParameters;
use model_core::scalar::Scalar;

use super::parts::{
    ACTIONS, BITS, CAPACITANCE, ExampleNode, FIRST, FULL_SCALE, HIGHEST, INTO_STORAGE, LEAKAGE, LOCK_OUT,
    OUT_OF_STORAGE, RATE,
};

/// What the true node draws, in per cent of what is stated: asleep, for an action, for a reading or a burst.
const STANDING: u64 = 115;
const ACTION: u64 = 101;
const NODE_COST: u64 = 104;
/// Time in s in which the leakage takes the stored energy: half of resistance times capacitance.
const LEAKING: u64 = (0.5 * LEAKAGE * CAPACITANCE) as u64;
/// Root mean square of the noise in 1/1024 codes of the converter, and in 1/256 counts of the accelerometer.
const CODE_NOISE: i32 = 500;
const COUNT_NOISE: i32 = 4 * 256;
/// Counts of gravity, which is on the axis.
const GRAVITY: i32 = 1000;

/// What an activity takes from the storage, in pJ.
#[derive(Debug, Clone, Copy)]
pub struct Draws {
    /// In a second.
    standing: u64,
    reading: u64,
    burst: u64,
    actions: [u64; ACTIONS],
}

impl Draws {
    /// Those of the true node with the parts of this one.
    #[must_use]
    pub fn new(node: &ExampleNode) -> Self {
        let MapParameters { voltage, bursts, .. } = node.parameters();
        let of = |joule: f32, part: u64| part.wrapping_mul((1e12 * joule) as u64) / u64::from(OUT_OF_STORAGE);
        Self {
            standing: of(voltage.standing_power, STANDING),
            reading: of(voltage.reading, NODE_COST),
            burst: of(bursts.energy, NODE_COST),
            actions: voltage.actions.map(|regular| of(regular.energy, ACTION)),
        }
    }
}

/// Stored energy in pJ at a voltage.
fn energy_at(voltage: f32) -> u64 {
    (0.5e12 * CAPACITANCE * voltage * voltage) as u64
}

/// The true node at a moment of the day.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plant {
    /// Second of the day.
    pub second: u32,
    /// Stored energy in pJ.
    pub stored: u64,
    /// Harvested energy since midnight in pJ.
    pub income: u64,
    /// Harvested energy in pJ until the end of the last hour that the node reported.
    pub(super) reported: u64,
    /// Harvested energy in pJ that the storage, being full, did not take.
    pub shunted: u64,
    /// The last code of the converter.
    pub code: u32,
    /// How often each action ran.
    pub ran: [u32; ACTIONS],
    random: u32,
    sensor: Option<Sensor>,
}

/// The accelerometer when it is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Sensor {
    /// Second at which it was switched on.
    started: u32,
    /// Samples that were taken, and that are in the FIFO.
    taken: u32,
    waiting: u32,
    /// Phases of both sines in 2⁻³² turns.
    phases: [u32; 2],
}

impl Plant {
    #[must_use]
    pub fn at_midnight() -> Self {
        Self {
            second: 0,
            stored: energy_at(FIRST),
            income: 0,
            reported: 0,
            shunted: 0,
            code: 0,
            ran: [0; ACTIONS],
            random: 0x2545_f491,
            sensor: None,
        }
    }

    /// Whether the storage has fallen to the voltage of the lock-out.
    pub(super) fn is_locked_out(&self) -> bool {
        self.stored <= energy_at(LOCK_OUT)
    }

    /// Lets time pass up to a second of the day.
    pub fn advance(&mut self, draws: &Draws, until: u32) {
        while self.second < until {
            let within = self.second % 60;
            let seconds = (until - self.second).min(60 - within);
            let energy = u64::from(minute(self.second).energy);
            let harvested = |second: u32| energy.wrapping_mul(50 * u64::from(second)) / 3;
            let income = harvested(within.wrapping_add(seconds)).wrapping_sub(harvested(within));
            let lost = (self.stored / LEAKING).wrapping_add(draws.standing).wrapping_mul(seconds.into());
            let into = u64::from(INTO_STORAGE);
            let stored = self.stored.wrapping_add(income.wrapping_mul(into) / 100).saturating_sub(lost);
            self.stored = stored.min(energy_at(HIGHEST));
            self.shunted = self.shunted.wrapping_add(stored.abs_diff(self.stored).wrapping_mul(100) / into);
            self.income = self.income.wrapping_add(income);
            self.second = self.second.wrapping_add(seconds);
        }
    }

    fn draw(&mut self, energy: u64) {
        self.stored = self.stored.saturating_sub(energy);
    }

    /// Draws what so many readings took.
    pub fn know(&mut self, draws: &Draws, readings: u32) {
        self.draw(draws.reading.wrapping_mul(readings.into()));
    }

    /// Reads the voltage of the storage.
    pub fn read(&mut self) -> u32 {
        const CODES: u32 = 1 << BITS;
        let volts = Scalar::sqrt(2e-12 / CAPACITANCE * self.stored as f32);
        let code = self.noise(CODE_NOISE).wrapping_add((volts * (1024.0 * CODES as f32 / FULL_SCALE)) as i32);
        self.code = (code.wrapping_add(512) >> 10).clamp(0, CODES as i32 - 1) as u32;
        self.code
    }

    /// Carries an action out.
    pub fn run(&mut self, draws: &Draws, action: usize) {
        if let (Some(energy), Some(ran)) = (draws.actions.get(action), self.ran.get_mut(action)) {
            *ran = ran.wrapping_add(1);
            self.draw(*energy);
        }
    }

    /// Switches the accelerometer on.
    pub fn start_sensor(&mut self, draws: &Draws) {
        self.draw(draws.burst);
        let phases = [self.random(), self.random()];
        self.sensor = Some(Sensor { started: self.second, taken: 0, waiting: 0, phases });
    }

    /// Switches it off.
    pub fn stop_sensor(&mut self) {
        self.sensor = None;
    }

    /// Fills the FIFO with so many samples; the second at which they are there.
    pub fn fill(&mut self, samples: u32) -> u32 {
        let Some(sensor) = &mut self.sensor else { return self.second };
        sensor.waiting = sensor.waiting.wrapping_add(samples);
        sensor.started.wrapping_add(sensor.taken.wrapping_add(sensor.waiting).div_ceil(RATE))
    }

    /// Moves samples out of the FIFO; their number.
    pub fn take(&mut self, samples: &mut [i16]) -> usize {
        let Some(mut sensor) = self.sensor else { return 0 };
        let count = samples.len().min(sensor.waiting as usize);
        for sample in samples.iter_mut().take(count) {
            let [one, other] = minute(sensor.started.wrapping_add(sensor.taken / RATE)).lines;
            let [one_phase, other_phase] = &mut sensor.phases;
            let value = shaken(one, one_phase) + shaken(other, other_phase);
            *sample = ((value + 256 * GRAVITY + self.noise(COUNT_NOISE) + 128) >> 8) as i16;
            sensor.taken = sensor.taken.wrapping_add(1);
        }
        self.sensor = Some(Sensor { waiting: sensor.waiting.wrapping_sub(count as u32), ..sensor });
        count
    }

    /// A random number by the shifts of Marsaglia.
    fn random(&mut self) -> u32 {
        let mut random = self.random;
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        self.random = random;
        random
    }

    /// Noise of a root mean square, up to 2000, as the sum of four even numbers.
    fn noise(&mut self, deviation: i32) -> i32 {
        // Each of them has the variance (256² - 1)/12, their sum that of 147.8².
        let add = |sum: i32, byte: u8| sum.wrapping_add(byte.into());
        self.random().to_le_bytes().into_iter().fold(-510, add).wrapping_mul(deviation) / 148
    }
}

/// Acceleration in 1/256 counts of a sine of an amplitude up to 4.9 m/s² at a phase, which goes on to the next sample.
fn shaken([amplitude, frequency]: [u16; 2], phase: &mut u32) -> i32 {
    // 2³² turns over 1000 mHz in a Hz and the samples in a second.
    const TURN: u64 = (1 << 32) * (1 << 8) / (1000 * RATE as u64);
    *phase = phase.wrapping_add(((u64::from(frequency) * TURN) >> 8) as u32);
    // A count is 9.80665 mm/s².
    let amplitude = i32::from(amplitude.min(4900)) * 26_105 / 1000;
    amplitude.wrapping_mul(sine(*phase)) >> 14
}

/// Steps of the table of a quarter of a sine, and their bits.
const STEPS: usize = 1 << STEP_BITS;
const STEP_BITS: u32 = 6;
const QUARTER: [i16; STEPS + 1] = quarter();

/// A quarter of a sine of 2¹⁴, by its series.
const fn quarter() -> [i16; STEPS + 1] {
    let mut table = [0; STEPS + 1];
    let mut place = 0;
    while place <= STEPS {
        let angle = core::f64::consts::FRAC_PI_2 * place as f64 / STEPS as f64;
        let (mut term, mut sum, mut order) = (angle, 0.0, 1.0);
        while order < 20.0 {
            sum += term;
            term *= -angle * angle / ((order + 1.0) * (order + 2.0));
            order += 2.0;
        }
        table[place] = (16_384.0 * sum + 0.5) as i16;
        place += 1;
    }
    table
}

/// A sine of 2¹⁴ at a phase in 2⁻³² turns, off by up to 3.
fn sine(phase: u32) -> i32 {
    let within = if phase & 1 << 30 == 0 { phase << 2 } else { !(phase << 2) };
    let place = (within >> (32 - STEP_BITS)) as usize;
    let part = (within >> (16 - STEP_BITS) & 0xffff) as i32;
    let at = |place: usize| QUARTER.get(place).copied().map_or(0, i32::from);
    let value = at(place).wrapping_add(at(place + 1).wrapping_sub(at(place)).wrapping_mul(part) >> 16);
    if phase & 1 << 31 == 0 { value } else { -value }
}

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

#[cfg(test)]
mod tests {
    use super::{Plant, RATE, energy_at, shaken, sine};

    #[test]
    fn the_table_of_a_sine_holds_its_error() {
        for step in 0..4096_u32 {
            let phase = step.wrapping_mul(0x0010_0321);
            let exact = 16_384.0 * (core::f64::consts::TAU * f64::from(phase) / 4_294_967_296.0).sin();
            assert!((f64::from(sine(phase)) - exact).abs() < 3.0, "{phase:#x}");
        }
    }

    #[test]
    fn a_line_has_its_amplitude_and_its_frequency() {
        // 2 m/s² at 20.5 Hz: 203.94 counts, and 205 turns in ten seconds.
        let (mut phase, mut turns, mut before, mut squares) = (0, 0, 0, 0.0);
        for _ in 0..10 * RATE {
            let value = f64::from(shaken([2000, 20_500], &mut phase)) / 256.0;
            squares += value * value;
            turns += u32::from(phase < before);
            before = phase;
        }
        let amplitude = (2.0 * squares / f64::from(10 * RATE)).sqrt();
        assert!((amplitude - 2000.0 / 9.806_65).abs() < 0.1, "{amplitude}");
        assert!((204..=205).contains(&turns), "{turns}");
    }

    #[test]
    fn noise_has_its_deviation() {
        let mut plant = Plant::at_midnight();
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..20_000 {
            let value = f64::from(plant.noise(1000));
            (sum, squares) = (sum + value, squares + value * value);
        }
        let mean = sum / 20_000.0;
        let deviation = (squares / 20_000.0).sqrt();
        assert!(mean.abs() < 30.0 && (deviation / 1000.0 - 1.0).abs() < 0.03, "{mean} {deviation}");
    }

    #[test]
    fn the_books_of_the_plant_close() {
        use super::super::parts::Part;
        let draws = super::Draws::new(Part::Nrf52832.node());
        let whole = {
            let mut plant = Plant::at_midnight();
            plant.advance(&draws, 86_400);
            plant
        };
        // In steps of other lengths the same comes in; only the leakage depends on when the energy is there.
        let mut plant = Plant::at_midnight();
        while plant.second < 86_400 {
            plant.advance(&draws, (plant.second + 37).min(86_400));
        }
        assert_eq!((plant.income, plant.second), (whole.income, 86_400));
        assert_eq!(plant.income, super::income());
        let off = plant.stored.abs_diff(whole.stored);
        assert!(off < energy_at(4.5) / 10_000, "{off}");
    }
}

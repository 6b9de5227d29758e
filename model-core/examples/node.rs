//! A node by the voltage of its storage, and by bursts of samples while that is full. Its harvester gives 0.8 of what the map says.
use model_core::node::*;

/// Charge per second into a storage of 1.8 to 4.6 V. Its head has the command that made it.
#[path = "node/map.rs"]
#[allow(unreachable_pub, reason = "a module that `map` wrote")]
pub(crate) mod map;

const RATE: u32 = 100; // samples of the accelerometer in a second
const UNIT: f32 = 9.806_65e-3; // m/s² of a count
/// In flash: what does not fit does not compile. A burst has 16 sections of at most 20 samples, 3.2 s: bins to 1.25 Hz beside the resonance.
pub(crate) static NODE: FlashMapNode<1> = {
    let bank = LineBank::new(RATE as f32, map::RESONANCE_HZ, map::HALF_BANDWIDTH_HZ, UNIT);
    let Ok(bank) = bank else { panic!("the bank of lines") };
    let Ok(node) = MapNode::new(MAP, bank, PARAMETERS) else { panic!("the parameters") };
    node
};
const MAP: ResponseMap<&[u16]> = match ResponseMap::of_words(&map::MAP, map::FINGERPRINT) {
    Ok(map) => map,
    Err(_) => panic!("the map"),
};
const BURST: f32 = 30e-6; // J of a burst at the load: docs/node.md, "Cost"
const READING: f32 = 0.6e-6; // J of a reading
const PARAMETERS: MapParameters<1> = MapParameters {
    voltage: VoltageParameters {
        storage: StorageParameters {
            capacitor: Capacitor { capacitance: 10e-3, leakage_resistance: 100e6 }, // F, Ω: data sheet
            charging_efficiency: 1.0, // the map has what comes into the storage; else that of the matched converter
            discharging_efficiency: 1.0, // of the converter between storage and node
            highest_voltage: 4.5,     // V: from there on the protection shunts
            lock_out_voltage: 1.9,    // V: the supervisor switches the node off, and on again at
            turn_on_voltage: 2.2,     // V
        },
        converter: Converter { bits: 12, full_scale: 5.0, noise: 0.6e-3 }, // V with the divider; V, measure it
        standing_power: 1e-6, // W at the load, everything asleep: measure it
        reading: READING,     // J
        intervals: [60, 300], // s between readings: the longest, and where the storage fills up sooner
        tolerances: Tolerances { standing: 0.05, capacitance: 0.02, ..Tolerances::EXACT }, // both were measured
        largest_power: 100e-6, // W: no harvester of this kind gives more
        reserve: 50e-3,        // J that actions leave: standing power times the longest rest, and leakage
        actions: [Regular { energy: 200e-6, every: 60 }], // J at the load, s
    },
    sensor: Sensor {
        rate: RATE as f32,
        start_up: 7,   // samples
        blocks: 1,     // more for broadband vibration: its error is 0.85 over the root of this number
        clipped: 2040, // counts of the end of its range, 12 bits
    },
    bursts: Bursts {
        energy: BURST,
        worth: 10.0,   // J by which the bound of an hour narrows for each J of a burst
        shortest: 60,  // s between bursts
        check: 80_000, // s between bursts where the voltage suffices: no part of a day
    },
    gain: 0.5,        // a harvester off its map by a factor of 1.5 or so; 1 if it was never measured
    gain_drift: 0.02, // in an hour, by temperature
};

struct Bench {
    second: u32,
    stored: f64,
    harvested: f64,
    burst: [u32; 2], // second of its start, and samples since
}

impl Bench {
    fn voltage(&self) -> f64 {
        (200.0 * self.stored).sqrt()
    }
    /// Amplitude in m/s² of a machine that runs from 6 to 20 o'clock, at 20.5 Hz.
    fn amplitude(&self) -> f32 {
        let load = if self.second % 7200 < 3000 { 2.5 } else { 3.0 };
        if (6..20).contains(&(self.second / 3600 % 24)) { load } else { 0.0 }
    }
}

impl Board for Bench {
    fn sleep(&mut self, seconds: u32, samples: u32) -> u32 {
        for _ in 0..if samples > 0 { samples.div_ceil(RATE).min(seconds) } else { seconds } {
            let current = MAP.at_voltage(self.amplitude(), 20.5, self.voltage() as f32).income();
            let power = 0.8 * self.voltage() * current.map_or(0.0, |current| f64::from(current.value));
            self.harvested += power;
            self.stored = (self.stored + power - 1e-6 - self.voltage().powi(2) / 100e6).min(0.10125);
            self.second += 1;
        }
        self.second
    }
    fn storage_code(&mut self) -> Option<u32> {
        self.stored -= f64::from(READING);
        Some((self.voltage() / 5.0 * 4096.0).round() as u32)
    }
    fn start_sensor(&mut self) -> Result<(), Fault> {
        self.stored -= f64::from(BURST);
        self.burst = [self.second, 0];
        Ok(())
    }
    fn read_samples(&mut self, samples: &mut [i16]) -> Result<usize, Fault> {
        let (amplitude, [started, taken]) = (self.amplitude(), &mut self.burst);
        let count = samples.len().min(((self.second - *started) * RATE - *taken) as usize);
        for sample in samples.iter_mut().take(count) {
            let phase = core::f32::consts::TAU * 0.205 * *taken as f32;
            *sample = ((9.81 + amplitude * phase.sin()) / UNIT).round() as i16;
            *taken += 1;
        }
        Ok(count)
    }
    fn run(&mut self, _: usize) {
        self.stored -= 200e-6;
    }
    fn read_slot(&mut self, _: usize, _: &mut [u8]) {}
    fn write_slot(&mut self, _: usize, _: &[u8]) -> Result<(), Fault> {
        Err(Fault) // without memory, images fail
    }
}

fn main() {
    let bench = Bench { second: 0, stored: 80e-3, harvested: 0.0, burst: [0; 2] };
    let (mut runner, mut hour) = (Runner::new(bench, &NODE, 0), None);
    while runner.board().second <= 86_400 {
        if runner.step() == Step::Slept && runner.state().last_hour() != hour {
            hour = runner.state().last_hour();
            println!("{:5} s: {hour:?}, gain {:?}", runner.board().second, runner.state().gain());
        }
    }
    println!("{:?} of true {}", NODE.overall(runner.state()), runner.board().harvested);
}

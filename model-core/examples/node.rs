//! A sensor node that estimates its harvested power at a cost of about 1 % of it: an STM32L051 with an ADXL362, a storage of
//! 47 mF straight behind a full bridge, a measurement and a transmission as often as each ten minutes.
//!
//! `cargo run --example node`
//!
//! The board is made up: its storage is integrated with the power of a harvester that yields 0.8 of what the map says. Replace
//! [`Bench`] by your hardware, `map` by your map, and the numbers of [`parameters`] by those of your parts.

use model_core::energy::cost::{Accelerometer, Code, CostModel, Processor, node_instructions};
use model_core::energy::{
    BudgetParameters, Capacitor, IncomeParameters, ListeningParameters, ResponseMap, StorageParameters,
};
use model_core::excitation::LineBank;
use model_core::node::{
    Board, Converter, Fault, Gap, KnowingCost, Node, NodeParameters, Regular, Runner, Sensor, Spread, Step,
};

/// The map: charge per second into a storage of 1.8 to 4.6 V. Its head has the command that made it.
#[allow(unreachable_pub, reason = "a module that `map` wrote")]
#[path = "node/map.rs"]
pub(crate) mod map;

/// Samples of the accelerometer in a second, and m/s² of a count.
const RATE: u32 = 100;
const UNIT: f32 = 9.806_65e-3;
/// Most samples of a section (`M`), sections of a block (`P`): sections of 5 Hz, 1.25 Hz to each side of the resonance, 3.2 s.
const SECTION: usize = 20;
const SECTIONS: usize = 16;
/// Slots in which the node learns the income of a day, and actions.
const SLOTS: usize = 24;
const ACTIONS: usize = 2;

type ThisNode = Node<&'static [u16], SECTION, SECTIONS, SLOTS, ACTIONS>;
type ThisRunner<'a> = Runner<'a, Bench, ThisNode>;

/// Capacitance of the storage in F, its leakage in Ω, and the part of what it gives that reaches the load (the DC/DC converter).
const CAPACITANCE: f32 = 47e-3;
const LEAKAGE: f32 = 4e6;
const OUT_OF_STORAGE: f32 = 0.9;
/// Voltage in V below which the node is off.
const LOCK_OUT: f32 = 1.9;
/// Energies of the actions in J at the load.
const MEASURE: f32 = 300e-6;
const TRANSMIT: f32 = 5e-3;
/// The ADC that reads the storage: bits, and the voltage of its full scale by the divider in front of it.
const BITS: u32 = 12;
const FULL_SCALE: f32 = 5.0;

/// The parameters, the energy of a glance in J, and the standing power in W.
fn parameters() -> Result<(NodeParameters<ACTIONS>, f32), Box<dyn std::error::Error>> {
    // Energies of the parts by their data sheets; instructions by `on-target --node` (docs/node.md, "Cost").
    let cost = CostModel::<f32>::new(Processor::stm32l051(), Accelerometer::adxl362());
    let of_code = |instructions: f32| {
        cost.voltage_reading.value
            + cost.start_energy()
            + cost.processor.computing(instructions, Code::Filter)
    };
    let of = node_instructions(cost.processor.core);
    let (reading, glance) = (of_code(of.reading), of_code(of.glance));
    let samples = (SECTION * SECTIONS) as u32;
    let listen = cost
        .listen(samples, RATE as f32, samples as f32 * of.sample + of.block, Code::Filter)
        .ok_or("the sensor has no such rate")?;
    // What the node draws with everything asleep: processor with its clock, sensor, and nothing else here.
    let standing_power = cost.standing_power().ok_or("no figure asleep")?;
    let parameters = NodeParameters {
        budget: BudgetParameters {
            storage: StorageParameters {
                // F and Ω: data sheet of the storage. Every income is as wrong as the capacitance: measure it.
                capacitor: Capacitor { capacitance: CAPACITANCE, leakage_resistance: LEAKAGE },
                // The map tells what comes into the storage. With a map of a resistor: efficiency of the matched converter.
                charging_efficiency: 1.0,
                // Of the DC/DC converter between storage and node: data sheet, at the sleeping current.
                discharging_efficiency: OUT_OF_STORAGE,
                // V at which the protection shunts what comes in; V of the under-voltage lock-out, and of its release.
                highest_voltage: 4.5,
                lock_out_voltage: LOCK_OUT,
                turn_on_voltage: 2.2,
            },
            // s over which the mean income is taken, and weight of the newest day in a slot.
            income: IncomeParameters { time_constant: 4.0 * 3600.0, day_weight: 0.5 },
            standing_power, // W at the load
        },
        converter: Converter {
            bits: BITS,
            full_scale: FULL_SCALE, // V
            noise: 0.6e-3,          // V, one standard deviation of a reading: measure it
        },
        listening: ListeningParameters {
            share: 0.006,    // of the income, for listens
            error: 0.02,     // of the income of `horizon`, to aim at within that share
            horizon: 3600.0, // s
            shortest: 300,   // s between listens
            doublings: 6,    // up to 300 · 2⁶ s, 5.3 hours
        },
        sensor: Sensor {
            rate: RATE as f32,
            start_up: Accelerometer::<f32>::adxl362().start_up_samples,
            blocks: 1, // more for broadband shaking: its error is a half over the root of this number
            clipped: 2040, // counts of the end of its range, 12 bits
        },
        cost: KnowingCost {
            listen: listen.total(), // J, all three at the load
            reading,
            reading_share: 0.004, // of the income, for readings and glances
            shortest_reading: 60, // s
            reading_doublings: 6, // up to 60 · 2⁶ s, 64 minutes
        },
        spread: Spread {
            gain: 0.5,          // a harvester off its map by a factor of 1.5 or so; 1.0 if it was never measured
            gain_drift: 0.02,   // change of that factor in an hour, by temperature
            standing: 0.05,     // the standing power was measured to 5 %; 0.2 by data sheets
            action: 0.02,       // the energy of an action to 2 %
            income: 0.5,        // the income changes by a half of its mean in an hour, until listens show it
            gain_by_place: 0.2, // the factor of the map changes by 20 % where the yield is e times another one
            highest_voltage: 0.03, // 4.5 V to 3 %, the ADC's reference included
            power: 100e-6,      // W, the largest power of such a harvester
        },
        reserve: reserve(12.0 * 3600.0, standing_power), // J for a night, and two hours more
        // The most important first: energy in J, and s from one to the next.
        actions: [Regular { energy: MEASURE, every: 600 }, Regular { energy: TRANSMIT, every: 600 }],
    };
    Ok((parameters, glance))
}

/// Energy in J at the load, above the lock-out, that draw and leakage leave at the lock-out after so many seconds: the storage with
/// the time constant R·C/2 relaxes towards what the draw over that time would have it lack.
fn reserve(seconds: f32, standing_power: f32) -> f32 {
    let constant = 0.5 * LEAKAGE * CAPACITANCE;
    let at_lock_out = 0.5 * CAPACITANCE * LOCK_OUT * LOCK_OUT;
    (OUT_OF_STORAGE * at_lock_out + standing_power * constant) * (seconds / constant).exp_m1()
}

fn node() -> Result<ThisNode, Box<dyn std::error::Error>> {
    let (parameters, glance) = parameters()?;
    let map = ResponseMap::new(&map::MAP[..], map::FINGERPRINT)?;
    let bank = LineBank::new(RATE as f32, map::RESONANCE_HZ, map::HALF_BANDWIDTH_HZ, UNIT)?;
    // Without floating point in hardware most of a reading is computing: glances pay.
    Ok(Node::new(map, bank, parameters)?.with_glances(glance)?)
}

/// A made-up board: clock, storage, machine, accelerometer, two slots of memory.
struct Bench {
    map: ResponseMap<&'static [u16]>,
    standing_power: f64,
    /// Since midnight in s.
    second: u32,
    /// Stored and harvested energy in J.
    stored: f64,
    harvested: f64,
    /// Second at which the sensor was started, and samples taken since.
    started: Option<u32>,
    taken: u32,
    ran: [u32; ACTIONS],
    slots: [[u8; 1024]; 2],
}

impl Bench {
    fn voltage(&self) -> f64 {
        (2.0 * self.stored / f64::from(CAPACITANCE)).sqrt()
    }

    /// Amplitude in m/s² and frequency in Hz of the machine: from 6 to 20 o'clock, stronger in the afternoon.
    fn shaking(&self) -> [f32; 2] {
        match self.second / 3600 % 24 {
            6..13 => [2.5, 20.5],
            13..20 => [3.0, 20.5],
            _ => [0.0, 20.5],
        }
    }

    /// True harvested power in W.
    fn power(&self) -> f64 {
        let ([amplitude, frequency], voltage) = (self.shaking(), self.voltage());
        let current = self.map.at_voltage(amplitude, frequency, voltage as f32).income();
        0.8 * voltage * current.map_or(0.0, |current| f64::from(current.value))
    }

    /// Takes energy in J at the load.
    fn draw(&mut self, energy: f64) {
        self.stored = (self.stored - energy / f64::from(OUT_OF_STORAGE)).max(0.0);
    }

    fn live(&mut self, seconds: u32) {
        for _ in 0..seconds {
            let power = self.power();
            self.harvested += power;
            self.stored += power - self.voltage().powi(2) / f64::from(LEAKAGE);
            // The true draw is 4 % above the stated one.
            self.draw(1.04 * self.standing_power);
            let full = 0.5 * f64::from(CAPACITANCE) * 4.5 * 4.5;
            self.stored = self.stored.min(full);
            self.second += 1;
        }
    }
}

impl Board for Bench {
    fn sleep(&mut self, seconds: u32, samples: u32) -> u32 {
        // With the sensor on: until its FIFO has so many samples.
        let seconds = if samples > 0 { samples.div_ceil(RATE).min(seconds) } else { seconds };
        self.live(seconds);
        self.second
    }

    fn storage_code(&mut self) -> Option<u32> {
        let code = self.voltage() / f64::from(FULL_SCALE) * f64::from(1_u32 << BITS);
        Some(code.round() as u32)
    }

    fn start_sensor(&mut self) -> Result<(), Fault> {
        (self.started, self.taken) = (Some(self.second), 0);
        Ok(())
    }

    fn stop_sensor(&mut self) {
        self.started = None;
    }

    fn read_samples(&mut self, samples: &mut [i16]) -> Result<usize, Fault> {
        let started = self.started.ok_or(Fault)?;
        let ready = (self.second - started) * RATE - self.taken;
        let count = samples.len().min(ready as usize);
        let [amplitude, frequency] = self.shaking().map(f64::from);
        for sample in samples.iter_mut().take(count) {
            let phase = core::f64::consts::TAU * frequency * f64::from(self.taken) / f64::from(RATE);
            // Gravity is on the axis; the bank does not hear it.
            *sample = ((9.81 + amplitude * phase.sin()) / f64::from(UNIT)).round() as i16;
            self.taken += 1;
        }
        Ok(count)
    }

    fn run(&mut self, action: usize) {
        self.draw(f64::from([MEASURE, TRANSMIT][action]));
        self.ran[action] += 1;
    }

    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.slots[slot][..bytes.len()]);
    }

    fn write_slot(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        self.slots[slot][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

/// What the node says of some days, and the truth in J.
pub(crate) struct Days {
    pub(crate) told: f64,
    pub(crate) bound: f64,
    pub(crate) truth: f64,
    /// Energy spent on knowing, of the harvested one.
    pub(crate) share: f64,
    /// Hours, and those whose income is within its bound.
    pub(crate) hours: u32,
    pub(crate) inside: u32,
    /// Readings of the voltage that were taken in, and the lowest voltage in V.
    pub(crate) readings: u32,
    pub(crate) lowest: f64,
}

/// Lives through some days.
pub(crate) fn days(count: u32) -> Result<Days, Box<dyn std::error::Error>> {
    let node = node()?;
    let board = Bench {
        map: ResponseMap::new(&map::MAP[..], map::FINGERPRINT)?,
        standing_power: node.parameters().budget.standing_power.into(),
        second: 0,
        stored: 0.5 * f64::from(CAPACITANCE) * 3.0 * 3.0,
        harvested: 0.0,
        started: None,
        taken: 0,
        ran: [0; ACTIONS],
        slots: [[0xFF; 1024]; 2],
    };
    let mut runner: ThisRunner = Runner::new(board, &node, 0);
    let mut image = [0; ThisRunner::image_bytes()];
    let (mut hour, mut before, mut saved) = (runner.state().last_hour(), 0.0, 0);
    let (mut hours, mut inside, mut lowest) = (0, 0, f64::INFINITY);
    while runner.state().second() < count * 24 * 3600 {
        lowest = lowest.min(runner.board().voltage());
        let known = f64::from(runner.state().spent_on_knowing());
        let step = runner.step();
        // The made-up storage pays what the node says that knowing costs.
        let known = f64::from(runner.state().spent_on_knowing()) - known;
        runner.board_mut().draw(known);
        if let Step::Heard(hearing) = step {
            let [power, bound] = runner.state().power().map(|power| 1e6 * power);
            println!("{:5} s: {hearing:?}, {power:.1} ± {bound:.1} uW", runner.state().second());
        }
        if runner.state().last_hour() != hour {
            hour = runner.state().last_hour();
            let truth = runner.board().harvested - before;
            before = runner.board().harvested;
            if let Some(told) = hour {
                hours += 1;
                inside += u32::from((f64::from(told.energy) - truth).abs() <= told.bound.into());
            }
        }
        // An image each hour, when nothing is under way. A reset at noon: the node goes on from its image.
        let second = runner.state().second();
        if runner.is_idle() && second - saved >= 3600 {
            saved = second;
            runner.save(&mut image)?;
            if second / 3600 == 12 {
                runner = Runner::new(runner.into_board(), &node, second);
                runner.resume(&mut image, Gap::OnUntil(second))?;
            }
        }
    }
    let (state, board) = (runner.state(), runner.board());
    let ([gain, of_gain], [measured, transmitted]) = (state.gain(), board.ran);
    println!(
        "gain of the map {gain:.2} ± {of_gain:.2}, true 0.80; {measured} measurements, {transmitted} transmissions"
    );
    let told = state.overall();
    Ok(Days {
        told: told.energy.into(),
        bound: told.bound.into(),
        truth: board.harvested,
        share: state.share_spent_on_knowing().into(),
        hours,
        inside,
        readings: state.instruments()[0],
        lowest,
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Days { told, bound, truth, share, hours, inside, readings, lowest } = days(1)?;
    let of_day = |energy: f64| 1e6 * energy / 86_400.0;
    println!("{inside} of {hours} hours are within their bounds");
    println!("income of the day {:.2} ± {:.2} uW, true {:.2} uW", of_day(told), of_day(bound), of_day(truth));
    println!(
        "spent on knowing it {:.2} % of the income, {readings} readings; lowest voltage {lowest:.2} V",
        100.0 * share
    );
    Ok(())
}

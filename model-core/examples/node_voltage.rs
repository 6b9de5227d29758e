//! A node that knows its income by the voltage of its storage, on a made-up board with an income of 5 µW by day.
use model_core::node::*;

/// In flash: a parameter outside its bounds does not compile.
static NODE: VoltageNode<2> = match PARAMETERS.build() {
    Ok(node) => node,
    Err(error) => panic!("{}", error.field),
};
const PARAMETERS: VoltageParameters<2> = VoltageParameters {
    storage: StorageParameters {
        capacitor: Capacitor { capacitance: 10e-3, leakage_resistance: 100e6 }, // F, Ω: data sheet
        charging_efficiency: 1.0, // of a matched converter, for the harvester's income
        discharging_efficiency: 0.9, // of the converter between storage and node, at the sleeping current
        highest_voltage: 4.5,     // V: from there on the protection shunts
        lock_out_voltage: 1.9,    // V: the supervisor switches the node off, and on again at
        turn_on_voltage: 2.2,     // V
    },
    converter: Converter { bits: 12, full_scale: 5.0, noise: 0.6e-3 }, // V with the divider; V, measure it
    standing_power: 0.6e-6, // W at the load, everything asleep: measure it
    reading: 0.3e-6,        // J of a reading: docs/node.md, "Cost"
    intervals: [60, 300],   // s between readings: the longest, and where the storage fills up sooner
    tolerances: Tolerances { standing: 0.05, capacitance: 0.115, ..Tolerances::EXACT }, // measured to 5 %; a part of ±20 %
    largest_power: 100e-6, // W: no harvester of this kind gives more
    reserve: 35e-3,        // J that actions leave for the longest rest, leakage included: docs/node.md
    actions: [Regular { energy: 300e-6, every: 60 }, Regular { energy: 5e-3, every: 600 }], // J at the load, s
};

/// Clock in s, stored energy in J, two slots of memory.
struct Bench(u32, f64, [[u8; 512]; 2]);

impl Board for Bench {
    fn sleep(&mut self, seconds: u32, _: u32) -> u32 {
        let power = if self.0 % 86_400 < 43_200 { 5e-6 } else { 0.0 };
        self.1 += f64::from(seconds) * (power - 0.6e-6 / 0.9 - self.1 / 500e3);
        self.0 += seconds;
        self.0
    }
    fn storage_code(&mut self) -> Option<u32> {
        Some(((200.0 * self.1).sqrt() / 5.0 * 4096.0).round() as u32)
    }
    fn run(&mut self, action: usize) {
        self.1 -= [300e-6, 5e-3][action] / 0.9;
    }
    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.2[slot][..bytes.len()]);
    }
    fn write_slot(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        self.2[slot][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

fn main() {
    let (mut hour, bench) = (None, Bench(0, 60e-3, [[0xFF; 512]; 2]));
    let (mut runner, mut modes) = (Runner::new(bench, &NODE, 0), Thresholds::new([[0.3, 0.4]])); // of the charge
    while runner.board().0 <= 86_400 {
        runner.step();
        if runner.is_idle() && runner.state().last_hour() != hour {
            hour = runner.state().last_hour();
            let now = NODE.status(runner.state());
            println!("{:5} s: {hour:?}, mode {}", runner.board().0, modes.mode(&now));
            println!("{:?}, {} s without income", now.verdict, now.endurance);
            let _ = runner.save(&mut [0; 512]); // an error of the memory
        }
    }
}

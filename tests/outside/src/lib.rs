//! Every scene, the estimators and both tiers of the node, linked without a panic: the panic handler calls a function that
//! does not exist, so the link fails where the compiler has left a panic in.

#![no_std]

use core::panic::PanicInfo;

use firmware_example::node::{NoMeter, Part, World, cycle};
use firmware_example::workload::{
    Progress, Workload, bump_stop, contact_separation, estimators, response_map, sliding,
};
use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::{AnyExcitation, Burst, Random, SpectralDensity, Sweep, SweepLaw};
use model_core::node::{
    Board, Capacitor, Converter, Fault, Regular, Runner, StorageParameters, Tolerances, VoltageParameters,
};
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{BumpStop, Choices, Restitution, Start, Stepper, Stop};

unsafe extern "C" {
    safe fn a_panic_is_linked() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    a_panic_is_linked()
}

/// The compiled `core` refers to it; nothing unwinds.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

/// As [`rust_eh_personality`].
#[unsafe(no_mangle)]
extern "C" fn _Unwind_Resume() {}

fn to_end(workload: &mut dyn Workload) {
    while !matches!(workload.advance(), Progress::Finished | Progress::Failed) {}
}

macro_rules! exported {
    ($($name:ident: $variant:path),* $(,)?) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name() -> bool {
            $variant(&mut to_end).is_some()
        }
    )*};
}

exported! {
    contact_separation_scene: contact_separation::bench,
    contact_separation_behind_a_bridge: contact_separation::others,
    sliding_scene: sliding::bench,
    sliding_with_sticking: sliding::others,
    bump_stop_scene: bump_stop::bench,
    bump_stop_others: bump_stop::others,
    bump_stop_with_its_error: bump_stop::checked,
    scene_estimators: estimators::all,
    response_maps: response_map::all,
}

/// An excitation of each kind, of these numbers.
fn excitation(kind: u32, numbers: &[f32; 4]) -> Option<AnyExcitation<'static, f32, 8>> {
    let [amplitude, low, high, time] = *numbers;
    Some(match kind {
        0 => AnyExcitation::Burst(Burst::cycles(amplitude, low, 3).ok()?.every(time).ok()?),
        1 => AnyExcitation::Burst(Burst::half_sine(amplitude, time).ok()?.starting_at(high).ok()?),
        2 => AnyExcitation::Sweep(Sweep::new(amplitude, [low, high], time, SweepLaw::Logarithmic, 0.0).ok()?),
        3 => AnyExcitation::Sweep(Sweep::new(amplitude, [low, high], time, SweepLaw::Linear, 0.0).ok()?),
        _ => {
            let points = [[low, amplitude], [high, amplitude]];
            AnyExcitation::Random(Random::new(&SpectralDensity::new(&points).ok()?, 8, u64::from(kind)).ok()?)
        }
    })
}

fn impacts(kind: u32, numbers: &[f32; 4], coefficient: f32) -> Option<f32> {
    let vibration = excitation(kind, numbers)?;
    let Stop { length, section, young_modulus, density, position, gap, contact_compliance, .. } =
        bump_stop::stop(bump_stop::GAP);
    let contact = Restitution { coefficient };
    let stop = Stop { length, section, young_modulus, density, position, gap, contact_compliance, contact };
    let scene: BumpStop<f32, _, 4, 1> =
        bump_stop::parameters(Choices::new(bump_stop::LOAD).stop(stop)).build().ok()?;
    let stepper = Stepper::new(scene, bump_stop::SHORT, bump_stop::LONG).ok()?;
    let mut state = stepper.start(&Start::default(), &vibration).ok()?;
    let mut meter = PowerMeter::new();
    stepper.advance(&mut state, &vibration, Instant::from_whole_seconds(2), 1000, &mut meter).ok()?;
    Some(meter.mean_power())
}

#[unsafe(no_mangle)]
extern "C" fn bump_stop_with_impacts(kind: u32, numbers: &[f32; 4], coefficient: f32) -> f32 {
    impacts(kind, numbers, coefficient).unwrap_or(f32::NAN)
}

#[unsafe(no_mangle)]
extern "C" fn map_node(world: &mut World) -> bool {
    cycle(Part::Nrf52832, world, &NoMeter, &mut |_| ()).is_ok()
}

/// A board whose peripherals are functions of the caller.
#[repr(C)]
pub struct Peripherals {
    sleep: extern "C" fn(u32) -> u32,
    convert: extern "C" fn() -> u32,
    act: extern "C" fn(u32),
    slots: [[u8; 512]; 2],
}

impl Board for &mut Peripherals {
    fn sleep(&mut self, seconds: u32, _: u32) -> u32 {
        (self.sleep)(seconds)
    }

    fn storage_code(&mut self) -> Option<u32> {
        Some((self.convert)())
    }

    fn run(&mut self, action: usize) {
        (self.act)(u32::try_from(action).unwrap_or(u32::MAX));
    }

    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]) {
        for (byte, kept) in bytes.iter_mut().zip(self.slots.iter().nth(slot).into_iter().flatten()) {
            *byte = *kept;
        }
    }

    fn write_slot(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        for (kept, byte) in self.slots.iter_mut().nth(slot).into_iter().flatten().zip(bytes) {
            *kept = *byte;
        }
        Ok(())
    }
}

#[unsafe(no_mangle)]
extern "C" fn voltage_node(peripherals: &mut Peripherals, parameters: &[f32; 2]) -> bool {
    let parameters = VoltageParameters {
        storage: StorageParameters {
            capacitor: Capacitor { capacitance: parameters[0], leakage_resistance: parameters[1] },
            charging_efficiency: 1.0,
            discharging_efficiency: 0.9,
            highest_voltage: 4.5,
            lock_out_voltage: 1.9,
            turn_on_voltage: 2.2,
        },
        converter: Converter { bits: 12, full_scale: 5.0, noise: 0.6e-3 },
        standing_power: 0.6e-6,
        reading: 0.3e-6,
        intervals: [60, 300],
        tolerances: Tolerances::EXACT,
        largest_power: 100e-6,
        reserve: 35e-3,
        actions: [Regular { energy: 300e-6, every: 60 }, Regular { energy: 5e-3, every: 600 }],
    };
    let Ok(node) = parameters.build() else { return false };
    let mut runner = Runner::new(peripherals, &node, 0);
    while runner.state().last_hour().is_none() {
        runner.step();
    }
    runner.save(&mut [0; 512]).is_ok()
}

//! The node of [`firmware_example::node`] on the board of [`firmware_example::board`], on a microcontroller whose
//! peripherals are a register each: the firmware that a user would flash, without the layers of a crate for a part.
//!
//! `host-bench on-target --node` builds it for each core for its size. It is not run: no part has these registers. `node_stack`
//! is the same program on registers in memory, for its stack. `HARVESTER_VARIANT=voltage` at build chooses the node by the voltage
//! alone in both.

#![cfg_attr(target_os = "none", no_std, no_main)]

use cortex_m0_arithmetic as _;

#[cfg(target_os = "none")]
mod target {
    use firmware_example::node::bare::{Register, Registers, run};
    use firmware_example::stop::{Code, stop};

    /// The first register, and the two pages of the images.
    const REGISTERS: usize = 0x4000_0000;
    const PAGES: usize = 0x0003_f800;

    struct Peripherals;

    fn address(register: Register) -> *mut u32 {
        core::ptr::without_provenance_mut(REGISTERS + 4 * register as usize)
    }

    impl Registers for Peripherals {
        fn read(register: Register) -> u32 {
            // SAFETY: the address of a register, which only this program uses.
            unsafe { address(register).read_volatile() }
        }

        fn write(register: Register, value: u32) {
            // SAFETY: as above.
            unsafe { address(register).write_volatile(value) }
        }

        fn pages() -> usize {
            PAGES
        }
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        run::<Peripherals>(|_| false);
        stop(Code::Done)
    }
}

firmware_example::main_on_host!();

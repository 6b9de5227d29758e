//! Links the firmware for the board that the environment variable `HARVESTER_BOARD` names, and makes a table of the day
//! that the node lives through.
//!
//! A variable and not a Cargo feature for each board: a firmware has exactly one memory map, and
//! features are meant to be added together.

use std::path::Path;
use std::{env, fs};

/// What the linker must know about a board.
struct Board {
    name: &'static str,
    target: &'static str,
    /// `None`: the numbers that stand in `memory.x` itself.
    memory: Option<Memory>,
}

/// Origins, and lengths in KiB.
struct Memory {
    flash: (u32, u32),
    ram: (u32, u32),
}

/// The boards that QEMU emulates, one for each core, and the part of the binary `node_nrf52832`. The first one is the default.
const BOARDS: [Board; 6] = [
    // Cortex-M4F, STM32F405.
    Board { name: "netduinoplus2", target: "thumbv7em-none-eabihf", memory: None },
    // Cortex-M0, nRF51822.
    Board {
        name: "microbit",
        target: "thumbv6m-none-eabi",
        memory: Some(Memory { flash: (0x0000_0000, 256), ram: (0x2000_0000, 16) }),
    },
    // Cortex-M3, STM32F100RB.
    Board {
        name: "stm32vldiscovery",
        target: "thumbv7m-none-eabi",
        memory: Some(Memory { flash: (0x0800_0000, 128), ram: (0x2000_0000, 8) }),
    },
    // Cortex-M7. Of the board's 4 MiB of RAM as much as the default board has: the stack is painted
    // before each measurement, and a megabyte of it would take longer than what is measured.
    Board {
        name: "mps2-an500",
        target: "thumbv7em-none-eabihf",
        memory: Some(Memory { flash: (0x0000_0000, 4096), ram: (0x2000_0000, 128) }),
    },
    // Cortex-M33, in its secure state. RAM as above.
    Board {
        name: "mps2-an505",
        target: "thumbv8m.main-none-eabihf",
        memory: Some(Memory { flash: (0x1000_0000, 4096), ram: (0x3800_0000, 128) }),
    },
    // nRF52832, not under QEMU. The last two pages of its 512 KiB of flash are the slots of the node's images.
    Board {
        name: "nrf52832",
        target: "thumbv7em-none-eabihf",
        memory: Some(Memory { flash: (0x0000_0000, 504), ram: (0x2000_0000, 64) }),
    },
];

/// The scene that `needs --emit` made, for the variant `emitted::bench`.
const SCENE: &str = "scene/contact_separation.rs";

/// Minutes of a day, by `host-bench on-target --day`: two amplitudes with their frequencies, and the harvested energy.
const DAY: &str = "trace/day.csv";

fn main() {
    println!("cargo::rerun-if-env-changed=HARVESTER_BOARD");
    println!("cargo::rerun-if-env-changed=DEFMT_LOG");
    println!("cargo::rerun-if-env-changed=HARVESTER_SCENE");
    println!("cargo::rerun-if-changed=memory.x");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={DAY}");

    if let Err(reason) = write_day().and_then(|()| copy_scene()) {
        println!("cargo::error={reason}");
        return;
    }
    // On the host the binaries are stubs and the ordinary linker does the right thing.
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }

    // Left to itself defmt compiles every `info!` out, and the bench would have nothing to say.
    if env::var_os("DEFMT_LOG").is_none() {
        println!("cargo::rustc-env=DEFMT_LOG=info");
    }

    let board = match chosen_board() {
        Ok(board) => board,
        Err(reason) => {
            println!("cargo::error={reason}");
            return;
        }
    };
    if let Some(Memory { flash, ram }) = &board.memory {
        for (region, (origin, kibibytes)) in [("flash", flash), ("ram", ram)] {
            let length = kibibytes * 1024;
            println!("cargo::rustc-link-arg-bins=--defsym=_{region}_origin={origin:#x}");
            println!("cargo::rustc-link-arg-bins=--defsym=_{region}_length={length:#x}");
        }
    }
    // Pages of 64 KiB would push the first section away from the start of the flash.
    println!("cargo::rustc-link-arg-bins=--nmagic");
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
    // memory.x, for the binaries of `embassy` too.
    println!("cargo::rustc-link-search={}", env!("CARGO_MANIFEST_DIR"));
}

/// The board asked for, once it is known to have the core that is compiled for.
fn chosen_board() -> Result<&'static Board, String> {
    let name = env::var("HARVESTER_BOARD").unwrap_or_else(|_| BOARDS[0].name.to_owned());
    let target = env::var("TARGET").unwrap_or_default();
    let known: Vec<_> = BOARDS.iter().map(|board| format!("{} ({})", board.name, board.target)).collect();
    let known = known.join(", ");
    let board = BOARDS
        .iter()
        .find(|board| board.name == name)
        .ok_or_else(|| format!("HARVESTER_BOARD={name} is none of {known}"))?;
    if target != board.target {
        return Err(format!(
            "the board {name} is not built for {target}; HARVESTER_BOARD chooses one of {known}"
        ));
    }
    Ok(board)
}

/// Copies the emitted scene to where the firmware includes it.
fn copy_scene() -> Result<(), String> {
    let from = env::var("HARVESTER_SCENE").unwrap_or_else(|_| SCENE.to_owned());
    println!("cargo::rerun-if-changed={from}");
    let folder = env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    fs::copy(&from, Path::new(&folder).join("scene.rs")).map_err(|error| format!("{from}: {error}"))?;
    Ok(())
}

/// Writes the minutes of the day as a Rust table.
fn write_day() -> Result<(), String> {
    let text = fs::read_to_string(DAY).map_err(|error| format!("{DAY}: {error}"))?;
    let mut minutes = String::new();
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    for line in lines {
        let misfit = |_| format!("{DAY}: {line:?}: five whole numbers are expected");
        let numbers =
            line.split(',').map(str::parse::<u32>).collect::<Result<Vec<_>, _>>().map_err(misfit)?;
        let [one, at, other, other_at, energy] = numbers[..] else {
            return Err(format!("{DAY}: {line:?}: five whole numbers are expected"));
        };
        minutes +=
            &format!("Minute {{ lines: [[{one}, {at}], [{other}, {other_at}]], energy: {energy} }},\n");
    }
    let count = minutes.lines().count();
    let table = format!("/// The minutes of the day.\npub static DAY: [Minute; {count}] = [\n{minutes}];\n");
    let folder = env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    fs::write(Path::new(&folder).join("day.rs"), table).map_err(|error| format!("day.rs: {error}"))
}

//! Links the firmware.

fn main() {
    // On the host the ordinary linker does the right thing.
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
            println!("cargo::rustc-link-arg-bins={argument}");
        }
        // The numbers of an nRF52840 for memory.x: 1 MiB of flash without its last four pages, and 256 KiB of RAM.
        for symbol in
            ["flash_origin=0", "flash_length=0xfc000", "ram_origin=0x20000000", "ram_length=0x40000"]
        {
            println!("cargo::rustc-link-arg-bin=node_nrf52840=--defsym=_{symbol}");
        }
    }
}

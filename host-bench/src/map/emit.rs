//! A map as a Rust module, and as bytes.

use std::fmt::Write;

use super::{Agreement, Map};
use crate::name::Name;

/// Words in a line of the module.
const PER_LINE: usize = 14;

/// The map as a Rust module with constants for firmware; `command` made it.
#[must_use]
pub fn module(map: &Map, scene: &str, command: &str) -> String {
    let [scene, command] = [scene, command].map(|text| Name::new(text).line());
    let Map { image, axes, agreement, .. } = map;
    let Agreement { places, median, percentile_90, bounds_hold, .. } = agreement;
    let [low, high] = axes.amplitudes;
    let [first, last] =
        [axes.frequencies.first(), axes.frequencies.last()].map(|end| end.copied().unwrap_or(0.0));
    let mut text = format!(
        "//! Response map of {scene}, from {low} to {high} m/s² and from {first:.3} to {last:.3} Hz, for\n\
         //! `model_core::energy::ResponseMap`. Made by:\n\
         //!\n\
         //! ```sh\n\
         //! {command}\n\
         //! ```\n\
         //!\n\
         //! At {places} random places off its nodes the median error is {:.2} %, the 90th percentile {:.2} %, and the bounds\n\
         //! hold at {:.1} %.\n\n\
         /// Fingerprint of the harvester.\n\
         pub const FINGERPRINT: u32 = {:#010x};\n\n\
         /// Resonance of the harvester and its half-bandwidth in Hz: arguments of `excitation::LineBank::new`.\n\
         pub const RESONANCE_HZ: f32 = {:?};\n\
         pub const HALF_BANDWIDTH_HZ: f32 = {:?};\n\n\
         /// The map: `ResponseMap::new(&MAP[..], FINGERPRINT)`.\n\
         pub static MAP: [u16; {}] = [\n",
        100.0 * median,
        100.0 * percentile_90,
        100.0 * bounds_hold,
        image.fingerprint,
        axes.centre_hz as f32,
        axes.half_bandwidth_hz as f32,
        image.words.len(),
    );
    for line in image.words.chunks(PER_LINE) {
        let words: Vec<String> = line.iter().map(u16::to_string).collect();
        // A string takes all that is written.
        let _ = writeln!(text, "    {},", words.join(", "));
    }
    text + "];\n"
}

/// The map as little-endian bytes.
#[must_use]
pub fn bytes(map: &Map) -> Vec<u8> {
    map.image.words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

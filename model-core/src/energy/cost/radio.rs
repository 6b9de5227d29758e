//! Energy of a packet of a radio.

use super::Evidence::{Confirmed, Estimated, Unconfirmed};
use super::{Evidence, Figure};
use crate::scalar::Scalar;

/// A radio at one rate and power as data.
///
/// A packet of `n` bytes takes `t_r + t_o + 8 n/R`: the ramp-up, the overhead and the bits at the rate `R`. In all of it
/// the radio draws the current of transmission, which is an upper bound for the ramp-up. Reception is not included.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Radio<S> {
    /// Name of the part, its modulation and power.
    pub name: &'static str,
    /// Supply voltage of the figures in V.
    pub supply: S,
    /// Supply current while it transmits, in A.
    pub transmitting: Figure<S>,
    /// Time from off to the first bit in s: its oscillator and its synthesizer.
    pub ramp_up: Figure<S>,
    /// Time in s of what a packet has beside its payload: preamble, address, header, checksum.
    pub overhead: Figure<S>,
    /// Bits of the payload in a second, error correction deducted.
    pub bit_rate: Figure<S>,
    /// Most bytes of a payload.
    pub most_bytes: u32,
}

impl<S: Scalar> Radio<S> {
    /// Time of a packet of `bytes` in s, ramp-up included. `None` above the most bytes of a payload.
    #[must_use]
    pub fn packet_time(&self, bytes: u32) -> Option<S> {
        (bytes <= self.most_bytes).then(|| {
            let bits = S::from_u32(8 * bytes);
            self.ramp_up.value + self.overhead.value + bits / self.bit_rate.value
        })
    }

    /// Energy of a packet of `bytes` in J. `None` above the most bytes of a payload.
    #[must_use]
    pub fn packet(&self, bytes: u32) -> Option<S> {
        Some(self.transmitting.value * self.supply * self.packet_time(bytes)?)
    }

    /// All radios.
    #[must_use]
    pub fn all() -> [Self; 3] {
        [Self::nrf52832(), Self::sx1261_fsk(), Self::sx1261_lora_sf7()]
    }

    /// Nordic nRF52832, Bluetooth Low Energy at 1 Mbit/s, 0 dBm, with its DC/DC converter.
    ///
    /// The overhead is 1 byte of preamble, 4 of address, 2 of header, 6 of the advertiser's address and 3 of checksum.
    #[must_use]
    pub fn nrf52832() -> Self {
        let radio = "nRF52832 product specification 1.1, current consumption of the radio";
        Self {
            name: "nRF52832 0 dBm",
            supply: S::from_f64(3.0),
            transmitting: Figure::new(7.1e-3, Confirmed, radio),
            ramp_up: Figure::new(0.5e-3, Unconfirmed, "nRF52832 product specification, oscillator and TXEN"),
            overhead: Figure::new(128e-6, Unconfirmed, "16 bytes of an advertising packet"),
            bit_rate: Figure::new(1e6, Confirmed, radio),
            most_bytes: 31,
        }
    }

    /// Semtech SX1261, FSK at 50 kbit/s, +14 dBm, with its DC/DC converter.
    ///
    /// The overhead is 5 bytes of preamble, 3 of synchronisation, 1 of length and 2 of checksum.
    #[must_use]
    pub fn sx1261_fsk() -> Self {
        Self {
            name: "SX1261 FSK 14 dBm",
            overhead: Figure::new(1.76e-3, Estimated, "11 bytes"),
            bit_rate: Figure::new(50e3, Unconfirmed, SX1261),
            ..Self::sx1261()
        }
    }

    /// Semtech SX1261, LoRa with spreading factor 7 in 125 kHz, coding rate 4/5, +14 dBm, with its DC/DC converter.
    ///
    /// A symbol lasts `2⁷/125 kHz` and a block of 28 bits 5 symbols. The overhead is 12.25 symbols of preamble, 8 of the
    /// first block, and 44 bits of header, checksum and the rounding to whole blocks.
    #[must_use]
    pub fn sx1261_lora_sf7() -> Self {
        let symbol = 128.0 / 125e3;
        Self {
            name: "SX1261 LoRa SF7 14 dBm",
            overhead: Figure::new(
                (12.25 + 8.0 + 5.0 * 44.0 / 28.0) * symbol,
                Evidence::Unconfirmed,
                "time on air by the SX1261 data sheet",
            ),
            bit_rate: Figure::new(28.0 / (5.0 * symbol), Unconfirmed, "time on air by the SX1261 data sheet"),
            ..Self::sx1261()
        }
    }

    fn sx1261() -> Self {
        Self {
            name: "SX1261",
            supply: S::from_f64(3.3),
            transmitting: Figure::new(25.5e-3, Unconfirmed, SX1261),
            ramp_up: Figure::new(
                1e-3,
                Estimated,
                "crystal oscillator, synthesizer and ramp of the amplifier",
            ),
            overhead: Figure::new(0.0, Estimated, "none"),
            bit_rate: Figure::new(50e3, Unconfirmed, SX1261),
            most_bytes: 255,
        }
    }
}

/// Where the figures of the SX1261 are remembered from.
const SX1261: &str = "SX1261 data sheet";

//! Boards of [`model_core::node`] over the traits of `embedded-hal` 1.0.
//!
//! | module | subject |
//! | --- | --- |
//! | `adxl362` | the registers of an accelerometer with a FIFO, over SPI |
//! | `flash` | two slots for images in NOR flash |
//! | `hal` | a board of any microcontroller whose crate implements the traits |
//! | `example` | the parameters of a node on such a board |

pub mod adxl362;
pub mod example;
pub mod flash;
pub mod hal;

#[cfg(test)]
mod tests;

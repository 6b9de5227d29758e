#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
//! Vibration energy harvesters on a microcontroller.

pub mod clock;
pub mod excitation;
pub mod scalar;

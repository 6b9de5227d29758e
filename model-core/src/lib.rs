#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
//! Vibration energy harvesters on a microcontroller.

pub mod clock;
pub mod energy;
pub mod excitation;
pub mod hybrid;
pub mod integrate;
pub mod part;
pub mod scalar;
pub mod scene;

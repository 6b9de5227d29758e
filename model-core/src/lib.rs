#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![allow(
    private_bounds,
    private_interfaces,
    reason = "some traits are sealed: the crate implements them, nobody else"
)]
//! Simulates vibration energy harvesters on a microcontroller and estimates the harvested power.
//!
//! `no_std`, fixed allocation, no panics, generic over `f32` and `f64`. The same input gives the same bits on
//! every core and on the host, so a host test covers the code of the node.
//!
//! ```
//! use model_core::clock::Instant;
//! use model_core::energy::PowerMeter;
//! use model_core::excitation::Sine;
//! use model_core::integrate::{Adaptive, ExponentialRadau};
//! use model_core::part::load::Resistor;
//! use model_core::part::restitution::ConstantRestitution;
//! use model_core::scene::contact_separation::{Choices, Parameters, Start};
//! use model_core::scene::{Harvester, Simulation};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = Parameters {
//!     mass: 5e-3,
//!     stiffness: 80.0,
//!     damping_ratio: 0.005,
//!     initial_gap: 3e-3,
//!     electrode_area: 4e-4,
//!     dielectric_thickness: 5e-5,
//!     relative_permittivity: 2.0,
//!     charge_density: 50e-6,
//!     choices: Choices::new(Resistor { resistance: 1e8 }, ConstantRestitution { coefficient: 0.75 }),
//! }
//! .build()?;
//! let shaking = Sine::<f32>::new(1.962, 20.5, 0.0)?; // m/s², Hz, rad
//! let harvester = Simulation::new(scene, ExponentialRadau, Adaptive::new(5e-2)?);
//! let mut state = harvester.start(&Start::default(), &shaking)?;
//! let mut meter = PowerMeter::new();
//! harvester.advance(&mut state, &shaking, Instant::from_whole_seconds(2), 10_000, &mut meter)?;
//! assert!((5e-6..20e-6).contains(&meter.mean_power())); // W
//! # Ok(())
//! # }
//! ```
//!
//! # Modules
//!
//! A module uses only the modules below it in this table:
//!
//! | module | content |
//! | --- | --- |
//! | [`node`] | a node that joins map, listening, storage and budget |
//! | [`energy`] | meters, the energy ledger; a node's energy budget |
//! | [`scene`] | the harvesters: parameters, checked once, and pure functions |
//! | [`part`] | the components of harvesters: loads, restitution |
//! | [`observer`] | the accepted step and the event of every harvester |
//! | [`hybrid`] | the driver: step, event location, jump |
//! | [`integrate`] | exponential Radau, TR-BDF2 and RK4, step control, dense output |
//! | [`excitation`] | the acceleration of the base |
//! | [`oscillator`] | the exact motion of a linear oscillator over a step |
//! | [`clock`] | time in integer ticks, phase without drift |
//! | [`scalar`] | the floating-point number and its elementary functions |
//! | [`snapshot`] | states as bytes, for a power-down |
//! | [`bounds`] | bounds of parameters, and the error of a parameter outside them |
//!
//! # Errors
//!
//! [`scene::ParameterError`] names the field, the value and the bounds of a refused parameter. A failed step
//! returns a [`hybrid::StepError`], and the state is then the last good one. An excitation returns an
//! [`excitation::ExcitationError`], an estimator an [`energy::estimator::EstimatorError`]. No function panics.

mod any;
pub mod bounds;
pub mod clock;
pub mod energy;
pub mod excitation;
pub mod hybrid;
pub mod integrate;
pub mod node;
pub mod observer;
pub mod oscillator;
pub mod part;
pub mod scalar;
pub mod scene;
pub mod snapshot;

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
//! use model_core::simulate::contact_separation::{Choices, Parameters, Start};
//! use model_core::simulate::*;
//!
//! # fn main() -> Result<(), model_core::Error> {
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
//! let vibration = Sine::<f32>::new(1.962, 20.5, 0.0)?; // m/s², Hz, rad
//! let harvester = Simulation::new(scene, ExponentialRadau, Adaptive::new(5e-2)?);
//! let mut state = harvester.start(&Start::default(), &vibration)?;
//! let mut meter = PowerMeter::new();
//! harvester.advance(&mut state, &vibration, Instant::from_whole_seconds(2), 10_000, &mut meter)?;
//! assert!((5e-6..20e-6).contains(&meter.mean_power())); // W
//! # Ok(())
//! # }
//! ```
//!
//! # What it is for
//!
//! | task | module | start with | example |
//! | --- | --- | --- | --- |
//! | simulate a harvester | [`simulate`] | [`Simulation`](simulate::Simulation), [`bump_stop::Stepper`](simulate::bump_stop::Stepper) | `sliding`, `bump_stop`, `own_harvester` |
//! | estimate the power from accelerometer samples | [`estimate`] | [`Estimator`](estimate::Estimator) | `estimator` |
//! | know the income of a node within µW | [`node`] | [`VoltageNode`](node::VoltageNode), [`FlashMapNode`](node::FlashMapNode) | `node_voltage`, `node` |
//! | decide which actions a node can run | [`budget`] | [`BudgetParameters`](budget::BudgetParameters) | `estimator` |
//!
//! Each module has all names of its task. Every error converts into [`Error`] by `?`, but for [`node::Fault`] of a board.
//!
//! # Modules
//!
//! A module uses only the modules below it in this table:
//!
//! | module | content |
//! | --- | --- |
//! | [`node`] | a node that joins map, bursts, storage and budget |
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

pub mod bounds;
pub mod clock;
pub mod energy;
mod error;
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

pub use error::Error;

/// Simulates a harvester: scene, load, excitation, method, meters.
pub mod simulate {
    pub use crate::clock::Instant;
    pub use crate::energy::{Ledger, PowerMeter, RunMeter};
    pub use crate::excitation::{AfterLastSample, Burst, Random, Sampled, Silence, Sine, Sweep, Tones};
    pub use crate::integrate::{Adaptive, ExponentialRadau, FixedStep, TrBdf2};
    pub use crate::part::draw::NoDraw;
    pub use crate::part::load::{OpenCircuit, Resistor};
    pub use crate::part::monomorph::{Bimorph, Layer};
    pub use crate::part::restitution::ConstantRestitution;
    pub use crate::part::storage::{Capacitor, StorageCapacitor};
    pub use crate::scene::rectified::{FullBridge, Rectified};
    pub use crate::scene::{Harvester, Simulation, bump_stop, contact_separation, sliding};
}

/// Estimates the harvested power from the samples of an accelerometer, and saves its state.
pub mod estimate {
    pub use crate::energy::estimator::{Interpolation, SampleFormat, Settings};
    pub use crate::energy::{Estimate, Estimator, Uncertainty};
    pub use crate::snapshot::{newest_image, save_image};
}

/// Keeps the energy of a storage, forecasts it, and decides which actions a node can run.
pub mod budget {
    pub use crate::energy::{
        Action, Battery, BatteryCurve, Budget, BudgetParameters, BudgetState, Capacitor, IncomeParameters,
        StorageParameters,
    };
}

/// Methods in the `impl` of a trait for an enum of components, one `match` for all of them:
/// `forward! { match { Self::None => NoDraw, Self::Power(draw) => draw } fn current(&self, voltage: S) -> S; }`
macro_rules! forward {
    (match $arms:tt $(
        $(#[$attribute:meta])*
        fn $method:ident(&self $(, $argument:ident: $type:ty)* $(,)?) $(-> $result:ty)?;
    )+) => {$(
        $(#[$attribute])*
        fn $method(&self $(, $argument: $type)*) $(-> $result)? {
            $crate::forward!(@ self $arms $method ($($argument),*))
        }
    )+};
    (@ $self:ident { $($variant:pat => $component:expr),+ $(,)? } $method:ident $arguments:tt) => {
        match $self { $($variant => $component.$method $arguments),+ }
    };
}
pub(crate) use forward;

//! A triboelectric harvester behind a full bridge of diodes that charges a storage or feeds a DC bus.
//!
//! The bridge is a [`FullBridge`] at the open terminals of a triboelectric scene. A scene with a resistor contains
//! none of this code.
//!
//! | symbol | quantity | unit | sign |
//! | --- | --- | --- | --- |
//! | `x` | gap (contact-separation) or displacement (sliding) | m | as in the scene |
//! | `Q` | charge that has passed the terminals | C | as in the scene |
//! | `V` | terminal voltage | V | as in the scene |
//! | `V_s`, `C_s` | voltage and capacitance of the storage | V, F | `V_s ≥ 0` |
//! | `V_D` | drop of each of two conducting diodes | V | `≥ 0` |
//! | `U = V_s + 2 V_D` | threshold voltage | V | `≥ 0` |
//! | `s` | direction of the current, that of `Q'` | 1 | `±1` |
//! | `i_out` | leakage and draw of the storage | A | positive out of the storage |
//! | `Q0`, `ΔQ = Q − Q0` | charge at the start of conduction, and since | C | as `Q` |
//! | `B` | storage voltage without the charge of the present conduction | V | |
//!
//! # The three regimes
//!
//! The terminal voltage is linear in the charge: equations (23) to (25) of Fu, Ouyang and Davis, J. Phys. D 53
//! (2020), for contact-separation (`Q = q − C_p V`), and (12) to (15) for sliding (`Q = q`),
//!
//! ```text
//! V(x, Q) = (σ S x − Q (x + d_e)) / (ε0 S + C_p (x + d_e))        contact-separation
//! V(x, Q) = (σ S2(x) − Q) d / (ε0 ε_r S1(x))                      sliding
//! ```
//!
//! The bridge blocks while `|V| < U`. While it conducts, it clamps `V` to `s U`. The storage follows `C_s V_s' = s Q'
//! − i_out(V_s)`. There are three regimes:
//!
//! | regime | charge | storage | end of the regime |
//! | --- | --- | --- | --- |
//! | blocked | `Q' = 0` | `C_s V_s' = −i_out` | `V` rises through `U`, or falls through `−U` |
//! | forward, backward: `s = ±1` | `V(x, Q) = s (V_s + 2 V_D)` | `C_s V_s' = s Q' − i_out` | `s Q'` falls through 0 |
//!
//! The time derivative of `V(x, Q) = s (V_s + 2 V_D)` gives the current without a difference of voltages,
//!
//! ```text
//! Q' = (∂V/∂x · x' + s i_out/C_s) / (1/C_s − ∂V/∂Q)
//! ```
//!
//! with a positive denominator (derived here).
//!
//! # The electrical state
//!
//! During conduction the charge is not integrated. The state holds `Q0` and `B`, with `C_s B' = −i_out(V_s)`. With
//! `V_s = B + s ΔQ/C_s` the condition is linear in `ΔQ`:
//!
//! ```text
//! ΔQ = (V(x, Q0) − s (B + 2 V_D)) / (1/C_s − ∂V/∂Q)
//! ```
//!
//! So the circuit has no fast time constant, an explicit method is as good as an implicit one, and conduction begins
//! without a change of state. When conduction ends, `Q0` increases by `ΔQ` and `B` by `s ΔQ/C_s`. A step raises the
//! voltage of a large storage by less than its rounding, so the rounding remainder is kept through every event.
//!
//! With `V_s = V_D = 0` the bridge is a short circuit; with `U` above every `V` it is an open circuit. While the
//! scene freezes its charge in stick, the bridge blocks and the terminal voltage counts as zero. If the storage
//! voltage falls meanwhile, `|V|` may exceed `U` at the release, as it may at a start. The excess `|V| − U` then
//! drives a charge through the bridge instantaneously, and half of the excess times this charge is lost in the
//! diodes, in addition to `2 V_D` times this charge.
//!
//! ```
//! use model_core::clock::Instant;
//! use model_core::energy::PowerMeter;
//! use model_core::excitation::Sine;
//! use model_core::integrate::{Adaptive, ExponentialRadau};
//! use model_core::part::draw::{Lockout, PowerDraw};
//! use model_core::part::load::OpenCircuit;
//! use model_core::part::rectifier::FullBridge;
//! use model_core::part::restitution::ConstantRestitution;
//! use model_core::part::storage::{Capacitor, StorageCapacitor};
//! use model_core::scene::contact_separation::{Choices, Parameters, Start};
//! use model_core::scene::rectified::Rectified;
//! use model_core::scene::{Harvester, Simulation};
//!
//! # fn main() -> Result<(), model_core::Error> {
//! let harvester = Parameters {
//!     mass: 5e-3,
//!     stiffness: 80.0,
//!     damping_ratio: 0.005,
//!     initial_gap: 3e-3,
//!     electrode_area: 4e-4,
//!     dielectric_thickness: 5e-5,
//!     relative_permittivity: 2.0,
//!     charge_density: 50e-6,
//!     // The bridge is at the open terminals.
//!     choices: Choices::new(OpenCircuit, ConstantRestitution { coefficient: 0.75 }),
//! }
//! .build()?;
//! // A 1 µF storage behind diodes of 0.3 V; its node draws 2 µW from 4.5 V on and down to 3 V.
//! let draw = PowerDraw { power: 2e-6, lockout: Lockout { turn_on: 4.5, turn_off: 3.0 } };
//! let storage = StorageCapacitor { capacitor: Capacitor { capacitance: 1e-6, leakage_resistance: 1e9 }, initial_voltage: 0.0, draw };
//! let scene = Rectified::new(harvester, FullBridge { diode_drop: 0.3, storage })?;
//! let vibration = Sine::<f32>::new(1.962, 20.0, 0.0)?; // m/s², Hz, rad
//! let harvester = Simulation::new(scene, ExponentialRadau, Adaptive::new(1e-3)?);
//! let mut state = harvester.start(&Start::default(), &vibration)?;
//! let mut meter = PowerMeter::new();
//! harvester.advance(&mut state, &vibration, Instant::from_whole_seconds(2), 100_000, &mut meter)?;
//! let volts = scene.storage_voltage(state.mode, &state.point.state);
//! assert!((0.5..3.0).contains(&volts));
//! // No draw yet and hardly any leakage: the delivered energy is stored.
//! assert!((meter.delivered_energy() / (0.5e-6 * volts * volts) - 1.0).abs() < 1e-2);
//! # Ok(())
//! # }
//! ```

mod automaton;
mod electrics;
mod flow;
mod identity;

pub use crate::scene::coupled::{CHARGE, POSITION, VELOCITY};
pub use automaton::Mode;
pub use flow::Flow;

pub use crate::part::rectifier::{BridgeRegime, FullBridge};
pub use crate::scene::electrical_port::{ElectricalPort, PortVoltage};

use crate::bounds::{Bounds, ParameterError};
use crate::excitation::Excitation;
use crate::hybrid::HybridState;
use crate::integrate::StepControl;
use crate::part::load::Resistance;
use crate::part::storage::StorageElement;
use crate::scalar::Scalar;
use crate::scene::{Scene, coupled};

/// Number of states: those of the harvester, and the storage voltage.
pub const STATES: usize = coupled::STATES + 1;
/// Index of the storage voltage in V; during conduction `B`.
pub const STORAGE: usize = coupled::STATES;

/// A triboelectric harvester `H` behind a full bridge into a storage `R`, with checked parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectified<S, H, R> {
    harvester: H,
    bridge: FullBridge<S, R>,
    /// `1/C_s` in 1/F.
    per_farad: S,
    /// Rise of the storage voltage in V per charge unit.
    elastance: S,
    /// Voltage in V below which the storage voltage is not resolved.
    voltage_floor: S,
}

/// Resolution of the storage voltage relative to the typical voltage of the harvester.
const LEAST_VOLTAGE: f64 = 1e-6;

impl<S: Scalar, H: ElectricalPort<S>, R: StorageElement<S>> Rectified<S, H, R> {
    /// The harvester with the bridge at its terminals.
    ///
    /// # Errors
    /// A harvester with a load other than open, or a parameter of the bridge, the storage or its draw outside its bounds.
    pub fn new(harvester: H, bridge: FullBridge<S, R>) -> Result<Self, ParameterError<S>> {
        let resistance = match harvester.resistance() {
            Resistance::Short => S::ZERO,
            Resistance::Finite(resistance) => resistance,
            Resistance::Open => S::INFINITY,
        };
        Bounds { lowest: S::INFINITY, highest: S::INFINITY }.check("resistance", resistance)?;
        bridge.check()?;
        let per_farad = bridge.storage.elastance();
        let elastance = harvester.coulombs() * per_farad;
        Ok(Self {
            harvester,
            bridge,
            per_farad,
            elastance,
            voltage_floor: (S::from_f64(LEAST_VOLTAGE) * harvester.typical_voltage()).max(S::TINY),
        })
    }

    /// The state at time zero: the harvester's own start, a blocking bridge, and the initial voltage of the storage.
    ///
    /// # Errors
    /// A start that the harvester refuses.
    pub fn start<E: Excitation<S>, C: StepControl<S>, const POWERS: usize>(
        &self,
        start: &H::Start,
        excitation: &E,
        control: &C,
    ) -> Result<HybridState<S, Mode<H::Mode>, STATES, POWERS>, ParameterError<S>> {
        let alone = Scene::start(&self.harvester, start, excitation, control)?;
        let storage = &self.bridge.storage;
        let mode =
            Mode { inner: alone.mode, regime: BridgeRegime::Blocked, connected: storage.starts_connected() };
        let [position, velocity, charge] = alone.point.state;
        let state = [position, velocity, charge, storage.initial_voltage()];
        let begun = HybridState::start(self, mode, state, excitation, control);
        Ok(if alone.is_armed() { begun } else { begun.disarmed() })
    }

    /// The harvester.
    #[must_use]
    pub fn harvester(&self) -> &H {
        &self.harvester
    }

    /// The bridge with its storage.
    #[must_use]
    pub fn bridge(&self) -> &FullBridge<S, R> {
        &self.bridge
    }

    /// Voltage of the storage or bus in V.
    #[must_use]
    pub fn storage_voltage(&self, mode: Mode<H::Mode>, state: &[S; STATES]) -> S {
        self.electrics(mode, state).storage_voltage
    }

    /// The harvester's own state: position, velocity, and the charge that has passed its terminals, in its units.
    #[must_use]
    #[inline]
    pub fn harvester_state(&self, mode: Mode<H::Mode>, state: &[S; STATES]) -> [S; coupled::STATES] {
        [state[POSITION], state[VELOCITY], self.electrics(mode, state).charge]
    }
}

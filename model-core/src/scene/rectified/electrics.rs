//! The circuit at a state: charge, storage, current.

use super::{BridgeRegime, CHARGE, ElectricalPort, Mode, POSITION, Rectified, STATES, STORAGE};
use crate::part::storage::StorageElement;
use crate::scalar::Scalar;

/// The circuit at a state.
pub(super) struct Electrics<S> {
    /// Charge that has passed the terminals, in charge units.
    pub(super) charge: S,
    /// `ΔQ` in charge units.
    pub(super) transferred: S,
    /// `s ΔQ/C_s` in V: rise of the storage voltage since conduction began.
    pub(super) gained: S,
    /// `V_s` in V.
    pub(super) storage_voltage: S,
    /// `i_out/C_s` in V/s.
    pub(super) fall: S,
    /// `∂V/∂x` in V/m.
    pub(super) voltage_by_position: S,
    /// `∂²V/∂x²` in V/m² and `∂²V/∂x∂Q` in V/m per charge unit; in conduction only.
    pub(super) curvature: S,
    pub(super) by_both: S,
    /// `1/(1/C_s − ∂V/∂Q)` in charge units per V in conduction, else 0.
    pub(super) charge_by_voltage: S,
    /// `dV_s/dB`: part of a change of `B` that remains after charge sharing with the harvester's capacitance.
    pub(super) share: S,
}

impl<S: Scalar> Electrics<S> {
    /// `s Q' (1/C_s − ∂V/∂Q)` in V/s at a velocity in m/s: positive in conduction.
    #[inline]
    pub(super) fn drive(&self, sign: S, velocity: S) -> S {
        sign * self.voltage_by_position * velocity + self.fall
    }

    /// `s Q'` in charge units per s: the rectified current.
    #[inline]
    pub(super) fn rectified(&self, sign: S, velocity: S) -> S {
        self.charge_by_voltage * self.drive(sign, velocity)
    }
}

impl<S: Scalar, H: ElectricalPort<S>, R: StorageElement<S>> Rectified<S, H, R> {
    /// The circuit at a state; see [`super`].
    #[inline(always)]
    pub(super) fn electrics(&self, mode: Mode<H::Mode>, state: &[S; STATES]) -> Electrics<S> {
        let (start, base) = (state[CHARGE], state[STORAGE]);
        if mode.regime == BridgeRegime::Blocked {
            return Electrics {
                charge: start,
                transferred: S::ZERO,
                gained: S::ZERO,
                storage_voltage: base,
                fall: self.fall(mode, base),
                voltage_by_position: S::ZERO,
                curvature: S::ZERO,
                by_both: S::ZERO,
                charge_by_voltage: S::ZERO,
                share: S::ONE,
            };
        }
        let sign: S = mode.regime.sign();
        let terminal = self.harvester.port_voltage(mode.inner, state[POSITION], start);
        let charge_by_voltage = S::ONE / (self.elastance - terminal.by_charge);
        let transferred = (terminal.value - sign * self.bridge.threshold(base)) * charge_by_voltage;
        let gained = sign * transferred * self.elastance;
        let storage_voltage = base + gained;
        let voltage_by_position = terminal.by_position + terminal.by_both * transferred;
        // The curvature is that at the start times a function of the position, as the slope is.
        let bend =
            if terminal.by_position == S::ZERO { S::ZERO } else { terminal.curvature / terminal.by_position };
        Electrics {
            charge: start + transferred,
            transferred,
            gained,
            storage_voltage,
            fall: self.fall(mode, storage_voltage),
            voltage_by_position,
            curvature: bend * voltage_by_position,
            by_both: terminal.by_both,
            charge_by_voltage,
            share: -terminal.by_charge * charge_by_voltage,
        }
    }

    /// [`Electrics::fall`] at a storage voltage in V.
    #[inline]
    pub(super) fn fall(&self, mode: Mode<H::Mode>, voltage: S) -> S {
        self.per_farad * self.bridge.storage.outflow(voltage, mode.connected)
    }

    /// Derivative of [`Electrics::fall`] by the storage voltage, in 1/s.
    #[inline]
    pub(super) fn fall_by_voltage(&self, mode: Mode<H::Mode>, at: &Electrics<S>) -> S {
        self.per_farad * self.bridge.storage.outflow_by_voltage(at.storage_voltage, mode.connected)
    }
}

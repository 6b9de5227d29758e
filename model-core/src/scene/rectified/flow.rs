//! The flow of each mode, its iteration matrix, and the powers along it.

use super::electrics::Electrics;
use super::{BridgeRegime, ElectricalPort, Mode, POSITION, Rectified, STATES, STORAGE, VELOCITY};
use crate::integrate::{Base, CircuitEquation, Point, Stage, System};
use crate::observer::{ALL_POWERS, PowerIndex, first_powers};
use crate::oscillator::Oscillator;
use crate::part::storage::StorageElement;
use crate::scalar::{Scalar, sum};
use crate::scene::coupled::{Derivatives, ModeFactor};

/// The flow of one mode; `M` is the mode of the harvester.
#[derive(Debug, Clone, Copy)]
pub struct Flow<'a, S, H, R, M> {
    pub(super) scene: &'a Rectified<S, H, R>,
    pub(super) mode: Mode<M>,
}

impl<S: Scalar, H: ElectricalPort<S>, R: StorageElement<S>> Flow<'_, S, H, R, H::Mode> {
    /// The circuit at a state, and the harvester's own state.
    #[inline]
    fn parts(&self, state: &[S; STATES]) -> (Electrics<S>, [S; 3]) {
        let at = self.scene.electrics(self.mode, state);
        let own = [state[POSITION], state[VELOCITY], at.charge];
        (at, own)
    }

    /// Whether the harvester's position is fixed.
    #[inline]
    fn is_stick(&self) -> bool {
        self.scene.harvester.is_stick(self.mode.inner)
    }

    /// All powers; see [`PowerIndex`].
    #[inline]
    fn all_powers(&self, state: &[S; STATES], acceleration: S) -> [S; ALL_POWERS] {
        let scene = self.scene;
        let (at, own) = self.parts(state);
        let storage = &scene.bridge.storage;
        let voltage = at.storage_voltage;
        let mut powers = scene.harvester.all_powers(self.mode.inner, &own, acceleration);
        if self.mode.regime != BridgeRegime::Blocked {
            let sign: S = self.mode.regime.sign();
            let current = scene.harvester.coulombs() * at.rectified(sign, state[VELOCITY]);
            let threshold = scene.bridge.threshold(voltage);
            let drop = scene.bridge.diode_drop;
            powers[PowerIndex::Load as usize] = voltage * current;
            powers[PowerIndex::VoltageSquared as usize] = threshold * threshold;
            powers[PowerIndex::Voltage as usize] = sign * threshold;
            powers[PowerIndex::CurrentMagnitude as usize] = current.abs();
            powers[PowerIndex::Diodes as usize] = (drop + drop) * current;
        }
        powers[PowerIndex::Leakage as usize] = voltage * storage.leakage(voltage);
        powers[PowerIndex::Draw as usize] =
            if self.mode.connected { voltage * storage.drawn(voltage) } else { S::ZERO };
        powers
    }
}

impl<S: Scalar, H: ElectricalPort<S>, R: StorageElement<S>, const POWERS: usize> System<S, STATES, POWERS>
    for Flow<'_, S, H, R, H::Mode>
{
    type Factor = ModeFactor<S>;

    #[inline]
    fn flow(&self, state: &[S; STATES], acceleration: S) -> [S; STATES] {
        let (at, own) = self.parts(state);
        let [velocity, rate, _] =
            System::<S, 3, 0>::flow(&self.scene.harvester.flow(self.mode.inner), &own, acceleration);
        [velocity, rate, S::ZERO, -at.fall]
    }

    const CARRIED: bool = true;

    /// The motion is the harvester's own, with a charge that follows the position.
    #[inline]
    fn flow_from(
        &self,
        start: &Point<S, STATES, POWERS>,
        change: &[S; STATES],
        acceleration: S,
    ) -> [S; STATES] {
        let (at, _) = self.parts(&sum(&start.state, change));
        let mut own =
            Point { state: [S::ZERO; 3], remainder: [S::ZERO; 3], derivative: [S::ZERO; 3], powers: [] };
        own.state = [start.state[POSITION], start.state[VELOCITY], at.charge];
        own.remainder[POSITION] = start.remainder[POSITION];
        let flow = self.scene.harvester.flow(self.mode.inner);
        let change = [change[POSITION], change[VELOCITY], S::ZERO];
        let [velocity, rate, _] = System::<S, 3, 0>::flow_from(&flow, &own, &change, acceleration);
        [velocity, rate, S::ZERO, -at.fall]
    }

    /// With a charge that follows the position, and without the effect of the slow storage voltage on the motion.
    #[inline]
    fn factor(&self, state: &[S; STATES], _acceleration: S, weight: S) -> Option<ModeFactor<S>> {
        if self.is_stick() {
            return Some(ModeFactor::at_rest(weight, S::ZERO));
        }
        let (at, own) = self.parts(state);
        let open = self.scene.harvester.derivatives(self.mode.inner, &own);
        let charge_by_position = at.charge_by_voltage * at.voltage_by_position;
        let stiffness = open.stiffness + open.force_by_charge * charge_by_position;
        ModeFactor::moving(weight, &Derivatives { stiffness, ..open })
    }

    #[inline]
    fn solve(
        &self,
        factor: &ModeFactor<S>,
        [position, velocity, charge, storage]: [S; STATES],
    ) -> [S; STATES] {
        let [position, velocity, charge] = factor.solve([position, velocity, charge]);
        [position, velocity, charge, storage]
    }

    /// Newton's iteration on the velocity, each with one Newton iteration on the storage voltage.
    #[inline]
    fn iterate(
        &self,
        factor: &ModeFactor<S>,
        base: Base<'_, S, STATES, POWERS>,
        increment: &mut [S; STATES],
        acceleration: S,
        weight: S,
    ) -> [S; STATES] {
        let before = increment[STORAGE];
        self.condense(base, increment, weight);
        let storage = increment[STORAGE] - before;
        if self.is_stick() {
            return [S::ZERO, S::ZERO, S::ZERO, storage];
        }
        let [_, rate, _, _] = self.flow_from(base.start, &base.change(increment), acceleration);
        let [position, velocity, _] = factor.correction(weight * rate - increment[VELOCITY]);
        increment[VELOCITY] += velocity;
        [position, velocity, S::ZERO, storage]
    }

    #[inline]
    fn condense(&self, base: Base<'_, S, STATES, POWERS>, increment: &mut [S; STATES], weight: S) {
        let Base { start, carried } = base;
        if !self.is_stick() {
            let velocity = start.state[VELOCITY] + carried[VELOCITY];
            increment[POSITION] = weight * (velocity + increment[VELOCITY]);
        }
        if R::CHARGES {
            let state = sum(&start.state, &base.change(increment));
            let at = self.scene.electrics(self.mode, &state);
            let slope = weight * self.scene.fall_by_voltage(self.mode, &at) * at.share;
            let residual = -weight * at.fall - increment[STORAGE];
            increment[STORAGE] += residual / (S::ONE + slope);
        }
    }

    #[inline]
    fn powers(&self, state: &[S; STATES], _rate: &[S; STATES], acceleration: S) -> [S; POWERS] {
        first_powers(&self.all_powers(state, acceleration))
    }

    /// The charge of a step follows exactly from its ends, and the storage voltage is linear in the charge except for
    /// the outflow. With these energies the balance of the storage closes to rounding at any step length.
    #[inline]
    fn correct_energies(&self, start: &[S; STATES], end: &[S; STATES], energies: &mut [S; POWERS]) {
        if self.mode.regime == BridgeRegime::Blocked {
            return;
        }
        let scene = self.scene;
        let [from, to] = [start, end].map(|state| scene.electrics(self.mode, state));
        let sign: S = self.mode.regime.sign();
        let charge = sign * scene.harvester.coulombs() * (to.transferred - from.transferred);
        let drop = scene.bridge.diode_drop;
        let known = [
            (PowerIndex::Load, S::from_f64(0.5) * (from.storage_voltage + to.storage_voltage) * charge),
            (PowerIndex::CurrentMagnitude, charge),
            (PowerIndex::Diodes, (drop + drop) * charge),
        ];
        for (index, energy) in known {
            if let Some(entry) = energies.get_mut(index as usize) {
                *entry = energy;
            }
        }
    }

    /// Most steps end at an event.
    const EXTENSION_PART: f64 = 1e-3;

    const SPLIT: bool = true;
    const CIRCUIT: usize = STORAGE;

    #[inline]
    fn oscillator(&self) -> Option<Oscillator<S>> {
        System::<S, 3, 0>::oscillator(&self.scene.harvester.flow(self.mode.inner))
    }

    #[inline]
    fn force_rate(&self, state: &[S; STATES], rate: &[S; STATES]) -> S {
        let (at, own) = self.parts(state);
        let sign: S = self.mode.regime.sign();
        let current = sign * at.rectified(sign, state[VELOCITY]);
        let rate = [state[VELOCITY], rate[VELOCITY], current];
        System::<S, 3, 0>::force_rate(&self.scene.harvester.flow(self.mode.inner), &own, &rate)
    }

    /// `B' = −i_out(V_s)/C_s`, linearised about `B` at the start of the step.
    #[inline(always)]
    fn stage(&self, start: &Point<S, STATES, POWERS>, displacement: S, velocity: S) -> Stage<S> {
        let scene = self.scene;
        let mut state = start.state;
        state[POSITION] += displacement;
        let at = scene.electrics(self.mode, &state);
        let mut own =
            Point { state: [S::ZERO; 3], remainder: [S::ZERO; 3], derivative: [S::ZERO; 3], powers: [] };
        own.state = [start.state[POSITION], start.state[VELOCITY], at.charge];
        let flow = scene.harvester.flow(self.mode.inner);
        let open = System::<S, 3, 0>::stage(&flow, &own, displacement, velocity);
        if !R::CHARGES {
            return Stage { circuit: None, ..open };
        }
        let [constant, linear, quadratic] = open.force;
        let charge_by_base = -self.mode.regime.sign::<S>() * at.charge_by_voltage;
        let force = [constant, linear * charge_by_base, quadratic * charge_by_base * charge_by_base];
        let stiffness = scene.fall_by_voltage(self.mode, &at) * at.share;
        let circuit = CircuitEquation { inertia: S::ONE, stiffness, drive: -at.fall };
        Stage { circuit: Some(circuit), force }
    }

    const LINEAR: bool = R::LINEAR;

    /// The storage voltage is linear in `B` at a place. It is not computed again at the end of the change: where the storage
    /// is smaller than the harvester's capacitance, roundings of the terminal voltage would be larger than the defect. The
    /// leakage alone is linear.
    #[inline]
    fn circuit_defect(&self, start: &Point<S, STATES, POWERS>, displacement: S, change: S) -> S {
        let scene = self.scene;
        if !self.mode.connected {
            return S::ZERO;
        }
        let mut state = start.state;
        state[POSITION] += displacement;
        let at = scene.electrics(self.mode, &state);
        let rise = at.share * change;
        let slope = scene.fall_by_voltage(self.mode, &at);
        at.fall + slope * rise - scene.fall(self.mode, at.storage_voltage + rise)
    }

    /// That of the harvester.
    #[inline]
    fn time_scale_ratio(&self, start: &[S; STATES], end: &[S; STATES]) -> S {
        let flow = self.scene.harvester.flow(self.mode.inner);
        let [start, end] = [start, end].map(|state| [state[POSITION], state[VELOCITY], state[super::CHARGE]]);
        System::<S, 3, 0>::time_scale_ratio(&flow, &start, &end)
    }

    /// The harvester's own norm; the storage voltage relative to the threshold.
    #[inline]
    fn error_norm(&self, state: &[S; STATES], change: &[S; STATES]) -> S {
        let [position, velocity, charge, storage] = *change;
        let own = [state[POSITION], state[VELOCITY], state[super::CHARGE]];
        let flow = self.scene.harvester.flow(self.mode.inner);
        let size = System::<S, 3, 0>::error_norm(&flow, &own, &[position, velocity, charge]);
        if !R::CHARGES {
            return size;
        }
        let threshold = self.scene.bridge.threshold(state[STORAGE]).max(self.scene.voltage_floor);
        // The reciprocal is the same for every change in a step.
        let per_threshold = S::ONE / threshold;
        size.max(storage.abs() * per_threshold)
    }
}

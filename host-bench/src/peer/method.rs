//! One step of each method.

use super::system::{BaseAcceleration, State, System};

pub(super) trait Stepper {
    /// Moves the state on by `step` seconds from `time`.
    fn step(&mut self, state: &mut State, base: &mut BaseAcceleration<'_>, time: f64, step: f64);
}

pub(super) struct RungeKutta4<'a> {
    system: &'a System,
    rate: State,
    sum: State,
    stage: State,
}

impl<'a> RungeKutta4<'a> {
    pub(super) fn new(system: &'a System) -> Self {
        let zero = State::zero(system.modes.len());
        Self { system, rate: zero.clone(), sum: zero.clone(), stage: zero }
    }
}

/// `to = from + factor rate`.
fn move_along(to: &mut State, from: &State, factor: f64, rate: &State) {
    for ((to, from), rate) in to.motion.iter_mut().zip(&from.motion).zip(&rate.motion) {
        *to = [from[0] + factor * rate[0], from[1] + factor * rate[1]];
    }
    to.voltage = from.voltage + factor * rate.voltage;
}

/// `to += factor rate`.
fn add(to: &mut State, factor: f64, rate: &State) {
    for (to, rate) in to.motion.iter_mut().zip(&rate.motion) {
        to[0] += factor * rate[0];
        to[1] += factor * rate[1];
    }
    to.voltage += factor * rate.voltage;
}

impl Stepper for RungeKutta4<'_> {
    fn step(&mut self, state: &mut State, base: &mut BaseAcceleration<'_>, time: f64, step: f64) {
        let half = 0.5 * step;
        let [first, middle, last] = [0.0, half, step].map(|later| base.at(time + later));
        self.system.rate(state, first, &mut self.rate);
        self.sum.copy_from(state);
        for (acceleration, weight, reach) in
            [(middle, step / 6.0, half), (middle, step / 3.0, half), (last, step / 3.0, step)]
        {
            add(&mut self.sum, weight, &self.rate);
            move_along(&mut self.stage, state, reach, &self.rate);
            self.system.rate(&self.stage, acceleration, &mut self.rate);
        }
        add(&mut self.sum, step / 6.0, &self.rate);
        state.copy_from(&self.sum);
    }
}

/// Coefficients of an implicit stage `x = known + d f(t, x)`, which is solved in closed form.
///
/// Each mode, and the circuit, is a linear equation coupled to the others by force and voltage only. Elimination leaves
/// `g = g₀ − H F` with `F = k max(0, g)`, whose only solution is `F = k max(0, g₀) / (1 + k H)`.
struct Stage {
    /// `d`: the method's coefficient times the step, in s.
    reach: f64,
    /// `1 / (1 + 2ζω d + ω² d²)` of each mode.
    shares: Vec<f64>,
    /// One over the effective capacitance in 1/F of the circuit's equation; 0 behind a short circuit.
    elastance: f64,
    /// `d² Σ θ l / (1 + 2ζω d + ω² d²)`: change of the gap in m for one volt.
    mixed: f64,
    /// `v = v₀ − v₁ F`: `v₁`.
    voltage_by_force: f64,
    /// `k / (1 + k H)`.
    stiffness: f64,
}

impl Stage {
    fn new(system: &System, reach: f64) -> Self {
        let shares: Vec<f64> = system
            .modes
            .iter()
            .map(|mode| (1.0 + reach * (mode.damping + reach * mode.stiffness)).recip())
            .collect();
        // d² Σ θ² …, d² Σ θ l … and d² Σ l² … over 1 + 2ζω d + ω² d².
        let [mut electric, mut mixed, mut mechanical] = [0.0; 3];
        for (mode, share) in system.modes.iter().zip(&shares) {
            electric += reach * reach * share * mode.coupling * mode.coupling;
            mixed += reach * reach * share * mode.coupling * mode.lever;
            mechanical += reach * reach * share * mode.lever * mode.lever;
        }
        let elastance = if system.is_short {
            0.0
        } else {
            (system.capacitance + reach * system.conductance + system.back_coupling * electric).recip()
        };
        let voltage_by_force = elastance * mixed;
        let compliance_left = mechanical - system.back_coupling * mixed * voltage_by_force;
        let stiffness = system.stiffness / (1.0 + system.stiffness * compliance_left);
        Self { reach, shares, elastance, mixed, voltage_by_force, stiffness }
    }

    /// Solves for the stage: `state` is `known` on entry and the stage on return.
    fn solve(&self, system: &System, acceleration: f64, state: &mut State) {
        let reach = self.reach;
        let [mut current, mut levers] = [0.0; 2];
        for ((mode, share), [at, rate]) in system.modes.iter().zip(&self.shares).zip(&mut state.motion) {
            *rate = share * (*rate - reach * (mode.stiffness * *at + mode.base * acceleration));
            *at += reach * *rate;
            current += mode.coupling * *rate;
            levers += mode.lever * *at;
        }
        let free_voltage = self.elastance * (system.capacitance * state.voltage + reach * current);
        let back = system.back_coupling;
        let penetration = levers - back * self.mixed * free_voltage - system.gap;
        let force = self.stiffness * penetration.max(0.0);
        state.voltage = free_voltage - self.voltage_by_force * force;
        let back = back * state.voltage;
        for ((mode, share), [at, rate]) in system.modes.iter().zip(&self.shares).zip(&mut state.motion) {
            let kick = reach * share * (mode.lever * force + mode.coupling * back);
            *rate -= kick;
            *at -= reach * kick;
        }
    }
}

/// Place of the first stage of TR-BDF2 within the step, `2 − √2`: both stages then have the same coefficient.
const FIRST_STAGE: f64 = 2.0 - std::f64::consts::SQRT_2;

/// Newmark's method of average acceleration (`β = ¼`, `γ = ½`, the circuit by the trapezoidal rule), and
/// TR-BDF2 of Bank and others, whose first stage is such a step of `2 − √2` of the whole.
pub(super) struct Implicit<'a> {
    system: &'a System,
    stage: Stage,
    /// Whether a second stage follows, by the backward differentiation formula.
    is_tr_bdf2: bool,
    rate: State,
    start: State,
}

impl<'a> Implicit<'a> {
    pub(super) fn newmark(system: &'a System, step: f64) -> Self {
        Self::new(system, 0.5 * step, false)
    }

    pub(super) fn tr_bdf2(system: &'a System, step: f64) -> Self {
        Self::new(system, 0.5 * FIRST_STAGE * step, true)
    }

    fn new(system: &'a System, reach: f64, is_tr_bdf2: bool) -> Self {
        let zero = State::zero(system.modes.len());
        Self { system, stage: Stage::new(system, reach), is_tr_bdf2, rate: zero.clone(), start: zero }
    }
}

impl Stepper for Implicit<'_> {
    fn step(&mut self, state: &mut State, base: &mut BaseAcceleration<'_>, time: f64, step: f64) {
        self.start.copy_from(state);
        self.system.rate(&self.start, base.at(time), &mut self.rate);
        move_along(state, &self.start, self.stage.reach, &self.rate);
        if !self.is_tr_bdf2 {
            self.stage.solve(self.system, base.at(time + step), state);
            return;
        }
        self.stage.solve(self.system, base.at(time + FIRST_STAGE * step), state);
        // y = y₁ / (γ (2 − γ)) − y₀ (1 − γ)² / (γ (2 − γ)) + d f(y); the two weights differ by one.
        let older = (1.0 - FIRST_STAGE).powi(2) / (FIRST_STAGE * (2.0 - FIRST_STAGE));
        let extrapolated = |middle: f64, start: f64| middle + older * (middle - start);
        for (middle, start) in state.motion.iter_mut().zip(&self.start.motion) {
            *middle = [extrapolated(middle[0], start[0]), extrapolated(middle[1], start[1])];
        }
        state.voltage = extrapolated(state.voltage, self.start.voltage);
        self.stage.solve(self.system, base.at(time + step), state);
    }
}

//! What a peer integrates: the equations of a harvester with its load, and where they change.

pub(crate) mod bump_stop;
pub(crate) mod contact_separation;
pub(crate) mod sliding;

use std::cell::Cell;

use super::Stop;

pub(crate) const VACUUM_PERMITTIVITY: f64 = 8.854_187_812_8e-12;

/// Most guards that a mode has.
pub(crate) const GUARDS: usize = 5;

/// A guard that a mode does not have.
pub(crate) const NEVER: f64 = f64::INFINITY;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Base {
    /// Amplitude in m/s².
    pub(crate) amplitude: f64,
    /// Angular frequency in rad/s.
    pub(crate) angular_frequency: f64,
    /// Phase in rad.
    pub(crate) phase: f64,
}

impl Base {
    /// Acceleration in m/s² at a time in s.
    pub(crate) fn at(&self, time: f64) -> f64 {
        self.amplitude * (self.angular_frequency * time + self.phase).sin()
    }
}

/// The mode of motion and circuit, on which the equations are smooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mode<B> {
    /// The branch of the equations of motion.
    pub(crate) branch: B,
    /// Whether mass or slider sticks.
    pub(crate) stuck: bool,
    /// Sign of the terminal voltage while a bridge conducts; 0 while it blocks.
    pub(crate) sign: f64,
    /// Whether the draw of a storage is connected.
    pub(crate) connected: bool,
}

/// A harvester with its load, with `N` states; the last one is the energy delivered to the load in J.
pub(crate) trait Harvester<const N: usize> {
    /// Branch of the equations of motion.
    type Branch: Copy;

    fn base(&self) -> &Base;

    /// Mode and state at time zero.
    fn start(&self) -> (Mode<Self::Branch>, [f64; N]);

    /// Number of the states of the motion, the first ones; then come the voltages.
    fn motion_states(&self) -> usize;

    /// Sizes of the states, for absolute tolerances.
    fn sizes(&self) -> [f64; N];

    fn rates(&self, mode: &Mode<Self::Branch>, time: f64, state: &[f64; N]) -> [f64; N];

    /// Derivative of [`Self::rates`] in the direction of `change`.
    fn rates_along(
        &self,
        mode: &Mode<Self::Branch>,
        time: f64,
        state: &[f64; N],
        change: &[f64; N],
    ) -> [f64; N];

    /// Quantities that are above zero in this mode; an event is where one of them is no longer.
    fn guards(&self, mode: &Mode<Self::Branch>, state: &[f64; N]) -> [f64; GUARDS];

    fn jump(&self, guard: usize, time: f64, mode: &mut Mode<Self::Branch>, state: &mut [f64; N]);

    /// Force in N that is left before a stick ends.
    fn reserve(&self, mode: &Mode<Self::Branch>, time: f64, state: &[f64; N]) -> f64;

    fn release(&self, mode: &mut Mode<Self::Branch>, time: f64, state: &[f64; N]);

    /// The state after a stick of so many seconds.
    fn stand(&self, state: &mut [f64; N], elapsed: f64);

    /// Refuses a state out of the range of the model.
    fn check(&self, state: &[f64; N]) -> Result<(), Stop>;
}

/// A harvester and its present mode, shared by the march and the equations that the integrator evaluates.
pub(crate) struct System<H: Harvester<N>, const N: usize> {
    pub(crate) harvester: H,
    pub(crate) mode: Cell<Mode<H::Branch>>,
}

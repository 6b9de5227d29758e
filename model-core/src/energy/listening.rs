//! When to listen to the vibration again, and how uncertain the income is in between.
//!
//! A listen measures the mean power `P` of a short burst of samples. Between listens the income is interpolated. With
//! the mean squares `D₁²` and `D₂²` of the differences of listens one and two intervals `T` apart, a process of
//! variance `σ²` and correlation `r = e^(−T/τ)` from listen to listen has
//!
//! ```text
//! D₁² = 2σ²(1 − r),   D₂² = 2σ²(1 − r²),   r = D₂²/D₁² − 1,   q = (1 − r)/(1 + r) = tanh(T/2τ).
//! ```
//!
//! The trapezoidal sum of such listens has an error whose variance grows in the time `H` by
//! `σ² T H (coth(T/2τ) − 2τ/T)`: the variance of the sum, `σ² T H coth(T/2τ)`, plus that of the integral, `2σ² τ H`,
//! less twice their covariance, `2σ² τ H`. For `T ≪ τ` this is `σ² T² H/(6τ)`, for `T ≫ τ` `σ² T H`. In terms of `q`
//! it is `D₁² T H (1 + q)/4 · h(q)` with `h = 1/q² − 1/(q artanh q)`, from 1/3 to 1.
//!
//! An interval is a power of two of the shortest one, so that a change of it changes `D₁²`, `D₂²` and `r` in closed form.

use crate::bounds::{Bounds, ParameterError, bounded};
use crate::scalar::Scalar;
use crate::snapshot::{Configuration, Fingerprint, snapshot_fields};

/// Parameters of a [`Listening`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ListeningParameters<S> {
    /// Part of the mean income that listens may cost, 10⁻⁵ to 1: energy at the load over harvested energy. Of what the
    /// storage gives to the load it is this part over both efficiencies of the storage.
    pub share: S,
    /// Relative error of the income over `horizon` to aim at within that cost, one standard deviation, 10⁻⁴ to 1.
    pub error: S,
    /// Time in s over which the error of the income counts, 1 to 10⁹.
    pub horizon: S,
    /// Shortest time between listens in s, 1 to 86 400.
    pub shortest: u32,
    /// Number of doublings from the shortest to the longest time, 0 to 12.
    pub doublings: u32,
}

/// Schedules listens by their cost, by the correlation of the income and by surprises of the storage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Listening<S> {
    parameters: ListeningParameters<S>,
}

/// The state of a [`Listening`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ListeningState<S> {
    /// The last power in W and the one before it; negative where there was no listen.
    last: [S; 2],
    /// Weighted mean of the power in W.
    mean: S,
    /// Mean squares in W² of differences one and two intervals apart.
    differences: [S; 2],
    /// Energy in J saved for listens that a surprise calls for, less than two of them.
    saved: S,
    /// Energy of the last listen in J.
    cost: S,
    /// The interval is the shortest one doubled so many times.
    level: u32,
    /// Number of listens, up to [`MEMORY`].
    listens: u32,
}

/// Energy of the income with its standard deviation, in J.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heard<S> {
    /// The energy.
    pub energy: S,
    /// Standard deviation of its error.
    pub deviation: S,
}

bounded! { ListeningParameters<S>:
    "share" = share: 1e-5, 1.0;
    "error" = error: 1e-4, 1.0;
    "horizon" = horizon: 1.0, 1e9;
}

/// Listens over which squared differences and the mean are averaged.
const MEMORY: u32 = 16;
/// Departure of the storage, in its standard deviations, that calls for a listen.
const SURPRISE: f64 = 3.0;
/// Listens for which energy is saved.
const SAVED: f64 = 2.0;
/// Largest power in W and energy in J that is accepted: squares stay finite in `f32`.
const LARGEST: f64 = 1e9;

impl<S: Scalar> ListeningParameters<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first field outside its bounds.
    pub fn build(self) -> Result<Listening<S>, ParameterError<S>> {
        self.check_numbers()?;
        Bounds::new(1.0, 86_400.0).check("shortest", S::from_u32(self.shortest))?;
        Bounds::new(0.0, 12.0).check("doublings", S::from_u32(self.doublings))?;
        Ok(Listening { parameters: self })
    }
}

impl<S: Scalar> ListeningState<S> {
    /// Mean power in W over the last listens; 0 before the first.
    #[must_use]
    pub fn mean_power(&self) -> S {
        self.mean
    }

    /// Mean squares in W² of differences of listens one and two intervals apart; `None` before the third listen.
    #[must_use]
    pub fn differences(&self) -> Option<[S; 2]> {
        (self.listens > 2).then_some(self.differences)
    }

    /// Variance in W² of what changes from listen to listen and does not last: `D₁² − D₂²/2`; 0 before the third listen.
    #[must_use]
    pub fn fluctuation(&self) -> S {
        let [one, two] = self.differences;
        if self.listens > 2 { (one - S::from_f64(0.5) * two).max(S::ZERO) } else { S::ZERO }
    }

    /// Correlation of the income from one listen to the next, 0 to 1.
    #[must_use]
    pub fn correlation(&self) -> S {
        let [one, two] = self.differences;
        if one > S::ZERO && self.listens > 2 {
            (two / one - S::ONE).max(S::ZERO).min(S::ONE)
        } else {
            S::ZERO
        }
    }

    /// `D₁² (1 + q)/4 · h(q)` in W²: the variance of an interval's mean power.
    fn variance(&self) -> S {
        let r = self.correlation();
        let q = (S::ONE - r) / (S::ONE + r);
        let number = S::from_f64;
        let square = q * q;
        let fourth = square * square;
        let sixteenth = (fourth * fourth) * (fourth * fourth);
        // The series of h up to the fourth power, and a term that ends at h(1) = 1: 1 % too small to 45 % too large.
        let series = number(1.0 / 3.0) + square * (number(4.0 / 45.0) + square * number(44.0 / 945.0));
        let h = series + sixteenth * number(1.0 - 1.0 / 3.0 - 4.0 / 45.0 - 44.0 / 945.0);
        number(0.25) * (S::ONE + q) * h * self.differences[0]
    }

    /// Doubles the interval.
    fn lengthen(&mut self) {
        let r = self.correlation();
        let [_, two] = self.differences;
        self.differences = [two, two * (S::ONE + r * r)];
        self.level += 1;
    }

    /// Halves the interval.
    fn shorten(&mut self) {
        let r = self.correlation().sqrt();
        let one = self.differences[0] / (S::ONE + r);
        self.differences = [one, one * (S::ONE + r)];
        self.level = self.level.saturating_sub(1);
    }

    /// Takes `value` into a mean of `count` values with it.
    fn average(mean: &mut S, value: S, count: u32) {
        *mean += (value - *mean) / S::from_u32(count.max(1));
    }
}

impl<S: Scalar> Listening<S> {
    /// The state before any listen: the first one is due at once.
    #[must_use]
    pub fn start(&self) -> ListeningState<S> {
        ListeningState {
            last: [-S::ONE; 2],
            mean: S::ZERO,
            differences: [S::ZERO; 2],
            saved: S::ZERO,
            cost: S::ZERO,
            level: 0,
            listens: 0,
        }
    }

    /// Time between listens in s.
    #[must_use]
    pub fn interval(&self, state: &ListeningState<S>) -> u32 {
        self.parameters.shortest << state.level
    }

    /// Whether to listen now, `elapsed` s after the last listen. `departure` is the distance of the storage from its
    /// expected energy in standard deviations, 0 where it is unknown.
    ///
    /// Before the interval ends only a departure of at least 3 calls for a listen, if `share` of the income since has
    /// saved its cost: at most two such listens in succession.
    #[must_use]
    pub fn is_due(&self, state: &ListeningState<S>, elapsed: u32, departure: S) -> bool {
        let regular = state.listens == 0 || elapsed >= self.interval(state);
        regular || self.is_surprise(state, elapsed, departure)
    }

    /// Whether the departure of the storage calls for a listen before the interval ends.
    pub(crate) fn is_surprise(&self, state: &ListeningState<S>, elapsed: u32, departure: S) -> bool {
        departure >= S::from_f64(SURPRISE)
            && elapsed >= self.parameters.shortest
            && self.saved(state, elapsed) >= state.cost
    }

    /// Takes in a listen of `power` in W with a standard deviation `deviation` in W at a cost of `cost` in J,
    /// `elapsed` s after the last one. Returns the income of the time between, by interpolation; nothing for the
    /// first listen.
    ///
    /// Errors of listens are taken as independent of one another: a common one, such as that of a map of another harvester, is
    /// not in the deviation of many listens.
    ///
    /// A number that is negative, not finite, or above 10⁹ is refused: the listen is then not counted.
    #[inline(never)]
    pub fn hear(
        &self,
        state: &mut ListeningState<S>,
        elapsed: u32,
        power: S,
        deviation: S,
        cost: S,
    ) -> Option<Heard<S>> {
        let largest = S::from_f64(LARGEST);
        if [power, deviation, cost].iter().any(|&number| !(number >= S::ZERO && number <= largest)) {
            return None;
        }
        state.saved = self.saved(state, elapsed) - cost;
        state.cost = cost;
        let [last, before] = state.last;
        state.last = [power, last];
        state.listens = (state.listens + 1).min(MEMORY);
        ListeningState::average(&mut state.mean, power, state.listens);
        if last < S::ZERO {
            // Nothing is known of the spread: all of the power may go.
            state.differences = [power * power; 2];
            return None;
        }
        let time = S::from_u32(elapsed);
        // Of a late listen the difference over its own time: smaller ones would take the income for steadier than it is.
        let one = (power - last) * (power - last);
        ListeningState::average(&mut state.differences[0], one, state.listens.saturating_sub(1));
        if before >= S::ZERO {
            let two = (power - before) * (power - before);
            ListeningState::average(&mut state.differences[1], two, state.listens.saturating_sub(2));
        } else {
            state.differences[1] = state.differences[0];
        }
        // A single jump at an unknown time in the interval has the variance (P₂ − P₁)²/12.
        let jump = (power - last) * (power - last) * S::from_f64(1.0 / 12.0);
        let spread = state.variance().max(jump) + deviation * deviation;
        let heard =
            Heard { energy: S::from_f64(0.5) * (power + last) * time, deviation: spread.sqrt() * time };
        self.choose(state);
        Some(heard)
    }

    /// Books the cost of a listen that gave no power, `elapsed` s after the last one. A cost that is negative, not finite,
    /// or above 10⁹ J is refused.
    pub fn miss(&self, state: &mut ListeningState<S>, elapsed: u32, cost: S) {
        if cost >= S::ZERO && cost <= S::from_f64(LARGEST) {
            let saved = self.saved(state, elapsed);
            state.cost = cost;
            state.saved = saved - cost;
        }
    }

    /// Chooses the next interval: the longest that holds the error, but not shorter than the cost allows.
    fn choose(&self, state: &mut ListeningState<S>) {
        let error = self.parameters.error;
        while state.level > 0 && self.error(state) > error && self.share(state, state.level - 1) {
            state.shorten();
        }
        let mut longer = *state;
        while longer.level < self.parameters.doublings {
            longer.lengthen();
            // Well below the error, so that the interval does not go back and forth.
            let holds = self.error(&longer) <= S::from_f64(0.7) * error;
            if !holds && self.share(state, state.level) {
                break;
            }
            *state = longer;
        }
    }

    /// Relative error of the income over the horizon at the present interval, one standard deviation; infinite without
    /// income.
    #[must_use]
    pub fn error(&self, state: &ListeningState<S>) -> S {
        if !(state.mean > S::ZERO) {
            return S::INFINITY;
        }
        let part = (S::from_u32(self.interval(state)) / self.parameters.horizon).min(S::ONE);
        (state.variance() * part).sqrt() / state.mean
    }

    /// Whether regular listens at an interval of that level cost at most the part of the mean income that is meant for
    /// them.
    fn share(&self, state: &ListeningState<S>, level: u32) -> bool {
        let interval = S::from_u32(self.parameters.shortest << level);
        state.cost <= self.parameters.share * state.mean * interval
    }

    /// Energy in J that is saved for surprises, `elapsed` s after the last listen.
    fn saved(&self, state: &ListeningState<S>, elapsed: u32) -> S {
        let longest = S::from_u32(self.parameters.shortest << self.parameters.doublings);
        // Without income, one listen in the longest interval.
        let power = (self.parameters.share * state.mean).max(state.cost / longest);
        let grown = state.saved + power * S::from_u32(elapsed);
        grown.min(S::from_f64(SAVED) * state.cost).max(-state.cost)
    }
}

snapshot_fields!(impl [S: Scalar] ListeningState<S> {
    last, mean, differences, saved, cost, level, listens,
} if |state| {
    let largest = S::from_f64(LARGEST);
    let powers = state.last.iter().all(|&power| power.abs() <= largest);
    let sums = [state.mean, state.cost].iter().all(|&sum| sum >= S::ZERO && sum <= largest);
    let squares = state.differences.iter().all(|&square| square >= S::ZERO && square <= largest * largest * S::from_f64(1e4));
    powers && sums && squares && state.saved.abs() <= S::from_f64(SAVED) * largest && state.level <= 12 && state.listens <= MEMORY
});

impl<S: Scalar> Configuration for Listening<S> {
    type State = ListeningState<S>;

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("listening");
        fingerprint.numbers(&[self.parameters.share, self.parameters.error, self.parameters.horizon]);
        fingerprint.numbers(&[self.parameters.shortest, self.parameters.doublings]);
    }
}

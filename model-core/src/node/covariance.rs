//! Covariances of the states of the filter: the upper triangle of a symmetric matrix, changed by what is not zero.
//!
//! An interval changes the stored energy and both incomes only, by the power and the draw, so that it costs a few
//! multiplications for each covariance in place of two products of matrices. A measurement removes `r k kᵀ`. Rounding may
//! leave a correlation beyond 1 by a rounding or so; [`Covariance::limit_correlations`] mends it.

use crate::scalar::Scalar;
use crate::snapshot::snapshot_fields;

/// Number of states.
pub(super) const STATES: usize = 6;
/// Stored energy in J.
pub(super) const STORE: usize = 0;
/// Harvested power in W.
pub(super) const POWER: usize = 1;
/// Gain of the modelled power.
pub(super) const GAIN: usize = 2;
/// Standing power above the stated one in W.
pub(super) const DRAW: usize = 3;
/// Income since the start of the hour in J.
pub(super) const HOUR: usize = 4;
/// Income since the start in J.
pub(super) const ALL: usize = 5;

/// Roundings of a variance that remain at least after a measurement.
const LEAST_LEFT: f64 = 8.0;

/// Largest variance, in squares of SI units.
const MOST: f64 = 1e14;

/// The covariances, each state with itself and those after it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Covariance<S> {
    store: [S; 6],
    power: [S; 5],
    gain: [S; 4],
    draw: [S; 3],
    hour: [S; 2],
    all: S,
}

/// How an interval moves the states: `E ← kept E + of_power P − of_draw d`, and both incomes by `time P`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Flow<S> {
    pub(super) time: S,
    pub(super) kept: S,
    pub(super) of_power: S,
    pub(super) of_draw: S,
}

/// What becomes of an income over an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Storing<S> {
    /// Part of an even income that is stored at the end.
    pub(super) stored: S,
    /// Variance of that part by the time at which the income came, even in the interval: what comes first leaks for longest.
    pub(super) uneven: S,
}

impl<S: Scalar> Storing<S> {
    /// No income is stored.
    pub(super) const NOTHING: Self = Self { stored: S::ZERO, uneven: S::ZERO };
}

impl<S: Scalar> Covariance<S> {
    /// Without correlations, of the variances of energy, power, gain and draw, before any income.
    pub(super) fn new([store, power, gain, draw]: [S; 4]) -> Self {
        let o = S::ZERO;
        Self {
            store: [store, o, o, o, o, o],
            power: [power, o, o, o, o],
            gain: [gain, o, o, o],
            draw: [draw, o, o],
            hour: [o; 2],
            all: o,
        }
    }

    /// The variance of a state.
    #[inline(always)]
    pub(super) fn variance(&self, index: usize) -> S {
        match index {
            STORE => self.store[0],
            POWER => self.power[0],
            GAIN => self.gain[0],
            DRAW => self.draw[0],
            HOUR => self.hour[0],
            _ => self.all,
        }
    }

    #[inline(always)]
    fn variance_mut(&mut self, index: usize) -> &mut S {
        match index {
            STORE => &mut self.store[0],
            POWER => &mut self.power[0],
            GAIN => &mut self.gain[0],
            DRAW => &mut self.draw[0],
            HOUR => &mut self.hour[0],
            _ => &mut self.all,
        }
    }

    /// The covariances of a state with all.
    #[inline(always)]
    pub(super) fn row(&self, index: usize) -> [S; STATES] {
        let Self { store: e, power: p, gain: g, draw: d, hour: h, all } = *self;
        match index {
            STORE => e,
            POWER => [e[1], p[0], p[1], p[2], p[3], p[4]],
            GAIN => [e[2], p[1], g[0], g[1], g[2], g[3]],
            DRAW => [e[3], p[2], g[1], d[0], d[1], d[2]],
            HOUR => [e[4], p[3], g[2], d[1], h[0], h[1]],
            _ => [e[5], p[4], g[3], d[2], h[1], all],
        }
    }

    /// Adds to a variance.
    #[inline(always)]
    pub(super) fn widen(&mut self, index: usize, variance: S) {
        *self.variance_mut(index) += variance;
    }

    /// Adds to a variance, up to `most`.
    #[inline(always)]
    pub(super) fn widen_to(&mut self, index: usize, variance: S, most: S) {
        let of = self.variance_mut(index);
        *of = (*of + variance).min(most);
    }

    /// Raises a variance to at least `least`.
    #[inline(always)]
    pub(super) fn raise(&mut self, index: usize, least: S) {
        let of = self.variance_mut(index);
        *of = of.max(least);
    }

    /// Sets the variance of the energy or of the income of the hour, and the covariances of that state to 0.
    pub(super) fn clear(&mut self, index: usize, variance: S) {
        if index == STORE {
            self.store = [S::ZERO; 6];
        } else {
            self.store[4] = S::ZERO;
            self.power[3] = S::ZERO;
            self.gain[2] = S::ZERO;
            self.draw[1] = S::ZERO;
            self.hour = [S::ZERO; 2];
        }
        *self.variance_mut(index) = variance;
    }

    /// Advances over an interval without a walk of the power.
    pub(super) fn advance(&mut self, Flow { time, kept, of_power, of_draw }: Flow<S>) {
        let Self { store: e, power: p, gain: g, draw: d, hour: h, all } = self;
        // Covariances of what moves the energy: with the state before it, and with those that do not move.
        let moved = |energy: S, power: S, draw: S| kept * energy + of_power * power - of_draw * draw;
        let [with_power, with_gain, with_draw] =
            [moved(e[1], p[0], p[2]), moved(e[2], p[1], g[1]), moved(e[3], p[2], d[0])];
        let with_store = moved(e[0], e[1], e[3]);
        let of_income = time * with_power;
        e[0] = moved(with_store, with_power, with_draw);
        e[4] = moved(e[4], p[3], d[1]) + of_income;
        e[5] = moved(e[5], p[4], d[2]) + of_income;
        (e[1], e[2], e[3]) = (with_power, with_gain, with_draw);

        let (hour, all_before) = (p[3], p[4]);
        let [by_power, by_gain, by_draw] = [p[0], p[1], p[2]].map(|with_power| time * with_power);
        (p[3], p[4]) = (hour + by_power, all_before + by_power);
        (g[2], g[3]) = (g[2] + by_gain, g[3] + by_gain);
        (d[1], d[2]) = (d[1] + by_draw, d[2] + by_draw);
        h[0] += time * (hour + p[3]);
        h[1] += time * (hour + p[4]);
        *all += time * (all_before + p[4]);
    }

    /// Adds a walk of the power of variance `walk` in a second over `time` in s.
    ///
    /// Of an income that came early or late another part is stored. The same energy then tells another income, so that the incomes
    /// are uncertain by it and the energy is not.
    pub(super) fn walk(&mut self, time: S, walk: S, Storing { stored, uneven }: Storing<S>) {
        let power = walk * time;
        let both = S::from_f64(0.5) * power * time;
        let income = S::from_f64(2.0 / 3.0) * both * time;
        let in_store = stored * income;
        let told = income + uneven * income;
        self.power[0] += power;
        self.power[3] += both;
        self.power[4] += both;
        self.hour[0] += told;
        self.hour[1] += told;
        self.all += told;
        self.store[1] += stored * both;
        self.store[4] += in_store;
        self.store[5] += in_store;
        self.store[0] += stored * in_store;
    }

    /// Adds variances in J²: to the income of the hour, to its covariance with the whole income, and to the whole income.
    pub(super) fn widen_income(&mut self, [hour, both, all]: [S; 3], stored: S) {
        self.hour[0] += hour;
        self.hour[1] += both;
        self.all += all;
        self.store[4] += stored * both;
        self.store[5] += stored * all;
        self.store[0] += stored * stored * all;
    }

    /// Removes what a measurement tells: `along` are the covariances with the measured quantity, `removed` one over its
    /// variance.
    pub(super) fn remove(&mut self, along: [S; STATES], removed: S) {
        let part = along.map(|along| along * removed);
        take(&mut self.store, part[0], along);
        let [_, along @ ..] = along;
        take(&mut self.power, part[1], along);
        let [_, along @ ..] = along;
        take(&mut self.gain, part[2], along);
        let [_, along @ ..] = along;
        take(&mut self.draw, part[3], along);
        let [_, along @ ..] = along;
        take(&mut self.hour, part[4], along);
        let mut all = [self.all];
        take(&mut all, part[5], [along[1]]);
        [self.all] = all;
    }

    /// Adds `along` times the gain to the states.
    pub(super) fn add_gain(&mut self, along: [S; STATES]) {
        let half = S::from_f64(0.5) * self.variance(GAIN);
        let mut other = self.row(GAIN);
        for (other, along) in other.iter_mut().zip(along) {
            *other += half * along;
        }
        let [of_store, of_power, of_gain, of_draw, of_hour, of_all] = along;
        let [with_store, with_power, with_gain, with_draw, with_hour, with_all] = other;
        add_product(&mut self.store, [of_store, with_store], along, other);
        let ([_, along @ ..], [_, other @ ..]) = (along, other);
        add_product(&mut self.power, [of_power, with_power], along, other);
        let ([_, along @ ..], [_, other @ ..]) = (along, other);
        add_product(&mut self.gain, [of_gain, with_gain], along, other);
        let ([_, along @ ..], [_, other @ ..]) = (along, other);
        add_product(&mut self.draw, [of_draw, with_draw], along, other);
        let ([_, along @ ..], [_, other @ ..]) = (along, other);
        add_product(&mut self.hour, [of_hour, with_hour], along, other);
        self.all += S::from_f64(2.0) * of_all * with_all;
    }

    /// Limits correlations to 1. A square root for each beyond.
    pub(super) fn limit_correlations(&mut self) {
        let variances = [0, 1, 2, 3, 4, 5].map(|index| self.variance(index));
        limit(&mut self.store, variances);
        let [_, variances @ ..] = variances;
        limit(&mut self.power, variances);
        let [_, variances @ ..] = variances;
        limit(&mut self.gain, variances);
        let [_, variances @ ..] = variances;
        limit(&mut self.draw, variances);
        let [_, variances @ ..] = variances;
        limit(&mut self.hour, variances);
    }

    /// Scales each state whose variance is above [`MOST`] to that variance, with its covariances: nothing is known of it, and
    /// an image takes no number that is much larger.
    #[inline(never)]
    pub(super) fn limit_variances(&mut self) {
        let most = S::from_f64(MOST);
        for index in 0..STATES {
            if self.variance(index) > most {
                self.scale(index, (most / self.variance(index)).sqrt());
            }
        }
    }

    /// Multiplies a state by a factor.
    #[cold]
    #[inline(never)]
    fn scale(&mut self, index: usize, factor: S) {
        let Self { store, power, gain, draw, hour, all } = self;
        let rows: [&mut [S]; STATES] = [store, power, gain, draw, hour, core::slice::from_mut(all)];
        for (row, entries) in rows.into_iter().enumerate() {
            for (column, entry) in entries.iter_mut().enumerate() {
                for of in [row, row + column] {
                    *entry = if of == index { *entry * factor } else { *entry };
                }
            }
        }
    }

    /// Whether all variances are 0 or more.
    fn is_sound(&self) -> bool {
        (0..STATES).all(|index| self.variance(index) >= S::ZERO)
    }
}

/// Takes `part · along` from a row that begins with its variance.
fn take<S: Scalar, const N: usize>(row: &mut [S; N], part: S, along: [S; N]) {
    let before = row.first().copied().unwrap_or(S::ZERO);
    for (entry, along) in row.iter_mut().zip(along) {
        *entry -= part * along;
    }
    if let Some(variance) = row.first_mut()
        && !(*variance > S::ZERO)
    {
        *variance = before * (S::from_f64(LEAST_LEFT) * S::EPSILON);
    }
}

/// Adds the products of two vectors, made symmetric, to a row that begins with their `first` elements.
fn add_product<S: Scalar, const N: usize>(row: &mut [S; N], first: [S; 2], one: [S; N], other: [S; N]) {
    let [first_of_one, first_of_other] = first;
    for (entry, (one, other)) in row.iter_mut().zip(one.into_iter().zip(other)) {
        *entry += first_of_one * other + first_of_other * one;
    }
}

/// Limits a row that begins with its variance to the roots of the products of both variances.
fn limit<S: Scalar, const N: usize>(row: &mut [S; N], variances: [S; N]) {
    let own = variances.first().copied().unwrap_or(S::ZERO);
    for (entry, variance) in row.iter_mut().zip(variances).skip(1) {
        // The roots, as the product of two variances may be too small for a number.
        if entry.abs() > S::ZERO && *entry / own * *entry > variance {
            let most = own.sqrt() * variance.sqrt();
            *entry = if *entry < S::ZERO { -most } else { most };
        }
    }
}

snapshot_fields!(impl [S: Scalar] Covariance<S> {
    store, power, gain, draw, hour, all,
} if |state| {
    state.is_sound()
});

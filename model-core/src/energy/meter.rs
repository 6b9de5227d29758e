//! Meters: observers that add up what the integrator integrated.
//!
//! Energy is the integral of a power over each step by the method's own stage weights, never a
//! sample at the end of a step: in these harvesters the power comes in spikes of a fraction of a
//! millisecond. Sums are compensated, so a day of simulated time drifts in `f32` by a rounding.

use crate::hybrid::{Event, Observer, Span};
use crate::integrate::cubic::Cubic;
use crate::scalar::{CompensatedSum, Scalar};
use crate::scene::{Harvester, account};
use crate::snapshot::{Reader, Snapshot, SnapshotError, Writer};

/// Integrals over time of the first `P` powers of the account, and the time itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integrals<S, const P: usize> {
    sums: [CompensatedSum<S>; P],
    /// Elapsed ticks.
    ticks: u64,
}

impl<S: Scalar, const P: usize> Integrals<S, P> {
    /// Nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { sums: [CompensatedSum::ZERO; P], ticks: 0 }
    }

    /// Adds the integrals over one step.
    #[inline(always)]
    pub(crate) fn add(&mut self, energies: &[S; P], ticks: u32) {
        for (sum, &energy) in self.sums.iter_mut().zip(energies) {
            sum.add(energy);
        }
        self.ticks = self.ticks.wrapping_add(u64::from(ticks));
    }

    /// Adds what passed in no time.
    #[inline(always)]
    pub(crate) fn add_at_once(&mut self, energies: &[S; P]) {
        for (sum, &energy) in self.sums.iter_mut().zip(energies) {
            if energy != S::ZERO {
                sum.add(energy);
            }
        }
    }

    /// Integral of entry `index` of the account; 0 if it is not among the first `P`.
    #[must_use]
    pub fn integral(&self, index: usize) -> S {
        self.sums.get(index).map_or(S::ZERO, CompensatedSum::value)
    }

    /// Mean of entry `index` of the account over the elapsed time; 0 before any.
    #[must_use]
    pub fn mean(&self, index: usize) -> S {
        if self.ticks == 0 { S::ZERO } else { self.integral(index) / self.seconds() }
    }

    /// Elapsed time in seconds.
    #[must_use]
    pub fn seconds(&self) -> S {
        crate::clock::Instant::from_ticks(self.ticks).seconds()
    }
}

impl<S: Scalar, const P: usize> Default for Integrals<S, P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const P: usize> Snapshot for Integrals<S, P> {
    const BYTES: usize = P * CompensatedSum::<S>::BYTES + u64::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.sums.write(out);
        self.ticks.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Ok(Self { sums: Snapshot::read(from)?, ticks: Snapshot::read(from)? })
    }
}

/// What a sensor node needs: energy delivered to the load, and mean power.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerMeter<S, const P: usize>(Integrals<S, P>);

impl<S: Scalar, const P: usize> PowerMeter<S, P> {
    /// A meter at zero.
    #[must_use]
    pub const fn new() -> Self {
        Self(Integrals::new())
    }

    /// Adds a step that delivered an energy.
    #[inline(always)]
    pub(crate) fn add_delivered(&mut self, energy: S, ticks: u32) {
        let mut energies = [S::ZERO; P];
        if let Some(first) = energies.first_mut() {
            *first = energy;
        }
        self.0.add(&energies, ticks);
    }

    /// Energy delivered to the load, in joules.
    #[must_use]
    pub fn delivered_energy(&self) -> S {
        self.0.integral(account::LOAD)
    }

    /// Mean power delivered to the load, in watts.
    #[must_use]
    pub fn mean_power(&self) -> S {
        self.0.mean(account::LOAD)
    }

    /// Elapsed time in seconds.
    #[must_use]
    pub fn seconds(&self) -> S {
        self.0.seconds()
    }
}

impl<S: Scalar, const P: usize> Default for PowerMeter<S, P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const P: usize> Snapshot for PowerMeter<S, P> {
    const BYTES: usize = Integrals::<S, P>::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.0.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Ok(Self(Snapshot::read(from)?))
    }
}

impl<S: Scalar, Mode, const N: usize, const P: usize> Observer<S, Mode, N, P> for PowerMeter<S, P> {
    #[inline(always)]
    fn step(&mut self, span: &Span<'_, S, Mode, N, P>) {
        self.0.add(span.energies, span.ticks);
    }

    #[inline(always)]
    fn event(&mut self, event: &Event<'_, S, Mode, N, P>) {
        self.0.add_at_once(event.energies);
    }
}

/// The smallest and the largest value of something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak<S> {
    /// Smallest value; infinite before any.
    pub lowest: S,
    /// Largest value; minus infinity before any.
    pub highest: S,
}

impl<S: Scalar> Peak<S> {
    /// Nothing yet.
    #[must_use]
    pub fn new() -> Self {
        Self { lowest: S::INFINITY, highest: -S::INFINITY }
    }

    /// Takes in a step, turning points inside it included.
    #[inline]
    pub(crate) fn include(&mut self, cubic: &Cubic<S>) {
        self.lowest = cubic.smallest().min(self.lowest);
        self.highest = cubic.largest().max(self.highest);
    }

    /// Largest magnitude; 0 before any.
    #[must_use]
    pub fn magnitude(&self) -> S {
        self.highest.max(-self.lowest).max(S::ZERO)
    }
}

impl<S: Scalar> Default for Peak<S> {
    fn default() -> Self {
        Self::new()
    }
}

/// Everything that a report of a run shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunMeter<'a, S, H, const P: usize> {
    harvester: &'a H,
    integrals: Integrals<S, P>,
    coordinate: Peak<S>,
    voltage: Peak<S>,
    impacts: u32,
    fastest_impact: S,
    sticks: u32,
    stick_ticks: u64,
}

impl<'a, S: Scalar, H, const P: usize> RunMeter<'a, S, H, P> {
    /// A meter at zero, for runs of `harvester`.
    #[must_use]
    pub fn new(harvester: &'a H) -> Self {
        Self {
            harvester,
            integrals: Integrals::new(),
            coordinate: Peak::new(),
            voltage: Peak::new(),
            impacts: 0,
            fastest_impact: S::ZERO,
            sticks: 0,
            stick_ticks: 0,
        }
    }

    /// The integrals of the powers.
    #[must_use]
    pub fn integrals(&self) -> &Integrals<S, P> {
        &self.integrals
    }

    /// Energy delivered to the load, in joules.
    #[must_use]
    pub fn delivered_energy(&self) -> S {
        self.integrals.integral(account::LOAD)
    }

    /// Mean power delivered to the load, in watts.
    #[must_use]
    pub fn mean_power(&self) -> S {
        self.integrals.mean(account::LOAD)
    }

    /// Root mean square of the terminal voltage, in volts.
    #[must_use]
    pub fn rms_voltage(&self) -> S {
        self.integrals.mean(account::VOLTAGE_SQUARED).sqrt()
    }

    /// Mean terminal voltage, in volts.
    #[must_use]
    pub fn mean_voltage(&self) -> S {
        self.integrals.mean(account::VOLTAGE)
    }

    /// Charge moved through the load in either direction, in coulombs.
    #[must_use]
    pub fn charge_moved(&self) -> S {
        self.integrals.integral(account::CURRENT_MAGNITUDE)
    }

    /// Extremes of the harvester's coordinate (a gap, a displacement), in metres.
    #[must_use]
    pub fn coordinate(&self) -> Peak<S> {
        self.coordinate
    }

    /// Extremes of the terminal voltage, in volts.
    #[must_use]
    pub fn voltage(&self) -> Peak<S> {
        self.voltage
    }

    /// Number of impacts.
    #[must_use]
    pub fn impacts(&self) -> u32 {
        self.impacts
    }

    /// Largest impact speed in m/s; 0 if there was no impact.
    #[must_use]
    pub fn fastest_impact(&self) -> S {
        self.fastest_impact
    }

    /// Number of times the moving part came to be held.
    #[must_use]
    pub fn sticks(&self) -> u32 {
        self.sticks
    }

    /// Part of the time for which the moving part was held, 0 to 1.
    #[must_use]
    pub fn stick_fraction(&self) -> S {
        if self.integrals.ticks == 0 {
            return S::ZERO;
        }
        crate::clock::Instant::from_ticks(self.stick_ticks).seconds::<S>() / self.integrals.seconds()
    }
}

impl<S, H, const N: usize, const P: usize> Observer<S, H::Mode, N, P> for RunMeter<'_, S, H, P>
where
    S: Scalar,
    H: Harvester<S, N, P>,
{
    fn step(&mut self, span: &Span<'_, S, H::Mode, N, P>) {
        self.integrals.add(span.energies, span.ticks);
        let (start, end) = (self.harvester.coordinate(span.start), self.harvester.coordinate(span.end));
        self.coordinate.include(&Cubic::new(start.value, start.rate, end.value, end.rate, span.step));
        // The rate of the voltage is a small difference where the circuit is stiff; its mean over
        // the step is not.
        let ends = [span.start, span.end].map(|point| self.harvester.voltage(span.mode, point));
        let mean = span.energies.get(account::VOLTAGE).map_or(S::ZERO, |&integral| integral / span.step);
        self.voltage.include(&Cubic::with_mean(ends[0], ends[1], mean));
        if self.harvester.is_stick(span.mode) {
            self.stick_ticks = self.stick_ticks.wrapping_add(u64::from(span.ticks));
        }
    }

    fn event(&mut self, event: &Event<'_, S, H::Mode, N, P>) {
        self.integrals.add_at_once(event.energies);
        if self.harvester.is_impact(event.before, event.guard) {
            self.impacts = self.impacts.saturating_add(1);
            self.fastest_impact =
                self.harvester.coordinate(event.reached).rate.abs().max(self.fastest_impact);
        }
        if self.harvester.is_stick(event.after) && !self.harvester.is_stick(event.before) {
            self.sticks = self.sticks.saturating_add(1);
        }
    }
}

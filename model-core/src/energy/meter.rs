//! Sums the integrals of a run.
//!
//! Energy is the integral of a power over each step with the stage weights of the method, not a sample at the
//! end of a step: the power of these harvesters comes in spikes of a fraction of a millisecond. Sums are
//! compensated, so the error of a day of simulated time in `f32` is one rounding.

use crate::clock::Instant;
use crate::integrate::Cubic;
use crate::integrate::cubic::Peak;
use crate::observer::{ALL_POWERS, AcceptedStep, Event, Observer, Outputs, PowerIndex};
use crate::scalar::{CompensatedSum, Scalar};
use crate::snapshot::snapshot_fields;

/// Integrals of all powers over time, and the elapsed time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integrals<S> {
    sums: [CompensatedSum<S>; ALL_POWERS],
    ticks: u64,
    /// Whether every step integrated all powers.
    complete: bool,
}

impl<S: Scalar> Integrals<S> {
    pub(crate) const ZERO: Self = Self { sums: [CompensatedSum::ZERO; ALL_POWERS], ticks: 0, complete: true };

    /// Adds the integrals over one step.
    #[inline]
    pub(crate) fn add(&mut self, energies: &[S], ticks: u32) {
        for (sum, &energy) in self.sums.iter_mut().zip(energies) {
            sum.add(energy);
        }
        self.ticks = self.ticks.wrapping_add(u64::from(ticks));
        self.complete &= energies.len() >= ALL_POWERS;
    }

    /// Whether the run integrates all powers: `with_all_powers`, not `new`.
    pub(crate) fn is_complete(&self) -> bool {
        self.complete
    }

    /// Adds the instantaneous part of each integral.
    #[inline]
    pub(crate) fn add_at_once(&mut self, energies: &[S]) {
        for (sum, &energy) in self.sums.iter_mut().zip(energies) {
            if energy != S::ZERO {
                sum.add(energy);
            }
        }
    }

    /// Integral of a power over the elapsed time, in the unit of the power times s; 0 if it was not integrated.
    #[must_use]
    pub fn integral(&self, power: PowerIndex) -> S {
        self.sums.get(power as usize).map_or(S::ZERO, CompensatedSum::value)
    }

    /// Mean of a power over the elapsed time, in the unit of the power; 0 at time zero.
    #[must_use]
    pub fn mean(&self, power: PowerIndex) -> S {
        if self.ticks == 0 { S::ZERO } else { self.integral(power) / self.seconds() }
    }

    /// Elapsed time in s.
    pub(crate) fn seconds(&self) -> S {
        Instant::from_ticks(self.ticks).seconds()
    }
}

/// The meter of a sensor node: energy delivered to the load, and mean power.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PowerMeter<S> {
    delivered: CompensatedSum<S>,
    ticks: u64,
}

impl<S: Scalar> PowerMeter<S> {
    /// A meter at zero.
    #[must_use]
    pub const fn new() -> Self {
        Self { delivered: CompensatedSum::ZERO, ticks: 0 }
    }

    /// Energy delivered to the load, in J.
    #[must_use]
    pub fn delivered_energy(&self) -> S {
        self.delivered.value()
    }

    /// Mean power delivered to the load, in W; 0 at time zero.
    #[must_use]
    pub fn mean_power(&self) -> S {
        if self.ticks == 0 { S::ZERO } else { self.delivered_energy() / self.seconds() }
    }

    /// Elapsed time in s.
    #[must_use]
    pub fn seconds(&self) -> S {
        Instant::from_ticks(self.ticks).seconds()
    }
}

snapshot_fields!(impl [S: Scalar] PowerMeter<S> { delivered, ticks });

impl<S: Scalar> Observer<S> for PowerMeter<S> {
    const READS_OUTPUTS: bool = false;

    #[inline]
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        self.delivered.add(step.energy(PowerIndex::Load));
        self.ticks = self.ticks.wrapping_add(u64::from(step.ticks));
    }

    #[inline]
    fn event(&mut self, event: &Event<'_, S>) {
        if let Some(&energy) = event.energies.first()
            && energy != S::ZERO
        {
            self.delivered.add(energy);
        }
    }
}

/// The report of a [`RunMeter`], without its integrals.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct RunReport<S> {
    /// Root mean square of the terminal voltage in V; `None` if the run does not integrate all powers.
    pub rms_voltage: Option<S>,
    /// Extremes of the terminal voltage in V.
    pub voltage: Peak<S>,
    /// Extremes of the harvester's first coordinate (a gap, a displacement) in m.
    pub coordinate: Peak<S>,
    /// Extremes of the beam's displacement at the stop of bump-stop in m.
    pub stop_point: Peak<S>,
    /// Number of impacts.
    pub impacts: u32,
    /// Largest impact speed in m/s; 0 without an impact.
    pub fastest_impact: S,
    /// Number of times that the moving part began to stick.
    pub sticks: u32,
    /// Fraction of the time in stick, 0 to 1.
    pub stick_fraction: S,
    /// Number of contacts: intervals with a contact force, and impacts.
    pub contacts: u32,
    /// Fraction of the time in contact, 0 to 1.
    pub contact_fraction: S,
    /// Time of the first contact or impact.
    pub first_contact: Option<Instant>,
    /// Largest contact force in N; impacts have no force.
    pub peak_force: S,
}

/// Meter of a whole run of any harvester: integrals of all powers, extremes, events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunMeter<S> {
    integrals: Integrals<S>,
    motions: [Peak<S>; 3],
    voltage: Peak<S>,
    impacts: u32,
    fastest_impact: S,
    sticks: u32,
    stick_ticks: u64,
    contacts: u32,
    contact_seconds: CompensatedSum<S>,
    peak_force: S,
    first_contact: Option<Instant>,
    /// Whether the last step ended in contact.
    in_contact: bool,
}

impl<S: Scalar> RunMeter<S> {
    /// A meter at zero.
    #[must_use]
    pub fn new() -> Self {
        Self {
            integrals: Integrals::ZERO,
            motions: [Peak::new(); 3],
            voltage: Peak::new(),
            impacts: 0,
            fastest_impact: S::ZERO,
            sticks: 0,
            stick_ticks: 0,
            contacts: 0,
            contact_seconds: CompensatedSum::ZERO,
            peak_force: S::ZERO,
            first_contact: None,
            in_contact: false,
        }
    }

    /// A meter that starts at `outputs`, whose voltage counts: the circuit of a resistor may be faster than the first step.
    /// Behind a bridge the first step shows what the bridge leaves of it. A contact that is closed is not counted.
    #[must_use]
    pub fn starting_at(outputs: &Outputs<'_, S>) -> Self {
        let mut meter = Self { in_contact: outputs.in_contact, ..Self::new() };
        meter.start(outputs);
        meter
    }

    /// Counts the voltage at the start, or at the end of a stick from the start on, through which no charge passed.
    fn start(&mut self, outputs: &Outputs<'_, S>) {
        if outputs.storage.is_none() {
            self.voltage.lowest = self.voltage.lowest.min(outputs.voltage);
            self.voltage.highest = self.voltage.highest.max(outputs.voltage);
        }
    }

    /// The integrals of the powers.
    #[must_use]
    pub fn integrals(&self) -> &Integrals<S> {
        &self.integrals
    }

    /// Energy delivered to the load, in J.
    #[must_use]
    pub fn delivered_energy(&self) -> S {
        self.integrals.integral(PowerIndex::Load)
    }

    /// Mean power delivered to the load, in W.
    #[must_use]
    pub fn mean_power(&self) -> S {
        self.integrals.mean(PowerIndex::Load)
    }

    /// The report.
    #[must_use]
    pub fn report(&self) -> RunReport<S> {
        let [coordinate, stop_point, _] = self.motions;
        RunReport {
            rms_voltage: (self.integrals.is_complete())
                .then(|| self.integrals.mean(PowerIndex::VoltageSquared).sqrt()),
            voltage: self.voltage,
            coordinate,
            stop_point,
            impacts: self.impacts,
            fastest_impact: self.fastest_impact,
            sticks: self.sticks,
            stick_fraction: self.fraction(Instant::from_ticks(self.stick_ticks).seconds()),
            contacts: self.contacts,
            contact_fraction: self.fraction(self.contact_seconds.value()),
            first_contact: self.first_contact,
            peak_force: self.peak_force,
        }
    }

    fn fraction(&self, seconds: S) -> S {
        if self.integrals.ticks == 0 { S::ZERO } else { seconds / self.integrals.seconds() }
    }

    /// Counts a contact that begins at `at`, unless it continues the previous one.
    fn touch(&mut self, at: Instant) {
        if !self.in_contact {
            self.contacts = self.contacts.saturating_add(1);
            self.first_contact = self.first_contact.or(Some(at));
        }
    }
}

impl<S: Scalar> Default for RunMeter<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Observer<S> for RunMeter<S> {
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        self.integrals.add(step.energies, step.ticks);
        let ends = step.start.motions.iter().zip(&step.end.motions);
        for (peak, (start, end)) in self.motions.iter_mut().zip(ends) {
            peak.include(&Cubic::new(start.value, start.rate, end.value, end.rate, step.step), S::INFINITY);
        }
        // A parabola through the mean is more accurate than a cubic of the rates: the rate of the voltage of
        // a stiff circuit is a small difference.
        let voltage = Cubic::with_mean(step.start.voltage, step.end.voltage, step.mean_voltage);
        // No bridge leaves more than its threshold: what the parabola or a rounding has above it is no voltage.
        let [start, end] = [&step.start, &step.end]
            .map(|outputs| outputs.storage.map_or(S::INFINITY, |storage| storage.threshold));
        self.voltage.include(&voltage, start.max(end));
        if step.start.stick {
            self.stick_ticks = self.stick_ticks.wrapping_add(u64::from(step.ticks));
        }
        let contact = &step.contact;
        if contact.force > S::ZERO {
            self.peak_force = self.peak_force.max(contact.peak_force);
            self.contact_seconds.add(step.step * (contact.ends - contact.begins));
            let ticks = (contact.begins * S::from_u32(step.ticks)).to_u32();
            self.touch(step.from.after(ticks));
        }
        self.in_contact = contact.force > S::ZERO && step.end.in_contact;
    }

    fn event(&mut self, event: &Event<'_, S>) {
        self.integrals.add_at_once(event.energies);
        if let Some(speed) = event.impact_speed {
            self.impacts = self.impacts.saturating_add(1);
            self.fastest_impact = self.fastest_impact.max(speed);
            self.in_contact = false;
            self.touch(event.at);
            // A contact that begins with the impact is the same contact.
            self.in_contact = true;
        }
        if event.after.stick && !event.before.stick {
            self.sticks = self.sticks.saturating_add(1);
        } else if event.before.stick && self.sticks == 0 {
            self.start(&event.after);
        }
    }
}

//! What the report of a run takes from the scene, and what a run records: rows of a trace, and energies of blocks.

use std::marker::PhantomData;

use model_core::clock::Instant;
use model_core::energy::{Residual, RunMeter};
use model_core::integrate::Cubic;
use model_core::observer::{AcceptedStep, Event, Motion, Observer, Outputs, PowerIndex};
use model_core::scalar::Scalar;
use model_core::scene::Harvester;

use super::excitation::{HostExcitation, Setting};
use super::limits::{Clamp, Gauge};
use harvester_scene::outcome::{BLOCKS, Particular, SwitchCycles};

/// What the report of one kind of scene adds to the numbers that every run has.
pub(super) trait Report<S: Scalar, H: Harvester<S>> {
    /// Columns of a trace: time first, the voltage of a storage last.
    fn columns(&self, with_storage: bool) -> &'static [&'static str];

    /// The columns between these two at a fraction of a step, under a base acceleration in m/s².
    fn row(&self, step: &AcceptedStep<'_, S>, fraction: S, acceleration: S) -> [S; 6];

    /// The relative residual of the energy ledger that holds for this scene.
    fn residual(&self, residual: &Residual<S>) -> Option<S>;

    /// Energy in J that an inferred force law created in the window; `None` for a bump-stop scene, and for a
    /// run that does not integrate all powers.
    fn created_energy(&self, _window: &RunMeter<S>) -> Option<S> {
        None
    }

    /// What meters the bending at the clamp over the window; `None` for a scene without a clamped beam's stress.
    fn clamp<'a>(&self, _excitation: HostExcitation<'a, S>) -> Option<Clamp<'a, S>> {
        None
    }

    /// What compares the steps of a run with the limits of the model.
    fn gauge<'a>(&'a self, setting: Setting<'a, S>) -> Gauge<'a, S>;

    /// The numbers that only this kind of scene has.
    fn particular(&self, harvester: &H, found: &RunSummary<'_, S>, end: &H::State) -> Particular;

    fn describe(&self, outputs: &Outputs<'_, S>) -> String;
}

/// What a run found, for the scene to make its own numbers of.
pub(super) struct RunSummary<'a, S: Scalar> {
    pub(super) window: &'a RunMeter<S>,
    /// Time of the first contact or impact of the whole run.
    pub(super) first_contact: Option<Instant>,
    /// Periods of the base in the window, where it moves in one sine.
    pub(super) periods: Option<f64>,
    /// The bending at the clamp in the window.
    pub(super) clamp: Option<&'a Clamp<'a, S>>,
}

/// Collects the rows of a run: the columns of [`Report::columns`].
pub(super) struct Recorder<'a, S: Scalar, H, R> {
    report: &'a R,
    excitation: HostExcitation<'a, S>,
    every: f64,
    pub(super) rows: Vec<Vec<f64>>,
    /// The instants of impacts in s.
    pub(super) impacts_s: Vec<f64>,
    harvester: PhantomData<H>,
}

impl<'a, S: Scalar, H, R> Recorder<'a, S, H, R> {
    /// A row for each `every` seconds.
    pub(super) fn new(report: &'a R, excitation: HostExcitation<'a, S>, every: f64) -> Self {
        Self { report, excitation, every, rows: Vec::new(), impacts_s: Vec::new(), harvester: PhantomData }
    }
}

impl<S, H, R> Observer<S> for Recorder<'_, S, H, R>
where
    S: Scalar,
    H: Harvester<S>,
    R: Report<S, H>,
{
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        let (from, until) = (step.from.seconds::<f64>(), step.until().seconds::<f64>());
        loop {
            let time = self.rows.len() as f64 * self.every;
            // Compared in ticks: the last row may stand at the end of the last step.
            if Instant::from_seconds(time).is_none_or(|row| row > step.until()) {
                return;
            }
            let fraction = ((time - from) / (until - from)).clamp(0.0, 1.0);
            let theta = S::from_f64(fraction);
            let at = step.from.after((fraction * f64::from(step.ticks)) as u32);
            let row = self.report.row(step, theta, self.excitation.acceleration(at)).map(S::to_f64);
            let storage = step.start.storage.zip(step.end.storage).map(|(start, end)| {
                let rise = (end.voltage - start.voltage).to_f64();
                start.voltage.to_f64() + rise * fraction
            });
            self.rows.push(std::iter::once(time).chain(row).chain(storage).collect());
        }
    }

    fn event(&mut self, event: &Event<'_, S>) {
        if event.impact_speed.is_some() {
            self.impacts_s.push(event.at.seconds());
        }
    }
}

/// A coordinate at a fraction of a step, by a cubic.
pub(super) fn dense<S: Scalar>(start: Motion<S>, end: Motion<S>, step: S, fraction: S) -> S {
    Cubic::new(start.value, start.rate, end.value, end.rate, step).value(fraction)
}

/// The terminal voltage at a fraction of a step, by a parabola of its mean.
pub(super) fn dense_voltage<S: Scalar>(step: &AcceptedStep<'_, S>, fraction: S) -> S {
    Cubic::with_mean(step.start.voltage, step.end.voltage, step.mean_voltage).value(fraction)
}

/// What compares two runs: the energy delivered in equal parts of the measuring window, and means over whole cycles of the
/// switch of a draw.
pub(super) struct Blocks {
    from: u64,
    /// Ticks of a part.
    length: u64,
    pub(super) energies_j: [f64; BLOCKS],
    /// Integrals from the start of the window: energy delivered in J, squared terminal voltage in V² s, and storage voltage in V s.
    integrals: [f64; 3],
    /// The time in s and the integrals at the first turn-on of the draw and at the last, and the number of turn-ons.
    turn_ons: Option<[(f64, [f64; 3]); 2]>,
    count: u64,
    is_connected: bool,
}

impl Blocks {
    pub(super) fn new(from: Instant, until: Instant) -> Self {
        let length = (until.ticks() - from.ticks()).div_ceil(BLOCKS as u64).max(1);
        Self {
            from: from.ticks(),
            length,
            energies_j: [0.0; BLOCKS],
            integrals: [0.0; 3],
            turn_ons: None,
            count: 0,
            is_connected: true,
        }
    }

    /// The whole cycles of the switch of the draw.
    pub(super) fn cycles(&self) -> Option<SwitchCycles> {
        let [(from_s, from), (until_s, until)] = self.turn_ons.filter(|_| self.count > 1)?;
        let [power, square, store] = std::array::from_fn(|i| (until[i] - from[i]) / (until_s - from_s));
        Some(SwitchCycles {
            count: self.count - 1,
            from_s,
            until_s,
            mean_power_w: power,
            rms_voltage_v: square.max(0.0).sqrt(),
            mean_store_voltage_v: store,
        })
    }

    /// Counts a turn-on before a step, and integrates over the step.
    fn integrate<S: Scalar>(&mut self, step: &AcceptedStep<'_, S>) {
        let Some((start, end)) = step.start.storage.zip(step.end.storage) else { return };
        if start.connected && !self.is_connected {
            let now = (step.from.seconds(), self.integrals);
            self.turn_ons = Some([self.turn_ons.map_or(now, |[first, _]| first), now]);
            self.count += 1;
        }
        self.is_connected = start.connected;
        let stored = 0.5 * (start.voltage.to_f64() + end.voltage.to_f64()) * step.step.to_f64();
        let squares = step.energy(PowerIndex::VoltageSquared).to_f64();
        self.add([step.energy(PowerIndex::Load).to_f64(), squares, stored]);
    }

    fn add(&mut self, more: [f64; 3]) {
        self.integrals = std::array::from_fn(|i| self.integrals[i] + more[i]);
    }

    fn part_of(&self, at: Instant) -> usize {
        let part = (at.ticks().saturating_sub(self.from) / self.length) as usize;
        part.min(BLOCKS - 1)
    }
}

impl<S: Scalar> Observer<S> for Blocks {
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        self.integrate(step);
        let energy = step.energy(PowerIndex::Load).to_f64();
        let (part, last) = (self.part_of(step.from), self.part_of(step.until()));
        self.energies_j[part] += energy;
        if last > part {
            // A step is far shorter than a part.
            let border = self.from + self.length * last as u64;
            let before = (border - step.from.ticks()) as f64 / f64::from(step.ticks);
            let beyond = energy - energy_within(step, energy, before);
            self.energies_j[part] -= beyond;
            self.energies_j[last] += beyond;
        }
    }

    fn event(&mut self, event: &Event<'_, S>) {
        let energy =
            |power: PowerIndex| event.energies.get(power as usize).map_or(0.0, |energy| energy.to_f64());
        self.add([energy(PowerIndex::Load), energy(PowerIndex::VoltageSquared), 0.0]);
        if let Some(energy) = event.energies.first() {
            self.energies_j[self.part_of(event.at)] += energy.to_f64();
        }
    }
}

/// The energy in J delivered up to a fraction of a step, of the parabola through the powers at both ends that has the
/// step's energy; from none to all of it, where the powers at the ends are those of a transient.
fn energy_within<S: Scalar>(step: &AcceptedStep<'_, S>, energy: f64, fraction: f64) -> f64 {
    let length = step.step.to_f64();
    let [start, end] =
        [&step.start, &step.end].map(|outputs| (outputs.charge.rate * outputs.voltage).to_f64() * length);
    let quadratic = 3.0 * energy - 2.0 * start - end;
    let cubic = start + end - 2.0 * energy;
    let within = fraction * (start + fraction * (quadratic + fraction * cubic));
    within.clamp(energy.min(0.0), energy.max(0.0))
}

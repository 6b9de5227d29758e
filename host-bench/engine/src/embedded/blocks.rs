//! The energy delivered in equal parts of the measuring window, and the means over whole cycles of the switch of a draw, to
//! compare two runs.

use harvester_scene::outcome::{BLOCKS, SwitchCycles};
use model_core::clock::Instant;
use model_core::observer::{AcceptedStep, Event, Observer, PowerIndex};
use model_core::scalar::Scalar;

/// Energy in J delivered in each part of a window.
pub(super) struct Blocks {
    from: u64,
    /// Ticks of a part.
    length: u64,
    pub(super) energies_j: [f64; BLOCKS],
    /// Integrals from the start of the window: energy delivered in J, squared terminal voltage in V² s, and voltage of the
    /// storage in V s.
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

//! The energy delivered in equal parts of the measuring window, to compare two runs part by part.

use harvester_scene::outcome::BLOCKS;
use model_core::clock::Instant;
use model_core::observer::{AcceptedStep, Event, Observer, PowerIndex};
use model_core::scalar::Scalar;

/// Energy in J delivered in each part of a window.
pub(super) struct Blocks {
    from: u64,
    /// Ticks of a part.
    length: u64,
    pub(super) energies_j: [f64; BLOCKS],
}

impl Blocks {
    pub(super) fn new(from: Instant, until: Instant) -> Self {
        let length = (until.ticks() - from.ticks()).div_ceil(BLOCKS as u64).max(1);
        Self { from: from.ticks(), length, energies_j: [0.0; BLOCKS] }
    }

    fn part_of(&self, at: Instant) -> usize {
        let part = (at.ticks().saturating_sub(self.from) / self.length) as usize;
        part.min(BLOCKS - 1)
    }
}

impl<S: Scalar> Observer<S> for Blocks {
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
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
        if let Some(energy) = event.energies.first() {
            self.energies_j[self.part_of(event.at)] += energy.to_f64();
        }
    }
}

/// The energy in J delivered up to a fraction of a step, of the parabola through the powers at both ends that has the
/// step's energy.
fn energy_within<S: Scalar>(step: &AcceptedStep<'_, S>, energy: f64, fraction: f64) -> f64 {
    let length = step.step.to_f64();
    let [start, end] =
        [&step.start, &step.end].map(|outputs| (outputs.charge.rate * outputs.voltage).to_f64() * length);
    let quadratic = 3.0 * energy - 2.0 * start - end;
    let cubic = start + end - 2.0 * energy;
    fraction * (start + fraction * (quadratic + fraction * cubic))
}

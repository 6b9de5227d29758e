//! The least margins of a run to the limits of its model, and the bending at the clamp.

use model_core::clock::Instant;
use model_core::observer::{AcceptedStep, Event, Observer};
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::{ClampMeter, Fibre};

use super::excitation::HostExcitation;
use harvester_scene::outcome::{ClampOutcome, Margin, Margins};
use harvester_scene::rainflow::Rainflow;
use harvester_scene::scene_file::Scene;

/// Name of the limit that an impact is compared with.
const CONTACT_SPEED: &str = "contact_speed_m_per_s";

/// Magnitude and limit of each compared quantity at a fraction of a step, in the order of `[limits]`, and then unused places.
pub(super) type Pairs = [[f64; 2]; 5];

/// An unused place.
pub(super) const UNUSED: [f64; 2] = [0.0, 1.0];

/// What compares the steps of a scene with the limits of its model, and the number of equal parts of a step at whose ends it does.
pub(super) type Gauge<'a, S> = (Box<dyn FnMut(&AcceptedStep<'_, S>, S) -> Pairs + 'a>, u32);

pub(super) fn limits<const N: usize>(scene: &Scene) -> [f64; N] {
    std::array::from_fn(|index| scene.limits.get(index).map_or(f64::INFINITY, |(_, limit)| *limit))
}

/// The observer of a whole run, its start included.
pub(super) struct Compared<'a, S> {
    scene: &'a Scene,
    gauge: Gauge<'a, S>,
    found: Vec<Margin>,
    /// Speed in m/s and instant of an impact before the first step.
    first_impact: Option<(f64, Instant)>,
}

impl<'a, S: Scalar> Compared<'a, S> {
    pub(super) fn new(scene: &'a Scene, gauge: Gauge<'a, S>) -> Self {
        Self { scene, gauge, found: Vec::new(), first_impact: None }
    }

    pub(super) fn margins(&self) -> Margins {
        Margins::new(self.found.clone())
    }

    fn include(&mut self, index: usize, name: &'static str, [value, limit]: [f64; 2], at: Instant) {
        let new = || {
            let margin = Some(limit / value).filter(|margin| margin.is_finite());
            Margin { name, value, limit, margin, at_s: at.seconds() }
        };
        match self.found.get_mut(index) {
            None => self.found.push(new()),
            Some(found) if value * found.limit > found.value * limit => *found = new(),
            Some(_) => {}
        }
    }
}

impl<S: Scalar> Compared<'_, S> {
    fn include_impact(&mut self, speed: f64, at: Instant) {
        match self.found.iter().position(|found| found.name == CONTACT_SPEED) {
            Some(index) => self.include(index, CONTACT_SPEED, [speed, self.found[index].limit], at),
            None => self.first_impact = Some((speed, at)),
        }
    }
}

impl<S: Scalar> Observer<S> for Compared<'_, S> {
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        let parts = self.gauge.1;
        for part in u32::from(!self.found.is_empty())..=parts {
            let fraction = S::from_u32(part) / S::from_u32(parts);
            let at = step.from.after((u64::from(step.ticks) * u64::from(part) / u64::from(parts)) as u32);
            let compared = (self.gauge.0)(step, fraction);
            for (index, (&(name, _), pair)) in self.scene.limits.iter().zip(compared).enumerate() {
                self.include(index, name, pair, at);
            }
        }
        if let Some((speed, at)) = self.first_impact.take() {
            self.include_impact(speed, at);
        }
    }

    fn event(&mut self, event: &Event<'_, S>) {
        if let Some(speed) = event.impact_speed {
            self.include_impact(speed.to_f64(), event.at);
        }
    }
}

/// Most modes of the beam.
pub(crate) const MOST_MODES: usize = 20;

/// The core's meter of the curvature, and the cycles of the curvature.
pub(crate) struct Clamp<'a, S: Scalar> {
    meter: ClampMeter<S, HostExcitation<'a, S>, MOST_MODES>,
    cycles: Rainflow,
    /// Length of the window so far.
    seconds: f64,
}

impl<'a, S: Scalar> Clamp<'a, S> {
    pub(crate) fn new(meter: ClampMeter<S, HostExcitation<'a, S>, MOST_MODES>) -> Self {
        Self { meter, cycles: Rainflow::default(), seconds: 0.0 }
    }

    /// Largest strain of each outer fibre, the substrate's first, after a further step.
    pub(crate) fn strains(&mut self, step: Option<&AcceptedStep<'_, S>>) -> [f64; 2] {
        step.into_iter().for_each(|step| self.meter.step(step));
        let (bending, peak) = (self.meter.bending(), self.meter.curvature().magnitude());
        [bending.substrate, bending.piezo].map(|fibre| fibre.strain(peak).to_f64())
    }

    pub(crate) fn outcome(&self) -> ClampOutcome {
        let bent = |fibre: &Fibre<S>| {
            let (distance, young_modulus) = (fibre.distance.to_f64(), fibre.young_modulus.to_f64());
            let fibre = Fibre { distance, young_modulus };
            move |curvature: f64| [fibre.strain(curvature), fibre.stress(curvature)]
        };
        let bending = self.meter.bending();
        let peak = self.meter.curvature().magnitude().to_f64();
        ClampOutcome::new(
            [peak, self.meter.rms_curvature().to_f64()],
            (&self.cycles, self.seconds),
            [bent(&bending.substrate), bent(&bending.piezo)],
        )
    }
}

impl<S: Scalar> Observer<S> for Clamp<'_, S> {
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        self.meter.step(step);
        self.meter.last().into_iter().for_each(|curvature| self.cycles.push(curvature.to_f64()));
        self.seconds += step.step.to_f64();
    }
}

//! The bending of the beam at its clamp along a run.

use model_core::observer::{AcceptedStep, Observer};
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::{ClampMeter, Fibre};

use crate::embedded::excitation::HostExcitation;
use harvester_scene::outcome::ClampOutcome;
use harvester_scene::rainflow::Rainflow;

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

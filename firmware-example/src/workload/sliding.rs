//! The sliding scene.

pub mod building;
pub mod parts;
pub mod scenes;

use model_core::excitation::Sine;
use model_core::integrate::StepControl;
use model_core::scene::sliding::{Parameters, Parts, Sliding, Start};

use super::hybrid_run::{self, State};

impl<P: Parts<f32>> hybrid_run::Parameters for Parameters<f32, P> {
    type Harvester = Sliding<f32, P>;

    #[inline]
    fn build(&self) -> Option<Self::Harvester> {
        self.build().ok()
    }

    #[inline]
    fn start<C: StepControl<f32>>(
        harvester: &Self::Harvester,
        velocity: f32,
        excitation: &Sine<f32>,
        control: &C,
    ) -> Option<State<Self::Harvester>> {
        let start = Start { velocity: Some(velocity), ..Start::default() };
        harvester.start(&start, excitation, control).ok()
    }
}

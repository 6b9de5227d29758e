//! The classical explicit Runge–Kutta method of fourth order (Kutta 1901).

use super::boundary_layer::without_layer;
use super::{Attempt, Input, Method, NotConverged, System, Trial};
use crate::clock::seconds_of_ticks;
use crate::scalar::{Scalar, sum, zip_with};

/// The classical explicit Runge–Kutta method of fourth order, without an error estimate.
///
/// It is stable only for steps below 2.78 divided by the largest rate of the system. With a small load
/// resistance that is nanoseconds.
///
/// With [`Adaptive`](super::Adaptive) a run does not compile, because nothing would limit its steps:
///
/// ```compile_fail
/// # use model_core::{clock::Instant, excitation::Silence, part::load::Resistor};
/// # use model_core::part::restitution::ConstantRestitution;
/// # use model_core::scene::contact_separation::{Choices, Parameters, Start};
/// use model_core::integrate::{Adaptive, RungeKutta4};
/// use model_core::scene::{Harvester, Simulation};
///
/// # fn main() -> Result<(), model_core::Error> {
/// # let scene = Parameters {
/// #     mass: 5e-3_f32,
/// #     stiffness: 80.0,
/// #     damping_ratio: 0.005,
/// #     initial_gap: 3e-3,
/// #     electrode_area: 4e-4,
/// #     dielectric_thickness: 5e-5,
/// #     relative_permittivity: 2.0,
/// #     charge_density: 50e-6,
/// #     choices: Choices::new(Resistor { resistance: 1e8 }, ConstantRestitution { coefficient: 0.75 }),
/// # }
/// # .build()?;
/// // Compiles with `FixedStep::of_seconds(1e-5_f32)?`.
/// let harvester = Simulation::new(scene, RungeKutta4, Adaptive::new(1e-3)?);
/// let mut state = harvester.start(&Start::default(), &Silence)?;
/// harvester.advance(&mut state, &Silence, Instant::from_whole_seconds(1), 100, &mut ())?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RungeKutta4;

impl<S: Scalar> Method<S> for RungeKutta4 {
    const ESTIMATES_ERROR: bool = false;
    const CARRIES_DERIVATIVES: bool = true;

    type Prediction = ();

    #[inline]
    fn attempt<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        _prediction: Option<&()>,
    ) -> Result<Trial<S, N, P>, NotConverged> {
        let Attempt { ref input, ticks, .. } = *attempt;
        let step = seconds_of_ticks::<S>(ticks);
        let half = step * S::from_f64(0.5);
        let (middle_input, end_input) = (input.at(ticks / 2), input.at(ticks));
        let outside =
            if attempt.after_jump { without_layer(system, attempt.start, input.at(0)) } else { None };
        let start = outside.as_ref().map_or(attempt.start, |(start, _)| start);

        let scaled = |factor: S, rate: &[S; N]| rate.map(|rate| factor * rate);
        let k1 = start.derivative;
        let change2 = scaled(half, &k1);
        let k2 = system.flow_from(start, &change2, middle_input);
        let change3 = scaled(half, &k2);
        let k3 = system.flow_from(start, &change3, middle_input);
        let change4 = scaled(step, &k3);
        let k4 = system.flow_from(start, &change4, end_input);

        let change = weighted(step, &k1, &sum(&k2, &k3), &k4);
        let mut end = start.advanced(start.derivative, change);
        end.derivative = if Y::CARRIED {
            system.flow_from(start, &change, end_input)
        } else {
            system.flow(&end.state, end_input)
        };
        let powers = |change: &[S; N], rate: &[S; N], input: S| -> [S; P] {
            system.powers(&sum(&start.state, change), rate, input)
        };
        let p2 = powers(&change2, &k2, middle_input);
        let p3 = powers(&change3, &k3, middle_input);
        let p4 = powers(&change4, &k4, end_input);
        end.powers = system.powers(&end.state, &end.derivative, end_input);
        let mut energies = weighted(step, &start.powers, &sum(&p2, &p3), &p4);
        if let Some((_, layer)) = &outside {
            layer.restore(system, step, end_input, &mut end, &mut energies);
        }
        system.correct_energies(&attempt.start.state, &end.state, &mut energies);

        let finite =
            end.state.iter().chain(&end.derivative).chain(&energies).all(|value: &S| value.is_finite());
        if !finite {
            return Err(NotConverged);
        }
        Ok(Trial { end, energies, error: S::ZERO, energy_error: S::ZERO, iterations: 0 })
    }
}

/// The integral over `step`, of the values at its start and end and the sum of both in its middle.
#[inline]
fn weighted<S: Scalar, const N: usize>(step: S, start: &[S; N], middle: &[S; N], end: &[S; N]) -> [S; N] {
    let (sixth, two) = (step * S::from_f64(1.0 / 6.0), S::from_f64(2.0));
    let all_but_end = zip_with(*start, middle, |start, middle| start + two * *middle);
    zip_with(all_but_end, end, |others, end| sixth * (others + *end))
}

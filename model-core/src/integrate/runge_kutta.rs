//! The classical explicit Runge–Kutta method of fourth order (Kutta 1901).

use super::{Attempt, Input, Method, NotConverged, System, Trial, add_scaled};
use crate::clock::seconds_of_ticks;
use crate::scalar::{Scalar, add_increment};

/// The classical explicit Runge–Kutta method of fourth order, without an error estimate.
///
/// It is stable only for steps below 2.78 divided by the largest rate of the system. With a small load
/// resistance that is nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RungeKutta4;

impl<S: Scalar> Method<S> for RungeKutta4 {
    const ESTIMATES_ERROR: bool = false;

    type Prediction = ();

    #[inline]
    fn attempt<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        _prediction: Option<&()>,
    ) -> Result<Trial<S, N, P>, NotConverged> {
        let Attempt { start, ref input, ticks, .. } = *attempt;
        let step = seconds_of_ticks::<S>(ticks);
        let half = step * S::from_f64(0.5);
        let (middle_input, end_input) = (input.at(ticks / 2), input.at(ticks));

        let k1 = start.derivative;
        let y2 = add_scaled(&start.state, half, &k1);
        let k2 = system.flow(&y2, middle_input);
        let y3 = add_scaled(&start.state, half, &k2);
        let k3 = system.flow(&y3, middle_input);
        let y4 = add_scaled(&start.state, step, &k3);
        let k4 = system.flow(&y4, end_input);

        let sixth = step * S::from_f64(1.0 / 6.0);
        let two = S::from_f64(2.0);
        let mut end = *start;
        for i in 0..N {
            let increment = sixth * (k1[i] + two * (k2[i] + k3[i]) + k4[i]);
            (end.state[i], end.remainder[i]) = add_increment(start.state[i], start.remainder[i], increment);
        }
        end.derivative = system.flow(&end.state, end_input);
        let p2: [S; P] = system.powers(&y2, &k2, middle_input);
        let p3: [S; P] = system.powers(&y3, &k3, middle_input);
        let p4: [S; P] = system.powers(&y4, &k4, end_input);
        end.powers = system.powers(&end.state, &end.derivative, end_input);
        let mut energies =
            core::array::from_fn(|i| sixth * (start.powers[i] + two * (p2[i] + p3[i]) + p4[i]));
        system.correct_energies(&start.state, &end.state, &mut energies);

        let finite =
            end.state.iter().chain(&end.derivative).chain(&energies).all(|value: &S| value.is_finite());
        if !finite {
            return Err(NotConverged);
        }
        Ok(Trial { end, energies, error: S::ZERO, energy_error: S::ZERO, iterations: 0 })
    }
}

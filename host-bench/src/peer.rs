//! Textbook methods on the host, in double precision and with fixed steps, for comparison with the core's methods.

mod meter;
mod method;
mod system;

use cpu_time::ThreadTime;

use crate::method::{Failure, Method, Options, Precision, refuse_first};
use crate::outcome::Outcome;
use crate::scene_file::{BumpStop, Contact, Scene};
use meter::Meter;
use method::{Implicit, RungeKutta4, Stepper};
use system::{BaseAcceleration, State, System};

// The bump-stop harvester by general methods: TR-BDF2, the classical Runge-Kutta method and Newmark's.
//
// They integrate the modal equations with the contact as a spring, `F = k max(0, g)`, whose compliance is that of the modes left out.
// Steps do not end at the instants of contact. Each method is written for this system: the cost of a step is proportional to the number
// of modes, and an implicit stage is solved in closed form. So the run times are those of the methods.

/// Step of the implicit methods in s where none is given: as the core's method near contact.
const DEFAULT_STEP_S: f64 = 1e-6;

/// Step of the explicit method times the highest angular frequency where none is given; the method is stable up to 2.78.
const DEFAULT_RADIANS: f64 = 2.0;

/// Runs the scene from its start to its end.
pub(crate) fn bump_stop(scene: &Scene, model: &BumpStop, options: &Options) -> Result<Outcome, Failure> {
    check(scene, model, options)?;
    let system = System::new(model, scene.load);
    let mut march = March {
        base: BaseAcceleration::new(&scene.excitation),
        state: system.start(&model.initial),
        system: &system,
        steps: 0,
    };
    let began = ThreadTime::now();
    let mut meter = Meter::new(&system, &march.state);
    march.run(scene, options, &mut meter)?;
    let processor_s = began.elapsed().as_secs_f64();
    let method = match options.method {
        Method::Rk4 => "rk4",
        Method::TrBdf2 => "tr-bdf2",
        _ => "newmark",
    };
    Ok(Outcome {
        method: method.to_owned(),
        steps: march.steps,
        processor_s,
        ..meter.close(scene, model.stop.is_some(), &march.state)
    })
}

/// Refuses options and contact laws that these methods do not have.
fn check(scene: &Scene, model: &BumpStop, options: &Options) -> Result<(), Failure> {
    let refusals = [
        (
            options.precision == Some(Precision::F32),
            "--precision f32: must be f64 with this method, which is the host's for this scene",
        ),
        (
            options.math.is_some(),
            "--math: must not be given with this method, which uses that of the host for this scene",
        ),
        (options.tolerance.is_some(), "--tolerance: must not be given for a bump-stop scene; give --step"),
        (options.long_step_s.is_some(), "--long-step: must be with --method discrete-gradient"),
        (
            options.trace_every_s.is_some(),
            "--method: must be discrete-gradient or reference for a trace or a picture of a bump-stop scene",
        ),
    ];
    refuse_first(&refusals)?;
    if model.stop.is_some_and(|stop| stop.contact != Contact::ResidualFlexibility) {
        let text = "stop.contact: must be \"residual-flexibility\" with this method, which has no impacts and no \
                    constraints";
        return Err(Failure::of_file(scene, text));
    }
    Ok(())
}

/// A stretch of the run in equal steps, in s.
struct Span {
    from: f64,
    step: f64,
    count: u64,
}

impl Span {
    /// Equal steps of at most `step` that end at `to`; a step that divides the stretch is kept.
    fn new(from: f64, to: f64, step: f64) -> Self {
        let count = ((to - from) / step * (1.0 - 4.0 * f64::EPSILON)).ceil().max(1.0);
        Self { from, step: (to - from) / count, count: count as u64 }
    }
}

struct March<'a> {
    system: &'a System,
    base: BaseAcceleration<'a>,
    state: State,
    steps: u64,
}

impl March<'_> {
    /// Takes all steps, those before the measuring window first.
    fn run(&mut self, scene: &Scene, options: &Options, meter: &mut Meter<'_>) -> Result<(), Failure> {
        let system = self.system;
        let step = options.step_s.unwrap_or_else(|| match options.method {
            Method::Rk4 => DEFAULT_RADIANS / system.highest_angular_frequency(),
            _ => DEFAULT_STEP_S,
        }) * options.refinement();
        let [settled, end] = [scene.run.settle_s, scene.run.duration_s];
        for (from, to, measured) in [(0.0, settled, false), (settled, end, true)] {
            if to <= from {
                continue;
            }
            meter.measure(measured);
            let span = Span::new(from, to, step);
            match options.method {
                Method::Rk4 => self.through(&span, &mut RungeKutta4::new(system), meter)?,
                Method::TrBdf2 => self.through(&span, &mut Implicit::tr_bdf2(system, span.step), meter)?,
                _ => self.through(&span, &mut Implicit::newmark(system, span.step), meter)?,
            }
        }
        Ok(())
    }

    fn through(
        &mut self,
        span: &Span,
        stepper: &mut impl Stepper,
        meter: &mut Meter<'_>,
    ) -> Result<(), Failure> {
        let mut before = self.state.clone();
        for index in 0..span.count {
            let time = span.from + index as f64 * span.step;
            before.copy_from(&self.state);
            stepper.step(&mut self.state, &mut self.base, time, span.step);
            self.steps += 1;
            if !self.state.is_finite() {
                let [tip, _] = self.system.tip(&before);
                return Err(Failure::Step(format!(
                    "the motion is not finite after a step of {:e} s at {time} s: tip {tip:e} m, penetration {:e} \
                     m, voltage {:e} V",
                    span.step,
                    self.system.penetration(&before),
                    before.voltage
                )));
            }
            meter.add(&self.state, time, span.step);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;

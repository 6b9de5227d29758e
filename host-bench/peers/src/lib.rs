//! General integrators of other crates on the harvesters' equations, beside the embedded core alone.
//!
//! A scene of a fixed list is run by one method at one setting and gives the mean power in its measuring window ([`run`]). The methods
//! of the core run with the parts of the scene chosen at compile time and one power, as in a firmware. The peers integrate the same
//! equations in double precision, written here in the voltage at the terminals, with the delivered energy as a further state; impacts,
//! reversals, the corner of the overlap, the release from stick and the switching of a bridge are located on their dense output.

mod embedded;
mod load;
mod march;
mod method;
mod peer;
mod scene;
mod solver;

pub use self::method::Method;
use cpu_time::ThreadTime;
use harvester_scene::scene_file::{Model, Scene};
pub use method::{CASES, Case};

/// Why a run did not reach its end, or did not begin.
#[derive(Debug, Clone, PartialEq)]
pub enum Stop {
    /// The scene has something that the peers do not have.
    Refused(String),
    /// The integrator gave up.
    Integrator(String),
    /// The run was given up.
    TooManySteps {
        steps: f64,
        /// Simulated time in s.
        time_s: f64,
    },
    /// The motion left the range of the model.
    OutOfRange,
}

impl std::fmt::Display for Stop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Refused(reason) | Self::Integrator(reason) => write!(f, "{reason}"),
            Self::TooManySteps { steps, time_s } => {
                write!(f, "given up after {steps} steps at {time_s:.3} s")
            }
            Self::OutOfRange => write!(f, "the motion left the range of the model"),
        }
    }
}

/// What a run found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeerRun {
    /// Mean power in W delivered to the load in the measuring window.
    pub mean_power_w: f64,
    /// Host time in s per simulated second.
    pub seconds_per_simulated_second: f64,
    pub steps_per_simulated_second: f64,
}

pub(crate) struct Meter {
    began: ThreadTime,
    /// Energy in J delivered before the measuring window.
    before: f64,
    /// Energy in J delivered in the window.
    delivered: f64,
    processor_s: f64,
    steps: f64,
}

impl Meter {
    pub(crate) fn begin() -> Self {
        Self { began: ThreadTime::now(), before: 0.0, delivered: 0.0, processor_s: 0.0, steps: 0.0 }
    }

    /// Begins the measuring window, with so much energy in J delivered before.
    pub(crate) fn open(&mut self, delivered: f64) {
        self.before = delivered;
    }

    /// Ends the window and the run after so many steps.
    pub(crate) fn close(mut self, delivered: f64, steps: f64) -> Self {
        self.processor_s = self.began.elapsed().as_secs_f64();
        (self.delivered, self.steps) = (delivered - self.before, steps);
        self
    }
}

/// Runs a scene by a method at a setting of [`Method::settings`]; a scene of no duration is prepared only.
///
/// # Errors
/// [`Stop`].
pub fn run(scene: &Scene, method: Method, setting: f64) -> Result<PeerRun, Stop> {
    let meter = if method.peer().is_some() {
        peer::run(scene, method, setting)?
    } else {
        embedded::run(scene, method, setting)?
    };
    Ok(PeerRun {
        mean_power_w: meter.delivered / scene.run.window_s(),
        seconds_per_simulated_second: meter.processor_s / scene.run.duration_s,
        steps_per_simulated_second: meter.steps / scene.run.duration_s,
    })
}

/// Whether a method is one for the kind of a scene.
pub fn fits(scene: &Scene, method: Method) -> bool {
    match method {
        Method::DiscreteGradient => matches!(scene.model, Model::BumpStop(_)),
        Method::ExponentialRadau | Method::TrBdf2 | Method::Rk4 => !matches!(scene.model, Model::BumpStop(_)),
        _ => true,
    }
}

#[cfg(test)]
mod tests;

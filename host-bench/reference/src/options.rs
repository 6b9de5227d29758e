//! Options of a reference run, and its error.

/// How accurate, and what to record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceOptions {
    /// Relative tolerance of the integrator. The bump-stop reference is exact and does not use it.
    pub tolerance: f64,
    /// Distance of recorded rows in s; `None`: no recording.
    pub record_every: Option<f64>,
    /// Steps of a triboelectric scene after which the run is given up at the next event.
    pub most_steps: Option<u64>,
}

impl Default for ReferenceOptions {
    /// A tolerance of 10⁻¹². A tenfold tighter one changes the results of the shipped scenes by a few 10⁻¹¹
    /// and brings the Newton iteration near to rounding.
    fn default() -> Self {
        Self { tolerance: 1e-12, record_every: None, most_steps: None }
    }
}

/// A run that could not be finished.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{reason} at {time_s} s ({state})")]
pub struct StepFailure {
    /// What went wrong.
    pub reason: String,
    /// Simulated time in s.
    pub time_s: f64,
    /// The last good state, in words.
    pub state: String,
}

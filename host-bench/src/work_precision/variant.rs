//! What a row runs: method, precision, elementary functions, and the step or tolerance.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::method::{Math, Method, Options, Precision};

/// How a row's step is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Control {
    /// Fixed, a period of the excitation over this number.
    PerPeriod {
        steps: u32,
        /// The period in s.
        period_s: f64,
    },
    /// Fixed.
    Step {
        /// The step in s; of two rates, the step near contact.
        step_s: f64,
        /// The step in s in free flight, of two rates.
        long_step_s: Option<f64>,
    },
    /// Adaptive with this relative tolerance.
    Tolerance(f64),
    /// The method's own.
    Default,
}

impl std::fmt::Display for Control {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::PerPeriod { steps, .. } => write!(f, "T/{steps}"),
            Self::Step { step_s, .. } => write!(f, "{} us", microseconds(*step_s)),
            Self::Tolerance(tolerance) => write!(f, "{tolerance:.0e}"),
            Self::Default => write!(f, "default"),
        }
    }
}

/// A time in µs, to a hundredth.
pub(super) fn microseconds(seconds: f64) -> f64 {
    (seconds * 1e8).round() / 1e2
}

impl Serialize for Control {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        match self {
            Self::Step { step_s, long_step_s } => {
                map.serialize_entry("step_s", step_s)?;
                map.serialize_entry("long_step_s", long_step_s)?;
            }
            other => map.serialize_entry("control", &other.to_string())?,
        }
        map.end()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Variant {
    pub(crate) method: Method,
    pub(crate) precision: Precision,
    /// Elementary functions of the core; `None` for those of the host, and for the core's own choice.
    pub(crate) math: Option<Math>,
    #[serde(flatten)]
    pub(crate) control: Control,
}

impl Variant {
    /// The integrator of the reference.
    pub(super) fn reference(control: Control) -> Self {
        Self { method: Method::Reference, precision: Precision::F64, math: None, control }
    }

    pub(super) fn options(&self) -> Options {
        let mut options = Options {
            method: self.method,
            precision: (self.method != Method::Reference).then_some(self.precision),
            math: self.math,
            ..Options::default()
        };
        match self.control {
            Control::PerPeriod { steps, period_s } => options.step_s = Some(period_s / f64::from(steps)),
            Control::Step { step_s, long_step_s } => {
                (options.step_s, options.long_step_s) = (Some(step_s), long_step_s);
            }
            Control::Tolerance(tolerance) => options.tolerance = Some(tolerance),
            Control::Default => {}
        }
        options
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extent {
    /// Most timed runs of each row.
    pub(crate) runs: usize,
    /// Seconds of processor time after which a row that was timed twice is not run again.
    pub(crate) seconds_per_row: f64,
    /// Whether all methods are run with all math backends, all peers and all steps.
    pub(crate) whole: bool,
}

impl Extent {
    pub(crate) const WHOLE: Self = Self { runs: 5, seconds_per_row: 3.0, whole: true };
    /// What fits in half a minute.
    pub(crate) const SHORT: Self = Self { runs: 5, seconds_per_row: 0.3, whole: false };
}

//! The least margins of a run to the limits of its model.

use serde::Serialize;

use crate::scene_file::limit_of_name;

/// Beginning of a warning where nothing real is beyond the limit.
pub const LIMIT: &str = "limit:";
/// Beginning of a warning where the result is inaccurate beyond the limit.
pub const MODEL: &str = "model:";

/// The least margins of a whole run, its start included; of an orbit that was found by shooting, of one period.
///
/// There are none by the reference, and by the peers of a bump-stop scene.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Margins {
    /// That to each limit of the model.
    pub limits: Vec<Margin>,
    /// The smallest of them; `None` where no limit is approached.
    pub smallest_margin: Option<f64>,
    /// The smallest to a limit beyond which nothing real is.
    pub impossible_margin: Option<f64>,
}

impl Margins {
    /// With the smallest of the margins.
    pub fn new(limits: Vec<Margin>) -> Self {
        let least = |counts: fn(&str) -> bool| {
            let margins = limits.iter().filter(|found| counts(found.name)).filter_map(|found| found.margin);
            margins.min_by(f64::total_cmp)
        };
        let is_impossible = |name: &str| limit_of_name(name).is_some_and(|(.., error)| error.is_none());
        Self { smallest_margin: least(|_| true), impossible_margin: least(is_impossible), limits }
    }
}

/// The least margin of a run to one limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margin {
    /// Name of the compared quantity, with its unit.
    pub name: &'static str,
    /// Magnitude of the quantity at the least margin.
    pub value: f64,
    /// Its limit there; infinite, and `null` in JSON, where there is none.
    pub limit: f64,
    /// Limit over value; `None` where the value is 0 or has no limit.
    pub margin: Option<f64>,
    /// Time of the least margin in s.
    pub at_s: f64,
}

impl Margin {
    /// What to know where the margin is below 1; begins with [`LIMIT`] or [`MODEL`].
    pub fn warning(&self) -> Option<String> {
        let Self { name, value, limit, at_s, .. } = *self;
        let margin = self.margin.filter(|margin| *margin < 1.0)?;
        let (_, beyond, error) = limit_of_name(name)?;
        let what = format!("{name} = {value:.3e} at {at_s:.5} s");
        let said = format!("{what} is above {limit:.3e} (margin {margin:.3}): {beyond}");
        Some(match error {
            None => format!("{LIMIT} {said}"),
            Some(error) => format!("{MODEL} {said}; relative error about {:.1e}", error(value, limit)),
        })
    }
}

//! The numbers of a bump-stop run only.

use serde::Serialize;

/// The numbers of a bump-stop run only.
///
/// Without a stop there are no contacts, and the numbers of the stop are `None`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BumpStopOutcome {
    /// Natural frequencies in Hz of the modes kept, short-circuit and undamped: those of the beam,
    /// rising, then those of the rod, rising.
    pub natural_frequencies_hz: Vec<f64>,
    /// Largest magnitude in the window of the displacement of the beam's tip relative to the base, in m.
    pub peak_tip_displacement_m: Option<f64>,
    /// Largest magnitude in the window of the displacement in m of the beam at the stop; `None` without a stop.
    pub peak_stop_point_displacement_m: Option<f64>,
    /// Contacts that begin in the window: intervals with a force, and rigid impacts.
    pub contacts: u64,
    /// Contacts over periods in the window; `None` unless the base moves in one sine.
    pub contacts_per_period: Option<f64>,
    /// Part of the window during which beam and stop are in contact.
    pub contact_fraction: Option<f64>,
    /// Time of the first contact of the run in s; `None` without contacts.
    pub first_contact_s: Option<f64>,
    /// Largest contact force in the window in N, without rigid impacts, which have none; `None` without a stop.
    pub peak_force_n: Option<f64>,
    /// Mean contact force over the window in N, the momentum of impacts included; `None` without a
    /// stop.
    pub mean_force_n: Option<f64>,
    /// State at the end of the run, scaled so that half the sum of squares is the energy in J of motion and
    /// charge: `ω r` and `r'` of each mode, the beam's first, and `√C v`. Not part of the JSON object.
    #[serde(skip)]
    pub end_state: Vec<f64>,
}

/// Columns of a recording of a bump-stop run. Without a stop the two columns of the stop are not-a-number.
pub const BUMP_STOP_COLUMNS: [&str; 7] = [
    "time_s",
    "tip_displacement_m",
    "stop_point_displacement_m",
    "rod_tip_displacement_m",
    "voltage_v",
    "contact_force_n",
    "base_acceleration_m_per_s2",
];

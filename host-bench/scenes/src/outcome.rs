//! The numbers of a run: the same for every method, as the JSON object that `run` prints.

mod accuracy;
mod bump_stop;
mod format;

use serde::Serialize;

use crate::scene_file::limit_of_name;

pub use self::accuracy::{Accuracy, CreatedEnergy, created_energy_warning};
pub use self::bump_stop::{BUMP_STOP_COLUMNS, BumpStopOutcome, ClampOutcome};
pub use self::format::{
    Fields, Format, WIDTH, cell, csv, csv_line, csv_sections, fields, flattened, folded, name, number,
    optional_number, rows_csv, shown, small, table, text,
};

/// The result of one run.
///
/// Numbers that do not exist (a mean over an empty window, a ratio to zero) are `None`. In JSON they are `null`, as those not finite.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Outcome {
    /// Name of the scene.
    pub scene: &'static str,
    /// Method used.
    pub method: String,
    /// Precision of the numbers: `f32` or `f64`.
    pub precision: &'static str,
    /// Elementary functions: `polynomial`, `libm`, `micromath`, or `std` for the reference.
    pub math: &'static str,
    /// End of the run in s.
    pub duration_s: f64,
    /// Start of the measuring window in s.
    pub settle_s: f64,
    /// Mean power over the window in W into the load: the resistor, or the storage or bus behind a bridge.
    pub mean_power_w: Option<f64>,
    /// Standard error in W of a mean power that is that of an ensemble of displaced starts; `None` where the motion is not
    /// chaotic. Every other number is that of the scene's own start.
    pub mean_power_standard_error_w: Option<f64>,
    /// Root mean square of the terminal voltage over the window in V.
    pub rms_voltage_v: Option<f64>,
    /// Largest magnitude of the terminal voltage in the window in V.
    pub peak_voltage_v: Option<f64>,
    /// Mean of the terminal voltage over the window in V.
    pub mean_voltage_v: Option<f64>,
    /// Energy delivered to the load in the window in J.
    pub delivered_energy_j: Option<f64>,
    /// Energy that the force law created in the window. Absent in bump-stop scenes.
    #[serde(flatten)]
    pub created: Option<CreatedEnergy>,
    /// Root mean square of a random base acceleration in m/s², by its spectral density. Absent for any other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_rms_m_per_s2: Option<f64>,
    /// Residual of the energy ledger of the run, over the larger of `∫ |base power| dt` and the peak stored energy.
    pub energy_residual: Option<f64>,
    /// Accepted steps, whole run.
    pub steps: u64,
    /// Rejected steps, whole run.
    pub rejected_steps: u64,
    /// Newton iterations, whole run.
    pub newton_iterations: u64,
    /// Events, whole run.
    pub events: u64,
    /// Processor time of the run on the host in s, without the runs for the accuracy statement.
    pub processor_s: f64,
    /// Estimated relative error of the mean power.
    pub accuracy: Accuracy,
    /// The steady motions that displaced starts lead to, that of this run first; `None` where they all lead to the motion of
    /// this run, or none was made.
    pub branches: Option<Vec<Branch>>,
    /// Least margins of the whole run to the limits of its model.
    #[serde(flatten)]
    pub margins: Margins,
    /// What to know before the numbers are used. A warning about the accuracy begins with `accuracy:`, one about other
    /// steady motions with `attractors:`, one about a limit with `limit:` or `model:`.
    pub warnings: Vec<String>,
    /// The storage behind a bridge at the end of the run.
    #[serde(flatten)]
    pub store: Option<StoreOutcome>,
    /// The numbers of this kind of scene only.
    #[serde(flatten)]
    pub particular: Particular,
    /// The result of shooting for the steady state, if it was asked for.
    #[serde(flatten)]
    pub steady_state: Option<SteadyState>,
    /// The motion over time, if it was asked for; not part of the JSON object.
    #[serde(skip)]
    pub trace: Option<Recording>,
    /// Where the energy of the whole run went; not part of the JSON object. Only the embedded core keeps it.
    #[serde(skip)]
    pub flow: Option<EnergyFlow>,
    /// Energy in J delivered in each of [`BLOCKS`] parts of the window, if asked for; not part of the JSON object.
    #[serde(skip)]
    pub block_energies_j: Vec<f64>,
}

/// A steady motion and a start that leads to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Branch {
    /// Mean power delivered to the load in W.
    pub mean_power_w: Option<f64>,
    /// Number of periods of the one sine after which the motion repeats; `None` of a motion that does not within 16 periods.
    pub period: Option<usize>,
    /// Part of the starts that lead to the motion.
    pub share: f64,
    /// Number of all starts.
    pub starts: usize,
    /// Gap, displacement of the slider or of the tip in m at the start.
    pub displacement_m: f64,
    /// Its velocity in m/s at the start.
    pub velocity_m_per_s: f64,
}

/// Number of parts of the measuring window whose energies are compared between two runs.
pub const BLOCKS: usize = 16;

/// The standard error of the sum of the values of equal parts; not-a-number of fewer than two.
pub fn standard_error_of_sum(parts: &[f64]) -> f64 {
    let count = parts.len() as f64;
    let mean = parts.iter().sum::<f64>() / count;
    let squares: f64 = parts.iter().map(|part| (part - mean).powi(2)).sum();
    (squares * count / (count - 1.0)).sqrt()
}

impl Outcome {
    /// The numbers of a contact-separation scene, if it is one.
    pub fn contact_separation(&self) -> Option<&ContactSeparationOutcome> {
        if let Particular::ContactSeparation(found) = &self.particular { Some(found) } else { None }
    }

    /// The numbers of a sliding scene, if it is one.
    pub fn sliding(&self) -> Option<&SlidingOutcome> {
        if let Particular::Sliding(found) = &self.particular { Some(found) } else { None }
    }

    /// The numbers of a bump-stop scene, if it is one.
    pub fn bump_stop(&self) -> Option<&BumpStopOutcome> {
        if let Particular::BumpStop(found) = &self.particular { Some(found) } else { None }
    }

    /// The largest gap, the amplitude of the slider, or the largest displacement of the tip in m, in the window.
    pub fn largest_motion_m(&self) -> Option<f64> {
        match &self.particular {
            Particular::ContactSeparation(found) => found.peak_gap_m,
            Particular::Sliding(found) => found.amplitude_m,
            Particular::BumpStop(found) => found.peak_tip_displacement_m,
        }
    }

    /// Whether the numbers are those of a stable orbit that shooting found.
    pub fn is_of_an_orbit(&self) -> bool {
        self.steady_state.as_ref().is_some_and(|found| found.steady_state == STABLE)
    }
}

/// The verdict of shooting with which the numbers are those of an orbit.
pub const STABLE: &str = "stable-period-1";

/// The result of shooting for the periodic steady state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SteadyState {
    /// `stable-period-1`: the numbers are those of one period of a stable orbit, from `settle_s` to `duration_s`.
    /// Otherwise they are those of the scene's own run, because shooting found an `unstable-period-1` orbit only, or a
    /// stable orbit that the scene's start does not lead to (`stable-period-1-not-reached`), or `none`.
    pub steady_state: &'static str,
    /// Magnitude of the orbit's largest Floquet multiplier; `None` without an orbit.
    pub largest_multiplier: Option<f64>,
    /// Without an orbit: the change of the state over a period that the search left, in units of half the range of each
    /// coordinate (the root of the sum of the squares).
    pub steady_state_residual: Option<f64>,
    /// Simulated periods of the whole search, and of the run if there was one.
    pub simulated_periods: f64,
}

/// The storage behind a bridge at the end of the run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StoreOutcome {
    /// Voltage of the storage or bus in V.
    pub store_voltage_v: Option<f64>,
    /// Mean current into the storage or bus over the window in A: the charge that it takes per second. `None` where it
    /// was not integrated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_store_current_a: Option<f64>,
    /// Energy in the storage in J; `None` for a bus.
    pub stored_energy_j: Option<f64>,
    /// Energy lost in the diodes over the whole run in J.
    pub diode_loss_j: Option<f64>,
    /// Energy that leaked from the storage over the whole run in J.
    pub leaked_energy_j: Option<f64>,
    /// Energy that the node drew over the whole run in J.
    pub drawn_energy_j: Option<f64>,
    /// The whole cycles of the switch of the draw in the window; not part of the JSON object. `None` without one, or if the
    /// parts of the window were not asked for.
    #[serde(skip)]
    pub cycles: Option<SwitchCycles>,
}

/// Means over whole cycles of the switch of a draw, from one turn-on to another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SwitchCycles {
    /// Number of cycles.
    pub count: u64,
    /// First and last turn-on in s.
    pub from_s: f64,
    pub until_s: f64,
    /// Mean power into the storage in W.
    pub mean_power_w: f64,
    /// Root mean square of the terminal voltage in V.
    pub rms_voltage_v: f64,
    /// Mean voltage of the storage in V.
    pub mean_store_voltage_v: f64,
}

/// The numbers of one kind of scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Particular {
    ContactSeparation(ContactSeparationOutcome),
    Sliding(SlidingOutcome),
    BumpStop(BumpStopOutcome),
}

impl Default for Particular {
    fn default() -> Self {
        Self::Sliding(SlidingOutcome::default())
    }
}

/// The numbers of a contact-separation run only.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ContactSeparationOutcome {
    /// Natural frequency in Hz of the mass on its spring, undamped and without the electrostatic force.
    pub natural_frequency_hz: Option<f64>,
    /// Largest gap in the window in m.
    pub peak_gap_m: Option<f64>,
    /// Smallest gap in the window in m.
    pub min_gap_m: Option<f64>,
    /// Impacts in the window, those that end in sticking included.
    pub impacts: u64,
    /// Impacts over periods in the window; `None` unless the base moves in one sine.
    pub impacts_per_period: Option<f64>,
    /// Largest impact speed in the window in m/s; `None` without impacts.
    pub max_impact_speed_m_per_s: Option<f64>,
    /// Time of the first impact of the run in s; `None` without impacts, and for an orbit, which has no start.
    pub first_impact_s: Option<f64>,
    /// Part of the window during which the mass sticks.
    pub stuck_fraction: Option<f64>,
}

/// Columns of a recording of a contact-separation run.
pub const CONTACT_SEPARATION_COLUMNS: [&str; 7] = triboelectric_columns("gap_m");

const fn triboelectric_columns(position: &'static str) -> [&'static str; 7] {
    ["time_s", position, "velocity_m_per_s", "charge_c", "voltage_v", "base_acceleration_m_per_s2", "stuck"]
}

/// The numbers of a sliding run only.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct SlidingOutcome {
    /// Natural frequency in Hz of the undamped beam with its slider, free of friction.
    pub natural_frequency_hz: Option<f64>,
    /// Largest magnitude of the displacement in the window in m.
    pub peak_displacement_m: Option<f64>,
    /// Half the distance in m between the largest and the smallest displacement in the window.
    pub amplitude_m: Option<f64>,
    /// Part of the window during which the slider sticks.
    pub stick_fraction: Option<f64>,
    /// Entries into stick in the window over the periods in it; `None` unless the base moves in one sine.
    pub sticks_per_period: Option<f64>,
}

/// Columns of a recording of a sliding run.
pub const SLIDING_COLUMNS: [&str; 7] = triboelectric_columns("displacement_m");

/// Columns of a recording behind a bridge: the columns without a bridge, and the voltage of the storage or bus.
pub const fn with_store(columns: [&'static str; 7]) -> [&'static str; 8] {
    let [one, two, three, four, five, six, seven] = columns;
    [one, two, three, four, five, six, seven, "store_voltage_v"]
}

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

/// The recorded motion: columns by name, one row for each instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Name of each column, unit included.
    pub columns: &'static [&'static str],
    /// One value for each column.
    pub rows: Vec<Vec<f64>>,
    /// Instants of impacts in s. Only the embedded core records them.
    pub impacts_s: Vec<f64>,
}

/// Where the energy of a whole run went, in J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyFlow {
    /// Work of the base on the harvester.
    pub base_j: f64,
    /// Lost to damping and friction.
    pub dissipated_j: f64,
    /// Lost in impacts and contacts.
    pub contact_j: f64,
    /// Delivered to the resistor, or behind a bridge to the storage or bus.
    pub delivered_j: f64,
    /// Lost in the diodes of a bridge.
    pub diodes_j: f64,
    /// What the field gained from the motion less what the motion lost to the force.
    pub created_j: f64,
}

impl EnergyFlow {
    /// Names and energies: what comes in, where it goes, and what is left of it.
    pub fn parts(&self) -> Vec<(&'static str, f64)> {
        let Self { base_j, dissipated_j, contact_j, delivered_j, diodes_j, created_j } = *self;
        let left_j = base_j + created_j - dissipated_j - contact_j - delivered_j - diodes_j;
        vec![
            ("from the base", base_j),
            ("created by the force law", created_j),
            ("damping and friction", dissipated_j),
            ("contact", contact_j),
            ("diodes", diodes_j),
            ("into the load", delivered_j),
            ("left in motion and field", left_j),
        ]
    }
}

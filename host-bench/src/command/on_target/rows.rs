//! The rows of the reports: each is a workload measured on a core.

use serde_json::{Map, Value, json};

use crate::on_target::native::Reference;
use crate::on_target::qemu::Core;
use crate::on_target::{Bench, Error, Stretch, Workload};
use crate::scene_file::{Load, Scene};
use firmware_example::workload::Variant;

/// Name of the method of the triboelectric scenes.
pub(super) const RADAU: &str = "exponential Radau";

#[derive(Debug, Clone, Copy, Default)]
pub(super) enum Steps {
    /// A relative tolerance per radian.
    Tolerance(f32),
    /// One length in seconds.
    Fixed(f32),
    /// The lengths near contact and in free flight, in seconds.
    ShortAndLong([f32; 2]),
    /// A computation without steps.
    #[default]
    None,
}

impl Steps {
    pub(super) fn text(self) -> String {
        match self {
            Self::Tolerance(tolerance) => format!("tolerance {tolerance}"),
            Self::Fixed(step) => format!("step {} ms", step * 1e3),
            Self::ShortAndLong([short, long]) => format!("steps {} and {} us", short * 1e6, long * 1e6),
            Self::None => String::new(),
        }
    }
}

#[derive(Debug, Clone, Default)]
pub(super) struct Case {
    pub(super) name: String,
    pub(super) scene: &'static str,
    /// Resistance of the load; `None` without a load.
    pub(super) load_ohm: Option<f64>,
    pub(super) method: &'static str,
    pub(super) steps: Steps,
    /// `None` for what has no mean power.
    pub(super) reference: Option<Reference>,
    /// Whether a table shows the error of the RMS voltage in place of that of the mean power.
    pub(super) by_voltage: bool,
    /// Whether a step of the log is a sample of an accelerometer.
    pub(super) by_sample: bool,
    /// Start of the time over which instructions are counted, in microseconds.
    pub(super) counted_from_us: u64,
    /// Relative errors of runs on the host beside the measured one.
    pub(super) host_errors: Vec<Option<f64>>,
}

impl Case {
    /// A computation without a reference.
    pub(super) fn new(name: impl Into<String>, scene: &'static str, method: &'static str) -> Self {
        Self { name: name.into(), scene, method, ..Self::default() }
    }

    /// A run that is compared with the reference of `scene`.
    pub(super) fn of_scene(
        name: impl Into<String>,
        scene: &Scene,
        method: &'static str,
        steps: Steps,
    ) -> Result<Self, Error> {
        let load_ohm = match scene.load {
            Load::Resistor { resistance_ohm } => Some(resistance_ohm),
            _ => None,
        };
        let reference = Some(Reference::new(scene)?);
        let by_voltage = scene.name() == "bump-stop";
        Ok(Self { load_ohm, steps, reference, by_voltage, ..Self::new(name, scene.name(), method) })
    }
}

pub(super) struct Row {
    pub(super) case: Case,
    pub(super) core: Core,
    pub(super) variant: &'static str,
    /// Flash in bytes that all workloads of the firmware add to an empty one.
    pub(super) flash: u64,
    /// Static variables of the whole firmware, in bytes.
    pub(super) static_ram: u64,
    pub(super) workload: Workload,
}

/// Measures `variant`, whose workloads `cases` describe in order.
pub(super) fn measure(bench: &Bench, variant: &Variant, cases: Vec<Case>) -> Result<Vec<Row>, Error> {
    let core = bench.core();
    let measurement = bench.measure(variant)?;
    let found = measurement.workloads.len();
    if found != cases.len() {
        let what = format!("{}: {found} workloads, not {}", variant.name, cases.len());
        return Err(Error::Core { core, what });
    }
    let (flash, static_ram) = (measurement.flash, measurement.size.static_ram);
    let row = |(case, workload)| Row { case, core, variant: variant.name, flash, static_ram, workload };
    Ok(cases.into_iter().zip(measurement.workloads).map(row).collect())
}

impl Row {
    pub(super) fn counted(&self) -> Stretch {
        self.workload.after(self.case.counted_from_us)
    }

    /// Instructions for a simulated second; `None` without simulated time.
    fn instructions_per_second(&self) -> Option<f64> {
        let counted = self.counted();
        (counted.seconds > 0.0).then(|| counted.instructions_per_second())
    }

    /// Relative error of the mean power or of the RMS voltage, as a table shows it.
    pub(super) fn error(&self) -> String {
        let samples = &self.workload.samples;
        percent(self.case.reference.and_then(|reference| {
            if self.case.by_voltage {
                reference.voltage_error(samples)
            } else {
                reference.power_error(samples)
            }
        }))
    }

    /// The row as a JSON object; `null` stands for what was not measured.
    pub(super) fn json(&self) -> Value {
        let Self { case, core, workload, .. } = self;
        let mut fields = Map::new();
        let mut put = |key: &str, value: Value| fields.insert(key.to_owned(), value);
        put("core", json!(core.to_string()));
        put("scene", json!(case.scene));
        put("variant", json!(self.variant));
        put("case", json!(case.name));
        put("load_ohm", json!(case.load_ohm));
        put("method", json!(case.method));
        match case.steps {
            Steps::Tolerance(tolerance) => put("tolerance", short(tolerance)),
            Steps::Fixed(step) => put("step_s", short(step)),
            Steps::ShortAndLong([step, long]) => {
                put("step_s", short(step));
                put("long_step_s", short(long))
            }
            Steps::None => None,
        };
        let error = case.reference.and_then(|reference| reference.power_error(&workload.samples));
        put("instructions_per_simulated_second", json!(self.instructions_per_second()));
        put("mean_power_error", json!(error));
        put("flash_bytes", json!(self.flash));
        put("ram_bytes", json!(self.static_ram));
        put("stack_bytes", json!(workload.stack));
        let key = if case.by_sample { "instructions_per_sample" } else { "instructions_per_step" };
        put(key, json!(self.counted().instructions_per_step()));
        Value::Object(fields)
    }
}

/// The shortest decimal number that is nearest to `value` in single precision.
fn short(value: f32) -> Value {
    json!(value.to_string().parse::<f64>().unwrap_or_default())
}

/// A relative error or change as a table shows it, without a sign where it rounds to nothing.
pub(in crate::command) fn percent(error: Option<f64>) -> String {
    let shown = |error: f64| format!("{:.3} %", 100.0 * error).replace("-0.000 %", "0.000 %");
    error.map_or_else(|| "-".to_owned(), shown)
}

/// A column of a table: its heading, and the text of a row.
pub(super) type Column = (&'static str, fn(&Row) -> String);

pub(super) const CORE: Column = ("core", |row| row.core.to_string());
pub(super) const LOAD: Column =
    ("load in ohm", |row| row.case.load_ohm.map_or_else(String::new, |load_ohm| format!("{load_ohm:e}")));
pub(super) const METHOD: Column = ("method", |row| row.case.method.to_owned());
pub(super) const SETTING: Column = ("setting", |row| row.case.steps.text());
pub(super) const STEPS: Column = ("steps", |row| row.counted().steps.to_string());
pub(super) const STEPS_PER_SECOND: Column = ("steps per second", |row| {
    let counted = row.counted();
    format!("{:.0}", counted.steps as f64 / counted.seconds)
});
pub(super) const PER_STEP: Column =
    ("instructions per step", |row| format!("{:.0}", row.counted().instructions_per_step()));
pub(super) const PER_SECOND: Column = ("per simulated second", |row| {
    row.instructions_per_second().map_or_else(|| "-".to_owned(), |instructions| format!("{instructions:.0}"))
});
pub(super) const ERROR: Column = ("error", |row| row.error());
pub(super) const FLASH: Column = ("flash", |row| row.flash.to_string());
pub(super) const STATIC_RAM: Column = ("static RAM", |row| row.static_ram.to_string());
pub(super) const STACK: Column = ("stack", |row| row.workload.stack.to_string());

#[cfg(test)]
mod tests {
    use super::*;
    use crate::on_target::decode::Sample;

    fn row(case: Case) -> Row {
        let energy = 1.02e-6_f32.to_bits();
        let sample =
            Sample { simulated_us: 500_000, steps: 400, ticks: 8_000, bits: vec![0, 0, 0, 0, energy] };
        let workload = Workload {
            name: "run".to_owned(),
            stack: 1364,
            samples: vec![sample],
            instructions_per_tick: 6.25,
        };
        let variant = "contact_separation::bench";
        Row { case, core: Core::M4f, variant, flash: 13_816, static_ram: 16, workload }
    }

    #[test]
    fn a_run_has_its_costs_its_setting_and_its_error() {
        let case = Case {
            load_ohm: Some(1e8),
            steps: Steps::Tolerance(0.05),
            reference: Some(Reference { power: 2e-6, settle_us: 0 }),
            ..Case::new("whole", "contact-separation", "TR-BDF2")
        };
        let mut found = row(case).json();
        let error = found["mean_power_error"].take().as_f64().expect("a number");
        assert!((error - 0.02).abs() < 1e-6, "{error}");
        let expected = json!({
            "core": "Cortex-M4F",
            "scene": "contact-separation",
            "variant": "contact_separation::bench",
            "case": "whole",
            "load_ohm": 1e8,
            "method": "TR-BDF2",
            "tolerance": 0.05,
            "instructions_per_simulated_second": 100_000.0,
            "mean_power_error": null,
            "flash_bytes": 13_816,
            "ram_bytes": 16,
            "stack_bytes": 1364,
            "instructions_per_step": 125.0,
        });
        assert_eq!(found, expected);
    }

    #[test]
    fn an_estimator_has_instructions_per_sample_and_no_error() {
        let case = Case {
            steps: Steps::ShortAndLong([9e-6, 80e-6]),
            by_sample: true,
            ..Case::new("estimator", "bump-stop", "discrete gradient")
        };
        let found = row(case).json();
        assert_eq!(found["instructions_per_sample"], 125.0);
        assert_eq!([&found["step_s"], &found["long_step_s"]], [9e-6, 8e-5]);
        assert!(found["mean_power_error"].is_null() && found.get("instructions_per_step").is_none());
    }
}

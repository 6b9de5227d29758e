//! One run of a figure: the shipped scene at another charge density, load and frequency.

use crate::figures::sine;
use crate::method::{Failure, Options, Precision};
use crate::outcome::{ContactSeparationOutcome, Outcome, Particular};
use crate::run::run_scene;
use crate::scene_file::{Excitation, Load, RunSpan, Scene, Tone};

/// Periods of the excitation that are measured.
pub(crate) const WINDOW: u32 = 100;

/// The values that differ from the shipped scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Case {
    /// Tribo-charge density in µC/m².
    pub charge_density: f64,
    /// Load resistance in MΩ.
    pub resistance: f64,
    /// Frequency of the excitation in Hz.
    pub frequency: f64,
    /// Periods of the excitation before those that are measured.
    pub settle: u32,
}

impl Case {
    /// Periods of the excitation from the start to the end.
    pub(crate) fn end(&self) -> u32 {
        self.settle + WINDOW
    }

    /// The scene of this case, at rest at the initial gap as in the scene file, with its options.
    pub(super) fn point(&self, base: &Scene, tolerance: f64) -> Result<(Scene, Options), Failure> {
        let mut scene = base.clone();
        scene.contact_separation_mut()?.parameters.charge_density_c_per_m2 = self.charge_density * 1e-6;
        scene.load = Load::Resistor { resistance_ohm: self.resistance * 1e6 };
        scene.excitation = Excitation::Sine(Tone { frequency_hz: self.frequency, ..*sine(base)? });
        scene.run = RunSpan {
            duration_s: f64::from(self.end()) / self.frequency,
            settle_s: f64::from(self.settle) / self.frequency,
        };
        let precision = Some(Precision::F64);
        Ok((scene, Options { precision, tolerance: Some(tolerance), ..Options::default() }))
    }

    /// The outcome of the run, over the measuring window, and its numbers of this scene only.
    fn run(
        &self,
        base: &Scene,
        tolerance: f64,
        trace_every_s: Option<f64>,
    ) -> Result<(Outcome, ContactSeparationOutcome), Failure> {
        let (scene, options) = self.point(base, tolerance)?;
        let outcome = run_scene(&scene, &Options { trace_every_s, ..options }).map_err(|failure| {
            let Self { charge_density, resistance, frequency, .. } = self;
            failure.of_case(&format!("{charge_density} uC/m^2, {resistance} megohm, {frequency} Hz"))
        })?;
        match outcome.particular.clone() {
            Particular::ContactSeparation(found) => Ok((outcome, found)),
            _ => Err(Failure::Input("another scene was run".to_owned())),
        }
    }

    /// The run's numbers over the measuring window.
    pub(crate) fn response(&self, base: &Scene, tolerance: f64) -> Result<Response, Failure> {
        let (outcome, found) = self.run(base, tolerance, None)?;
        let Outcome { rms_voltage_v, mean_power_w, .. } = outcome;
        Ok(Response { frequency: self.frequency, found, rms_voltage_v, mean_power_w })
    }

    /// The gap over time, `per_period` times a period, from period `from` on.
    pub(crate) fn motion(
        &self,
        base: &Scene,
        tolerance: f64,
        per_period: u32,
        from: u32,
    ) -> Result<Motion, Failure> {
        let every = 1.0 / (self.frequency * f64::from(per_period));
        let (outcome, found) = self.run(base, tolerance, Some(every))?;
        let rows = outcome.trace.as_ref().map(|trace| trace.rows.as_slice()).unwrap_or_default();
        // The time of a row is its number times the distance of the rows. Rounding of the time may drop the last row.
        let periods = (0..self.end() * per_period).map(|row| f64::from(row) / f64::from(per_period));
        let first = f64::from(from);
        let instants = outcome.trace.iter().flat_map(|trace| trace.impacts_s.iter());
        let rows = periods.zip(rows).skip((from * per_period) as usize);
        Ok(Motion {
            frequency: self.frequency,
            hits: instants.map(|instant| instant * self.frequency).filter(|hit| *hit >= first).collect(),
            gaps: rows.filter_map(|(period, row)| Some((period, *row.get(1)?))).collect(),
            impacts: found.impacts,
        })
    }

    /// The gap in m at the start of each period of the measuring window.
    pub(crate) fn stroboscopic(&self, base: &Scene, tolerance: f64) -> Result<Vec<f64>, Failure> {
        Ok(self.motion(base, tolerance, 1, self.settle)?.gaps.into_iter().map(|(_, gap)| gap).collect())
    }
}

/// The gap over time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Motion {
    /// Frequency of the excitation in Hz.
    pub frequency: f64,
    /// Periods since the start, gap in m.
    pub gaps: Vec<(f64, f64)>,
    /// Periods since the start at which the mass hits the dielectric.
    pub hits: Vec<f64>,
    /// Number of impacts in the measuring window.
    pub impacts: u64,
}

/// The numbers of a run, over its measuring window.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Response {
    /// Frequency of the excitation in Hz.
    pub frequency: f64,
    pub found: ContactSeparationOutcome,
    /// Root mean square of the voltage in V.
    pub rms_voltage_v: Option<f64>,
    /// Mean power in W.
    pub mean_power_w: Option<f64>,
}

/// Frequencies at equal distances, in hundredths of a hertz so that each is the number nearest to its decimal form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Grid {
    /// The first.
    pub from: u16,
    /// The last, if a whole number of steps leads there.
    pub to: u16,
    /// Their distance.
    pub step: u16,
}

impl Grid {
    /// The frequencies in Hz.
    pub(crate) fn frequencies(self) -> impl Iterator<Item = f64> {
        (self.from..=self.to)
            .step_by(usize::from(self.step.max(1)))
            .map(|hundredths| f64::from(hundredths) / 100.0)
    }

    /// First and last frequency in Hz.
    pub(crate) fn span(self) -> [f64; 2] {
        [self.from, self.to].map(|hundredths| f64::from(hundredths) / 100.0)
    }
}

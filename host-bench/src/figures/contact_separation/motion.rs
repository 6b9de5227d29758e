//! One run of a figure, the shipped scene with other values; and figure 9, the gap over time where impacts begin and end.

use plotters::style::RGBColor;

use super::{Figure, Panel, SETTLE, try_each_counted};
use crate::figures::sine;
use crate::method::{Failure, Options, Precision};
use crate::outcome::{ContactSeparationOutcome, Outcome, Particular, csv, number};
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::{BLACK, BLUE, VERMILION};
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

/// Frequencies in Hz: two at the onset of impacts, two at the upper edge of the band.
pub(crate) const FREQUENCIES: [f64; 4] = [18.83, 18.84, 20.15, 20.20];

/// A panel: two frequencies with their colours, and the periods that are shown.
struct Pair {
    letter: char,
    title: &'static str,
    strips: [(f64, RGBColor); 2],
    periods: u32,
}

const PAIRS: [Pair; 2] = [
    Pair {
        letter: 'a',
        title: "Figure 9 (a), onset of impacts",
        strips: [(FREQUENCIES[0], BLUE), (FREQUENCIES[1], VERMILION)],
        // At the onset about twenty periods pass between impacts.
        periods: 60,
    },
    Pair {
        letter: 'b',
        title: "Figure 9 (b), upper edge",
        strips: [(FREQUENCIES[2], VERMILION), (FREQUENCIES[3], BLUE)],
        periods: 12,
    },
];

/// Periods from the start to the end.
const END: u32 = SETTLE + WINDOW;
/// Points in each period.
const PER_PERIOD: u32 = 60;
const SIZE: (u32, u32) = (1130, 520);

pub(super) fn nine(
    base: &Scene,
    [charge_density, resistance]: [f64; 2],
    tolerance: f64,
    [base_g, start]: [&str; 2],
    done: &(dyn Fn() + Sync),
) -> Result<Figure, Failure> {
    let mut strips = Vec::new();
    for pair in &PAIRS {
        strips.extend(pair.strips.map(|(frequency, _)| (frequency, END - pair.periods)));
    }
    let histories = try_each_counted(&strips, done, |&(frequency, from)| {
        let case = Case { charge_density, resistance, frequency, settle: SETTLE };
        case.motion(base, tolerance, PER_PERIOD, from)
    })?;
    let of = format!("{charge_density} µC/m², {resistance} MΩ, {base_g}");
    let panels = PAIRS.iter().zip(histories.chunks(2)).map(|(pair, histories)| panel(pair, &of, histories));
    let [onset, after, edge, beyond] = FREQUENCIES;
    Ok(Figure {
        label: "Figure 9",
        title: "Time histories of the gap where impacts begin and end",
        caption: format!(
            "Gap over the last periods of four runs of {END} periods at {charge_density} µC/m² and {resistance} MΩ; \
             at gap 0, where a dot is, the mass hits the dielectric. (a) At {onset:.2} Hz it comes close without touching, and the \
             slow beat, left over from the start, fades. At {after:.2} Hz the beat stays: every so many periods the \
             mass hits the dielectric, with a long free flight between. (b) At {edge:.2} Hz it hits in every \
             period; at {beyond:.2} Hz impacts are gone and the motion is much smaller. {start}"
        ),
        panels: panels.collect(),
        table: Vec::new(),
        csv: csv(
            "frequency_hz,period,time_s,gap_m",
            histories.iter().flat_map(|motion| {
                let row =
                    |&(period, gap)| [motion.frequency, period, period / motion.frequency, gap].map(number);
                motion.gaps.iter().map(row)
            }),
        ),
    })
}

fn panel(pair: &Pair, of: &str, histories: &[Motion]) -> Panel {
    let plots = histories.iter().zip(pair.strips).map(|(motion, (_, colour))| {
        Chart::new(
            format!(
                "{}: {:.2} Hz, {of}; {} impacts in the last {WINDOW} periods",
                pair.title, motion.frequency, motion.impacts
            ),
            Axis::linear(
                "time since the start [excitation periods]",
                [f64::from(END - pair.periods), f64::from(END)],
                13,
            ), // Dots at 0 stand above the axis.
            Axis::linear("gap [mm]", [-0.3, 6.0], 7),
            curves(motion, colour),
        )
    });
    Panel::new(format!("figure-9{}", pair.letter), SIZE, plots)
}

/// The gap, and the impacts of those that have any.
fn curves(motion: &Motion, colour: RGBColor) -> Vec<Curve> {
    let gap = motion.gaps.iter().map(|&(period, gap)| (period, 1e3 * gap));
    let impacts = motion.hits.iter().map(|period| (*period, 0.0));
    let mut curves = vec![Curve::new("", colour, Mark::line(0, 1.5), gap)];
    if !motion.hits.is_empty() {
        curves.push(Curve::new("impact", BLACK, Mark::point(0, 7.0), impacts));
    }
    curves
}

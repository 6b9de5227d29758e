//! What a burst of samples says of the output power: lines of blocks, looked up in the map.

use crate::energy::ResponseMap;
use crate::energy::response_map::{Bounded, Outside, Response, WordSource};
use crate::excitation::Lines;
use crate::node::tier::BOUND;
use crate::scalar::Scalar;
use crate::snapshot::{snapshot_fields, snapshot_variants};

/// Purity from which a block has a line.
const LINE: f32 = 0.9;
/// Mean purity up to which blocks are broadband vibration.
const BROADBAND: f32 = 0.85;
/// Part of the line's output power above which what else excites the resonance is relevant.
const RELEVANT: f32 = 0.05;
/// Output power of the strongest line over that of broadband vibration from which the vibration is not broadband.
const STRONG: f32 = 3.0;
/// Relative standard deviation of the density of noise in a block: of the mean over two bins of a Hann window, the fewest, whose
/// powers have the correlation 4/9, √((1 + 4/9)/2).
const DENSITY: f32 = 0.85;
/// Power of all else over that of a line, below which a line is alone.
const ALONE: f32 = 0.002;
/// Relative error of the amplitude of a line.
const OF_AMPLITUDE: f32 = 0.004;
/// Relative standard deviation of an output power by the errors of the amplitude and the frequency of a line.
const OF_LINE: f32 = 0.02;

/// Highest peak of noise over the amplitude of its strongest bin: three deviations of what some 60 bins add up to.
const NOISE_PEAK: f32 = 10.0;

/// What a burst found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Finding {
    /// A line with one steady motion.
    Line,
    /// A line with two steady motions: the storage decided which.
    TwoMotionsOneSeen,
    /// A line with two steady motions between which the storage has not decided: where they are new, the power is the middle
    /// of both output powers with a bound that covers both, and then the estimate by the voltage. No value.
    TwoMotions,
    /// Broadband vibration of a harvester that stays linear.
    Broadband,
    /// Broadband vibration beyond the linear motion: the output power of the linear motion, of which the true one may be many times.
    BroadbandBeyond,
    /// Vibration below the map: at most the output power at its lowest amplitude.
    Rest,
    /// A line beyond another edge of the map: no value.
    Outside(Outside),
    /// Neither a line nor broadband vibration, for example two strong lines: the order of magnitude of the stronger one.
    Unclear,
    /// A sample was at the end of the sensor's range, or samples were lost: no value.
    Damaged,
}

/// What a burst says by the map, before the storage has a say.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PredictedPower {
    /// Of what kind it is.
    pub finding: Finding,
    /// Of the smaller motion where there are two.
    pub lower: OutputPower,
    /// Of the larger motion where there are two.
    pub upper: OutputPower,
}

/// Output power of a motion by the map.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutputPower {
    /// In W.
    pub value: f32,
    /// Standard deviation in W by noise, new in each burst.
    pub noise: f32,
    /// Relative standard deviation by the map, the same at the same place.
    pub systematic: f32,
}

impl PredictedPower {
    /// What the blocks of a burst say by the map, with the storage at `voltage` in V, which only a map of charge asks for.
    /// A [`MapNode`](super::MapNode) takes its samples by the same code.
    #[must_use]
    pub fn of_blocks<W: WordSource>(map: &ResponseMap<W>, blocks: &[Lines], voltage: f32) -> Self {
        let mut sums = Blocks::default();
        for lines in blocks {
            sums.add(map, lines, voltage);
        }
        sums.predicted(map, voltage)
    }

    /// Of one motion, without an error of the map; power and noise in W.
    fn of_one(finding: Finding, value: f32, noise: f32) -> Self {
        let lower = OutputPower { value, noise, systematic: 0.0 };
        Self { finding, lower, upper: lower }
    }

    /// An order of magnitude in W.
    fn about(finding: Finding, value: f32) -> Self {
        Self::of_one(finding, value, value)
    }

    /// The output power of either motion: the middle of both, uncertain by half of their difference.
    #[must_use]
    pub fn either(&self) -> OutputPower {
        let Self { lower, upper, .. } = *self;
        let half = 0.5 * (upper.value - lower.value);
        let value = lower.value + half;
        let systematic = upper.systematic + if value > 0.0 { half / value } else { 0.0 };
        OutputPower { value, noise: lower.noise, systematic }
    }
}

impl OutputPower {
    /// Bound of its error in W: two and a half standard deviations, as of an [`IncomeOfTime`](crate::node::IncomeOfTime).
    #[must_use]
    pub fn bound(&self) -> f32 {
        let of_map = self.systematic * self.value;
        BOUND * Scalar::sqrt(self.noise * self.noise + of_map * of_map)
    }
}

/// Sums over the blocks of a burst.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Blocks {
    /// Blocks, and those with a line in the map.
    count: u32,
    lines: u32,
    /// Blocks with two motions.
    doubles: u32,
    /// Whether the sensor was at its end, or samples were lost.
    pub(super) is_damaged: bool,
    /// Whether they are all, and to be evaluated.
    pub(super) is_whole: bool,
    /// Output power of the smaller and the larger motion, and its bounds.
    powers: [f32; 4],
    /// The largest amplitude with its frequency.
    strongest: [f32; 2],
    /// The smallest amplitude of a line in the map.
    weakest: f32,
    purity: f32,
    density: f32,
    rest: f32,
}

impl Blocks {
    /// Takes in the lines of a block; `voltage` is that of the storage in V.
    pub(super) fn add<W: WordSource>(&mut self, map: &ResponseMap<W>, lines: &Lines, voltage: f32) {
        self.count = self.count.saturating_add(1);
        self.purity += lines.purity;
        self.density += lines.density;
        self.rest += lines.rest;
        if lines.amplitude > self.strongest[0] {
            self.strongest = [lines.amplitude, lines.frequency];
        }
        if lines.purity < LINE {
            return;
        }
        let response = look_up(map, lines.amplitude, lines.frequency, voltage);
        let Some([less, more]) = motions(&response) else { return };
        if matches!(response, Response::Two { .. }) {
            self.doubles = self.doubles.saturating_add(1);
        }
        let beside = 2.0 * (1.0 - lines.purity);
        let powers = [less.value, more.value, less.low * (1.0 - beside), more.high * (1.0 + beside)];
        if self.lines == 0 || lines.amplitude < self.weakest {
            self.weakest = lines.amplitude;
        }
        self.lines = self.lines.saturating_add(1);
        let scale = if map.is_current() { voltage } else { 1.0 };
        for (sum, part) in self.powers.iter_mut().zip(powers) {
            *sum += part * scale;
        }
    }

    /// The least and the largest output power of the smaller and of the larger motion at the amplitudes between which the line beats
    /// with what else the band has, or within the error of its amplitude. `None` outside the map.
    ///
    /// Two lines nearer than a bin are one to the bank, whose amplitude differs from block to block: it goes on by half of the
    /// difference beyond those of the blocks. Lines farther apart lower the purity `p`: the others have together up to
    /// `√((1 − p)/p)` of the amplitude.
    fn beat<W: WordSource>(&self, map: &ResponseMap<W>, purity: f32, voltage: f32) -> Option<[[f32; 2]; 2]> {
        let [most, frequency] = self.strongest;
        let others = (1.0 - purity) / purity - ALONE;
        let beside = OF_AMPLITUDE + if others > 0.0 { Scalar::sqrt(others) } else { 0.0 };
        let beyond = 0.5 * (most - self.weakest);
        let [lowest, highest] = map.amplitudes();
        let at = |amplitude: f32| {
            // The edges of the map are within a rounding of what it answers.
            let within = Scalar::min(Scalar::max(amplitude, lowest * 1.001), highest * 0.999);
            motions(&look_up(map, within, frequency, voltage))
        };
        let [less, more] = at((1.0 - beside) * (self.weakest - beyond))?;
        let [less_above, more_above] = at((1.0 + beside) * (most + beyond))?;
        let scale = if map.is_current() { voltage } else { 1.0 };
        let span = |one: Bounded, other: Bounded| {
            [scale * Scalar::min(one.value, other.value), scale * Scalar::max(one.value, other.value)]
        };
        Some([span(less, less_above), span(more, more_above)])
    }

    /// The output power of all blocks.
    pub(super) fn predicted<W: WordSource>(&self, map: &ResponseMap<W>, voltage: f32) -> PredictedPower {
        if self.is_damaged || self.count == 0 {
            return PredictedPower::about(Finding::Damaged, 0.0);
        }
        let count = f32::from(u16::try_from(self.count).unwrap_or(u16::MAX));
        let scale = if map.is_current() { voltage } else { 1.0 };
        if self.lines == self.count {
            return self.of_line(map, voltage, scale, count);
        }
        let [amplitude, frequency] = self.strongest;
        let [lowest, _] = map.amplitudes();
        // The strongest line of noise or of no signal is any bin, which the map need not have: the output power at rest is then bounded
        // by that at the resonance.
        let at = if map.has_frequency(frequency) { frequency } else { map.resonance() };
        let edge = look_up(map, lowest * 1.001, at, voltage).income();
        if amplitude < lowest || self.purity <= BROADBAND * count {
            if let Some(found) = map.broadband(self.density / count) {
                let value = found.value * scale;
                // Vibration of an even density has no line that gives more than a few of its bins.
                let line = look_up(map, amplitude, frequency, voltage);
                let line = line.income().map_or(0.0, |line| line.high * scale);
                if amplitude >= lowest && line > STRONG * value {
                    return PredictedPower::about(Finding::Unclear, line);
                }
                if !found.is_linear {
                    return PredictedPower::about(Finding::BroadbandBeyond, value);
                }
                let noise = DENSITY * value / Scalar::sqrt(count);
                if amplitude >= lowest {
                    return PredictedPower::of_one(Finding::Broadband, value, noise);
                }
                // The output power of the linear motion grows with the square of the amplitude.
                let part = amplitude / lowest;
                let line = edge.map_or(0.0, |edge| 0.5 * edge.high * scale * part * part);
                let noise = Scalar::max(noise, line);
                return PredictedPower::of_one(Finding::Rest, value, noise);
            }
            let peak = if self.purity >= LINE * count { amplitude } else { NOISE_PEAK * amplitude };
            if peak < lowest {
                // The output power grows with the amplitude.
                let Some(edge) = edge else {
                    return PredictedPower::about(Finding::Outside(Outside::AmplitudeBelow), 0.0);
                };
                let noise = 0.5 * edge.high * scale;
                return PredictedPower::of_one(Finding::Rest, 0.0, noise);
            }
        }
        match look_up(map, amplitude, frequency, voltage) {
            Response::Outside(edge) if self.purity >= LINE * count => {
                PredictedPower::about(Finding::Outside(edge), 0.0)
            }
            other => PredictedPower::about(
                Finding::Unclear,
                other.income().map_or(0.0, |income| income.value * scale),
            ),
        }
    }

    /// The output power where each of the `count` blocks has a line; `scale` is W for each unit of the map.
    fn of_line<W: WordSource>(
        &self,
        map: &ResponseMap<W>,
        voltage: f32,
        scale: f32,
        count: f32,
    ) -> PredictedPower {
        let [value, upper, low, high] = self.powers.map(|sum| sum / count);
        let rest = 3.0 * scale * map.broadband(self.rest / count).map_or(0.0, |rest| rest.value);
        if rest > RELEVANT * value {
            return PredictedPower::about(Finding::Unclear, Scalar::max(value, rest));
        }
        // What else the band has beats with the line, which an impacting or stuck harvester answers in its own way.
        let purity = self.purity / count;
        let part = OF_LINE + (1.0 - purity);
        let with = |value: f32, spread: f32, [least, most]: [f32; 2]| {
            let beat = Scalar::max(value - least, most - value) / BOUND;
            let spread = Scalar::max(spread, beat);
            let systematic = if value > 0.0 { spread / value } else { 0.0 };
            OutputPower { value, noise: part * value, systematic }
        };
        let beat = self.beat(map, purity, voltage);
        let [of_lower, of_upper] = beat.unwrap_or([[value; 2], [upper; 2]]);
        let high = high + rest;
        if self.doubles == 0 {
            let of_both = [Scalar::min(of_lower[0], of_upper[0]), Scalar::max(of_lower[1], of_upper[1])];
            // The bound covers those of the map, which need not be even.
            let away = Scalar::max(high - value, value - low) / BOUND;
            let lower = with(value, Scalar::max(0.25 * (high - low), away), of_both);
            return PredictedPower { finding: Finding::Line, lower, upper: lower };
        }
        // Of each motion the bound away from the other one.
        let lower = with(value, 0.5 * (value - low), of_lower);
        let upper = with(upper, 0.5 * (high - upper), of_upper);
        PredictedPower { finding: Finding::TwoMotions, lower, upper }
    }
}

/// The output powers of the smaller and of the larger motion; the same one of one motion, `None` outside the map.
fn motions(response: &Response) -> Option<[Bounded; 2]> {
    match *response {
        Response::One { income, .. } => Some([income; 2]),
        Response::Two { lower, upper } if upper.value < lower.value => Some([upper, lower]),
        Response::Two { lower, upper } => Some([lower, upper]),
        Response::Outside(_) => None,
    }
}

/// The answer of the map, at the voltage of the storage where it has slices.
fn look_up<W: WordSource>(map: &ResponseMap<W>, amplitude: f32, frequency: f32, voltage: f32) -> Response {
    if map.is_current() {
        map.at_voltage(amplitude, frequency, voltage)
    } else {
        map.at(amplitude, frequency)
    }
}

snapshot_variants!(Motion { Lower, Upper });
snapshot_fields!(impl [] OutputPower { value, noise, systematic });

/// One of two steady motions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) enum Motion {
    /// That of the smaller output power.
    #[default]
    Lower,
    /// That of the larger output power.
    Upper,
}

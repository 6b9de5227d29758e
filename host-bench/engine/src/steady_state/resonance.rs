//! The frequencies at which a steady state has its largest amplitude, voltage and power, and the resistance that takes the most power.

use serde::Serialize;

use super::orbit::Response;

/// Frequencies of the first scan, by default.
pub const DEFAULT_POINTS: usize = 41;
/// Width in Hz to which a peak is narrowed down.
const WITHIN_HZ: f64 = 2e-5;
/// Resistances in Ω between which the best one is sought, as powers of ten.
const RESISTANCES: [f64; 2] = [0.0, 13.0];
/// Resistances of the first scan for each power of ten.
const EACH_DECADE: usize = 2;
/// Width to which the natural logarithm of the best resistance is narrowed down.
const WITHIN_RATIO: f64 = 1e-3;
/// Evaluations after which the search for a peak ends.
const MOST_EVALUATIONS: usize = 60;

/// A largest response.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Peak {
    /// Its frequency in Hz.
    pub frequency_hz: f64,
    /// Its value, in the unit of the response.
    pub value: f64,
    /// Half the width in Hz of the interval that contains it, if the response has one peak between the points of the scan.
    pub within_hz: f64,
    /// Whether it is at an end of the range, so that a larger response may lie beyond.
    pub at_edge: bool,
}

/// The peaks of a steady state over frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Resonance {
    /// Of the amplitude in m.
    pub amplitude: Peak,
    /// Of the RMS voltage in V.
    pub rms_voltage: Peak,
    /// Of the mean power in W, if it was asked for and there is any.
    pub mean_power: Option<Peak>,
    /// All responses that were computed, in rising order of frequency; `None` where there is no stable orbit.
    pub responses: Vec<(f64, Option<Response>)>,
}

/// Scans `points` frequencies from `from` to `to` in Hz in rising order, then narrows down both peaks.
///
/// `respond` gives the response at a frequency. Frequencies follow each other closely, so that `respond` can follow an
/// orbit. The result is `None` if no frequency of the scan has a response. The peak of the power is sought only `with_power`.
pub fn resonance<F>(
    [from, to]: [f64; 2],
    points: usize,
    with_power: bool,
    mut respond: impl FnMut(f64) -> Result<Option<Response>, F>,
) -> Result<Option<Resonance>, F> {
    let last = points.max(3) - 1;
    let frequency = |index: usize| from + (to - from) * index as f64 / last as f64;
    let mut responses = Vec::new();
    for index in 0..=last {
        responses.push((frequency(index), respond(frequency(index))?));
    }
    let mut peak = |responses: &mut Vec<_>, measure| {
        responses.sort_by(|one: &(f64, _), other: &(f64, _)| one.0.total_cmp(&other.0));
        narrowed(responses, WITHIN_HZ, measure, &mut respond)
    };
    let Some(amplitude) = peak(&mut responses, amplitude)? else { return Ok(None) };
    let Some(rms_voltage) = peak(&mut responses, voltage)? else { return Ok(None) };
    let has_power = responses.iter().any(|(_, found)| found.as_ref().is_some_and(|found| power(found) > 0.0));
    let mean_power = if with_power && has_power { peak(&mut responses, power)? } else { None };
    responses.sort_by(|one, other| one.0.total_cmp(&other.0));
    Ok(Some(Resonance { amplitude, rms_voltage, mean_power, responses }))
}

/// The load that takes the most power.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BestLoad {
    pub resistance_ohm: f64,
    pub mean_power_w: f64,
}

/// Scans resistances from 1 Ω to 10 TΩ and narrows down the largest mean power. `None` if no resistance has a response, or
/// the largest power is at an end of the range.
///
/// `respond` gives the response at a resistance in Ω; resistances follow each other, so that `respond` can follow an orbit.
pub fn best_load<F>(
    mut respond: impl FnMut(f64) -> Result<Option<Response>, F>,
) -> Result<Option<BestLoad>, F> {
    let [first, last] = RESISTANCES;
    let count = ((last - first) * EACH_DECADE as f64) as usize;
    let mut at = |logarithm: f64| respond(logarithm.exp());
    let mut responses = Vec::new();
    for index in 0..=count {
        let logarithm = (first + index as f64 / EACH_DECADE as f64) * std::f64::consts::LN_10;
        responses.push((logarithm, at(logarithm)?));
    }
    let found = narrowed(&mut responses, WITHIN_RATIO, power, &mut at)?;
    Ok(found
        .filter(|peak| !peak.at_edge && peak.value > 0.0)
        .map(|peak| BestLoad { resistance_ohm: peak.frequency_hz.exp(), mean_power_w: peak.value }))
}

fn power(response: &Response) -> f64 {
    response.mean_power_w
}

fn amplitude(response: &Response) -> f64 {
    response.amplitude_m
}

fn voltage(response: &Response) -> f64 {
    response.rms_voltage_v
}

/// The peak between the neighbours of the largest response so far to a width `within`, by Brent's method: a parabola
/// through the three best points where that converges, a golden section where it does not
/// (R. P. Brent, *Algorithms for Minimization without Derivatives*, 1973, chapter 5).
fn narrowed<F>(
    responses: &mut Vec<(f64, Option<Response>)>,
    within: f64,
    measure: fn(&Response) -> f64,
    respond: &mut impl FnMut(f64) -> Result<Option<Response>, F>,
) -> Result<Option<Peak>, F> {
    // 2 − (1 + √5)/2, the smaller part of a golden section.
    const SECTION: f64 = 0.381_966_011_250_105_1;
    let value = |response: &Option<Response>| response.as_ref().map_or(f64::NEG_INFINITY, measure);
    let best = (0..responses.len())
        .max_by(|&one, &other| value(&responses[one].1).total_cmp(&value(&responses[other].1)));
    let Some(best) = best.filter(|&best| responses[best].1.is_some()) else { return Ok(None) };
    let last = responses.len() - 1;
    let ends = [responses[0].0, responses[last].0];
    let (mut low, mut high) = (responses[best.saturating_sub(1)].0, responses[(best + 1).min(last)].0);
    // The best point, the second best and the one before, each with its value.
    let mut first = (responses[best].0, value(&responses[best].1));
    let (mut second, mut third) = (first, first);
    let (mut step, mut before) = (0.0_f64, 0.0_f64);
    for _ in 0..MOST_EVALUATIONS {
        let middle = 0.5 * (low + high);
        if (first.0 - middle).abs() + 0.5 * (high - low) <= 2.0 * within {
            break;
        }
        let parabola = vertex(first, second, third)
            .filter(|change| change.abs() < 0.5 * before.abs())
            .filter(|change| (low + within..high - within).contains(&(first.0 + change)));
        (before, step) = match parabola {
            Some(change) => (step, change),
            None => {
                let longer = if first.0 < middle { high - first.0 } else { low - first.0 };
                (longer, SECTION * longer)
            }
        };
        if step.abs() < within {
            step = within.copysign(step);
        }
        let frequency = first.0 + step;
        let response = respond(frequency)?;
        let found = (frequency, value(&response));
        responses.push((frequency, response));
        if found.1 >= first.1 {
            *(if frequency < first.0 { &mut high } else { &mut low }) = first.0;
            (third, second, first) = (second, first, found);
        } else {
            *(if frequency < first.0 { &mut low } else { &mut high }) = frequency;
            if found.1 >= second.1 || second.0 == first.0 {
                (third, second) = (second, found);
            } else if found.1 >= third.1 || third.0 == first.0 || third.0 == second.0 {
                third = found;
            }
        }
    }
    let within_hz = (high - first.0).max(first.0 - low);
    let at_edge = ends.iter().any(|end| (end - first.0).abs() <= 2.0 * within);
    Ok(Some(Peak { frequency_hz: first.0, value: first.1, within_hz, at_edge }))
}

/// Distance from the first point to the vertex of the parabola through three points; `None` if there is no vertex.
fn vertex(first: (f64, f64), second: (f64, f64), third: (f64, f64)) -> Option<f64> {
    let (left, right) = (second.0 - first.0, third.0 - first.0);
    let (fall_left, fall_right) = (second.1 - first.1, third.1 - first.1);
    let bottom = 2.0 * (right * fall_left - left * fall_right);
    let change = (right * right * fall_left - left * left * fall_right) / bottom;
    change.is_finite().then_some(change)
}

//! The SVG text around a drawing, and the fonts, colours and ticks of all pictures.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

pub(crate) type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;

/// The default font of the viewer.
pub(crate) const FONT: &str = "sans-serif";

/// Colours of Okabe and Ito, distinct for the colour-blind too.
pub(crate) const BLACK: RGBColor = RGBColor(0, 0, 0);
pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(crate) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(crate) const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub(crate) const PURPLE: RGBColor = RGBColor(204, 121, 167);
pub(crate) const VERMILION: RGBColor = RGBColor(213, 94, 0);
pub(crate) const SKY: RGBColor = RGBColor(86, 180, 233);
/// Those of curves of one kind, one after the other.
pub(crate) const COLOURS: [RGBColor; 7] = [BLUE, VERMILION, GREEN, ORANGE, PURPLE, BLACK, SKY];

/// Lines of the grid.
pub(crate) const GRID: RGBColor = RGBColor(224, 228, 232);

/// The drawing on a white ground, as SVG text.
pub(crate) fn svg(size: (u32, u32), draw: impl FnOnce(&Area<'_>) -> Drawn) -> Result<String, String> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let drawn = area.fill(&WHITE).and_then(|()| draw(&area)).and_then(|()| area.present());
        drawn.map_err(|error| error.to_string())?;
    }
    // XML has no way to write most of them.
    text.retain(|letter| letter == '\n' || !letter.is_control());
    Ok(text)
}

/// A colour as CSS has it.
pub(crate) fn hex(RGBColor(red, green, blue): RGBColor) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

/// A number with three digits, without trailing zeros.
pub(crate) fn tick(value: f64) -> String {
    let plain = value == 0.0 || (1e-2..1e4).contains(&value.abs());
    if plain { decimal(value, 3) } else { power(&format!("{value:.2e}")) }
}

/// So many digits behind the point at most.
pub(super) fn decimal(value: f64, digits: usize) -> String {
    format!("{value:.digits$}").parse().unwrap_or(value).to_string()
}

/// A number with an exponent as a power of ten, with a factor unless that is 1.
fn power(text: &str) -> String {
    let (factor, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let power = power_of_ten(exponent.parse().unwrap_or(0.0));
    let factor: f64 = factor.parse().unwrap_or(1.0);
    let sign = if factor < 0.0 { "-" } else { "" };
    match factor.abs() {
        0.0 => "0".to_owned(),
        1.0 => format!("{sign}{power}"),
        size => format!("{sign}{size}·{power}"),
    }
}

/// A number at a tick, in one notation for its axis: powers of ten where all are, or the largest is below 0.01 or has six digits.
pub(crate) fn tick_label(value: f64, all: impl Iterator<Item = f64> + Clone, is_logarithmic: bool) -> String {
    let largest = all.clone().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let is_power = |value: f64| (value.log10() - value.log10().round()).abs() < 1e-9;
    let has_powers = is_logarithmic && all.into_iter().all(is_power);
    if has_powers || largest > 0.0 && !(1e-2..1e5).contains(&largest) {
        power(&format!("{value:.6e}"))
    } else {
        decimal(value, 6)
    }
}

/// Ticks of an axis at equal distances of 1, 2 or 5 times a power of ten, about so many, from `low` to `high`.
pub(crate) fn linear_ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let span = (high - low).abs();
    if !(span > 0.0 && span.is_finite()) {
        return vec![low];
    }
    let rough = span / count.max(1) as f64;
    let decade = 10f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * decade);
    let step = steps.into_iter().find(|step| *step >= 0.999 * rough).unwrap_or(decade);
    // Half a pixel of rounding belongs to the axis.
    let slack = 1e-6 * span;
    let (first, last) = (low.min(high) - slack, low.max(high) + slack);
    let numbers = (first / step).ceil() as i64..=(last / step).floor() as i64;
    numbers.map(|number| number as f64 * step).collect()
}

/// Exponents of the ticks of a logarithmic axis from exponent `low` to `high`: whole decades, or 1, 2 and 5 in each of few.
pub(crate) fn logarithmic_ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let (low, high) = (low.min(high) - 1e-9, low.max(high) + 1e-9);
    let within = |exponent: &f64| (low..=high).contains(exponent);
    let decades = || (low.floor() as i64..=high.ceil() as i64).map(|decade| decade as f64);
    let whole: Vec<f64> = decades().filter(within).collect();
    if whole.len() > 2 {
        let every = whole.len().div_ceil(count.max(2));
        return whole.into_iter().step_by(every).collect();
    }
    let few = [1.0_f64, 2.0, 5.0].map(f64::log10);
    let mut finer: Vec<f64> =
        decades().flat_map(|decade| few.map(|part| decade + part)).filter(within).collect();
    if finer.len() > 2 {
        // An end has a number too if it is round and not near another.
        for (at, end) in [(finer.len(), high), (0, low)] {
            let digit = 10f64.powf(end.rem_euclid(1.0));
            let is_apart = finer.iter().all(|tick| (tick - end).abs() > 0.15 * (high - low));
            if is_apart && (digit - digit.round()).abs() < 1e-6 {
                finer.insert(at, digit.round().log10() + end.floor());
            }
        }
        return finer;
    }
    let ticks = linear_ticks(10f64.powf(low), 10f64.powf(high), count);
    ticks.into_iter().filter(|value| *value > 0.0).map(f64::log10).collect()
}

/// Places from 0 to 1 of round numbers and of both ends of an axis with these rising numbers at equal distances.
pub(crate) fn even_ticks(numbers: &[f64]) -> Vec<f64> {
    let last = numbers.len() - 1;
    let mut places = vec![0.0, 1.0];
    // The roundest first.
    let counts = [5, 10, 20, 50, 100, 200];
    for tick in counts.into_iter().flat_map(|count| linear_ticks(numbers[0], numbers[last], count)) {
        let above = numbers.partition_point(|number| *number < tick).clamp(1, last);
        let part = (tick - numbers[above]) / (numbers[above] - numbers[above - 1]);
        let at = (above as f64 + part) / last as f64;
        // Room for the number in a narrow column.
        if places.iter().all(|other| (other - at).abs() > 0.16) {
            places.push(at);
        }
    }
    places.sort_by(f64::total_cmp);
    places
}

/// An axis with ticks of one's own, as the drawing library wants it.
pub(crate) struct Ticked {
    axis: RangedCoordf64,
    ticks: Vec<f64>,
}

impl Ticked {
    pub(crate) fn new([first, last]: [f64; 2], ticks: &[f64]) -> Self {
        Self { axis: (first..last).into(), ticks: ticks.to_vec() }
    }
}

impl Ranged for Ticked {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.axis.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.axis.range()
    }
}

/// The least and the largest of the values; infinite without any.
pub(crate) fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// The range of the values, with a margin.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = extremes(values);
    let margin = match high > low {
        true => 0.05 * (high - low),
        // One value has a range as large as itself; 0 has that of 1.
        false if low == 0.0 => 1.0,
        false => low.abs().max(1e-300),
    };
    (low - margin, high + margin)
}

/// Ten to the nearest whole exponent, as text.
pub(crate) fn power_of_ten(exponent: f64) -> String {
    let digits = ["⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];
    let text: String = format!("{:.0}", exponent.round() + 0.0)
        .chars()
        .map(|digit| digit.to_digit(10).and_then(|digit| digits.get(digit as usize)).copied().unwrap_or("⁻"))
        .collect();
    format!("10{text}")
}

/// The colour of a value, from dark blue over green to yellow. Lightness rises evenly, so that the map reads in grey too.
pub(crate) fn shade(value: f64, low: f64, high: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 201.0, 98.0],
        [253.0, 231.0, 37.0],
    ];
    let part = if high > low { ((value - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
    let position = part * (STOPS.len() - 1) as f64;
    let index = (position as usize).min(STOPS.len() - 2);
    let rest = position - index as f64;
    let channel = |which: usize| {
        let [from, to] = [STOPS[index][which], STOPS[index + 1][which]];
        (from + rest * (to - from)).round() as u8
    };
    RGBColor(channel(0), channel(1), channel(2))
}

/// The width in pixels that a text takes at most in the viewer's font, of a size as the drawing library counts it.
pub(crate) fn width_of(text: &str, size: u32) -> i32 {
    // An SVG calls 1/1.24 of it the size; letters of common fonts are up to 0.62 of that wide on average.
    (text.chars().count() as f64 * 0.62 * f64::from(size) / 1.24).ceil() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        assert_eq!(linear_ticks(0.0, 10.0, 5), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(linear_ticks(2.1e-6, 1.9e-5, 4), [5.0, 10.0, 15.0].map(|value| value * 1e-6));
        assert_eq!(linear_ticks(1.0, 1.0, 5), [1.0]);
        assert_eq!(logarithmic_ticks(5.0, 10.0, 8), [5.0, 6.0, 7.0, 8.0, 9.0, 10.0]);
        // Half decades are 3162.278 and the like: not a tick.
        let shown = |ticks: Vec<f64>, is_logarithmic| -> Vec<String> {
            ticks.iter().map(|tick| tick_label(*tick, ticks.iter().copied(), is_logarithmic)).collect()
        };
        let labels = |low: f64, high: f64| {
            let ticks = logarithmic_ticks(low.log10(), high.log10(), 8);
            shown(ticks.iter().map(|exponent| 10f64.powf(*exponent)).collect(), true)
        };
        assert_eq!(labels(1e3, 1e4), ["1000", "2000", "5000", "10000"]);
        assert_eq!(labels(2e5, 4e6), ["2·10⁵", "5·10⁵", "10⁶", "2·10⁶", "4·10⁶"]);
        assert_eq!(shown(vec![-1e-3, 0.0, 2e-3], false), ["-10⁻³", "0", "2·10⁻³"]);
        assert_eq!(shown(linear_ticks(0.0, 0.02, 4), false), ["0", "0.005", "0.01", "0.015", "0.02"]);
        assert_eq!(labels(2.5, 4.6), ["2.5", "3", "3.5", "4", "4.5"]);
        let wide = even_ticks(&[18.0, 19.8, 20.0, 20.1, 20.2, 20.4, 22.0]);
        // All but 19 and 21, which are near the ends.
        let is_at = |(place, number): (&f64, u32)| (6.0 * place - f64::from(number)).abs() < 1e-9;
        assert!(wide.len() == 7 && wide.iter().zip(0..).all(is_at), "{wide:?}");
        assert_eq!(labels(1e6, 1e9), ["10⁶", "10⁷", "10⁸", "10⁹"]);
    }
}

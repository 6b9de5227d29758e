//! The SVG text around a drawing, and the fonts, colours and ticks of all pictures.

use plotters::coord::Shift;
use plotters::prelude::*;

/// The drawing library's area.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The result of drawing.
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
    Ok(text)
}

/// A number with three digits, without trailing zeros.
pub(crate) fn tick(value: f64) -> String {
    let plain = value == 0.0 || (1e-2..1e4).contains(&value.abs());
    let text = if plain { format!("{value:.3}") } else { format!("{value:.2e}") };
    match text.split_once('e') {
        None => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        Some((digits, exponent)) => {
            format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'))
        }
    }
}

/// The least and the largest of the values; infinite without any.
pub(crate) fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// The range of the values, with a margin.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = extremes(values);
    let margin = if high > low { 0.05 * (high - low) } else { low.abs().max(1e-300) };
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

//! Where the energy of the base goes, as bars.

use std::fmt::Write;

use plotters::style::RGBColor;

use super::Series;
use crate::report::page::escaped;
use crate::report::setting::scaled;
use crate::report::svg::{FONT, hex, width_of};

const ROW: u32 = 22;
const TOP: u32 = 40;
/// Size of the text, as the drawing library counts it.
const SIZE: u32 = 18;
/// Left edge of the bars, and room at the right for the numbers.
const LEFT: u32 = 240;
const RIGHT: u32 = 130;
/// Width below which the bars have no names of runs.
const NARROW: u32 = 700;

/// A run with its colour, and the names and energies of its parts.
type Known<'a> = (&'a Series, RGBColor, Vec<(&'static str, f64)>);

/// The bars of all runs whose energy is known, and their height; `None` without any.
pub(super) fn flow(width: u32, series: &[Series], colours: [RGBColor; 7]) -> Option<(u32, String)> {
    let known: Vec<Known<'_>> = series
        .iter()
        .zip(colours.into_iter().cycle())
        .filter_map(|(one, colour)| Some((one, colour, one.flow?.parts())))
        .collect();
    // A part that no run has would be a name without a bar; what comes from the base is what the others are parts of.
    let is_of =
        |index: usize, parts: &[(&str, f64)]| parts.get(index).is_some_and(|(_, value)| *value != 0.0);
    let has = |index: usize| known.iter().any(|(.., parts)| is_of(index, parts));
    let all = known.first()?.2.iter().enumerate();
    let wanted = all.filter(|(index, _)| *index == 0 || has(*index));
    let names: Vec<(usize, &str)> = wanted.map(|(index, (name, _))| (index, *name)).collect();
    let rows = u32::try_from(names.len() * known.len()).ok()?;
    let height = TOP + ROW * rows + 12 * u32::try_from(names.len()).ok()?;
    let largest =
        known.iter().flat_map(|(.., parts)| parts).fold(0.0_f64, |most, (_, value)| most.max(value.abs()));
    let (title, factor) = scaled("energy over the whole run", "J", [largest].into_iter());
    // A narrow picture names the runs by their colours in the charts above.
    let is_named = known.len() > 1 && width >= NARROW;
    let longest = known.iter().filter(|_| is_named).map(|(one, ..)| width_of(&one.name, SIZE)).max();
    let right = RIGHT + longest.map_or(0, i32::unsigned_abs).min(width / 3);
    let scale = if largest > 0.0 { f64::from(width.saturating_sub(LEFT + right)) / largest } else { 0.0 };
    let mut text = format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"{FONT}\" font-size=\"14.5\">\n<text x=\"{}\" y=\"20\" text-anchor=\"middle\">{title}</text>\n",
        width / 2
    );
    let mut y = TOP;
    for (index, name) in names {
        let _ = writeln!(text, "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{name}</text>", LEFT - 8, y + 15);
        for (one, colour, parts) in &known {
            let value = parts.get(index).map_or(0.0, |(_, value)| *value);
            let long = (scale * value.abs()).max(0.5);
            // What is negative flows the other way: its bar is hollow.
            let colour = hex(*colour);
            let fill = if value < 0.0 { "none" } else { &colour };
            let of = if is_named { format!("  {}", escaped(&one.name)) } else { String::new() };
            let supplied = parts.first().map(|(_, value)| *value).filter(|supplied| *supplied > 0.0);
            let part = supplied.map_or_else(String::new, |supplied| {
                format!(", {:.3} % of what comes from the base", 100.0 * value / supplied)
            });
            // The title is what a browser shows at the pointer.
            let _ = writeln!(
                text,
                "<rect x=\"{LEFT}\" y=\"{}\" width=\"{long:.1}\" height=\"{}\" fill=\"{fill}\" pointer-events=\"all\" \
                 stroke=\"{colour}\"><title>{}: {value:.6e} J{part}</title></rect>\n<text x=\"{:.1}\" y=\"{}\">{}{of}</text>",
                y + 3,
                ROW - 6,
                escaped(name),
                f64::from(LEFT) + long + 6.0,
                y + 15,
                format!("{:.3e}", factor * value).parse().unwrap_or(value),
            );
            y += ROW;
        }
        y += 12;
    }
    Some((height, text + "</svg>\n"))
}

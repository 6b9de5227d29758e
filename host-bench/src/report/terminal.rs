//! A chart as text for a terminal: lines of braille dots, a letter for each point, blocks for cells.

use super::chart::{Axis, Chart, Mark, SHADES};
use crate::outcome::WIDTH;

/// The bit of each dot of a braille character, by row and column.
const BITS: [[u32; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];
/// Marks of the points, curve by curve.
const LETTERS: [char; 12] = ['o', '*', '+', '#', '@', '%', '&', '=', '$', '~', '^', 'v'];
/// Cells from the least to the largest value.
const BLOCKS: [char; 5] = ['·', '░', '▒', '▓', '█'];

/// Characters, and dots of braille below them.
struct Canvas {
    columns: usize,
    dots: Vec<u32>,
    letters: Vec<Option<char>>,
}

impl Canvas {
    /// The index of a character and the bit of a dot, of a place from 0 to 1 to the right and from the top down.
    fn at(&self, [right, down]: [f64; 2]) -> Option<(usize, u32)> {
        let rows = self.dots.len() / self.columns;
        let dot = |part: f64, count: usize| (part * (count - 1) as f64).round() as usize;
        let is_inside = [right, down].iter().all(|part| (-1e-6..=1.0 + 1e-6).contains(part));
        is_inside.then(|| {
            let (x, y) = (dot(right, 2 * self.columns), dot(down, 4 * rows));
            (y / 4 * self.columns + x / 2, BITS[y % 4][x % 2])
        })
    }

    fn line(&mut self, [from, to]: [[f64; 2]; 2], is_dashed: bool) {
        let rows = self.dots.len() / self.columns;
        let lengths = [(to[0] - from[0]) * (2 * self.columns) as f64, (to[1] - from[1]) * (4 * rows) as f64];
        let count = lengths.iter().fold(1.0_f64, |most, length| most.max(length.abs())).min(1e4) as usize;
        for step in (0..=count).filter(|step| !is_dashed || step % 6 < 3) {
            let part = step as f64 / count as f64;
            let place = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
            if let Some((index, bit)) = self.at(place) {
                self.dots[index] |= bit;
            }
        }
    }

    fn rows(&self) -> impl Iterator<Item = String> {
        let of = |(dots, letter): (&u32, &Option<char>)| {
            letter.or(char::from_u32(0x2800 + dots).filter(|_| *dots > 0)).unwrap_or(' ')
        };
        let rows = self.dots.chunks(self.columns).zip(self.letters.chunks(self.columns));
        rows.map(move |(dots, letters)| dots.iter().zip(letters).map(of).collect())
    }
}

/// The chart in [`WIDTH`] columns, with so many rows between its axes, line break included.
pub(crate) fn terminal(chart: &Chart, rows: usize) -> String {
    let ([left, right], [low, high]) = (chart.across.ends(), chart.up.ends());
    let place = |&(x, y): &(f64, f64)| {
        [(chart.across.place(x) - left) / (right - left), (high - chart.up.place(y)) / (high - low)]
    };
    let (across, up) = (chart.across.places(), chart.up.places());
    let labels: Vec<String> = up.iter().map(|at| chart.up.label(*at, &up)).collect();
    let margin = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
    let columns = WIDTH - margin - 2;
    let mut canvas = Canvas { columns, dots: vec![0; columns * rows], letters: vec![None; columns * rows] };
    shade(chart, &mut canvas, rows);
    let mut legend = String::new();
    let mut letters = LETTERS.into_iter().cycle();
    for curve in chart.curves.iter().filter(|curve| !curve.is_hidden) {
        let Mark { line, point } = curve.mark;
        let letter = point.and_then(|_| letters.next());
        let is_dashed = line.is_some_and(|(_, number)| number > 0);
        if line.is_some() {
            for pair in curve.points.windows(2) {
                let ends = [place(&pair[0]), place(&pair[1])];
                if ends.iter().flatten().all(|part| part.is_finite()) {
                    canvas.line(ends, is_dashed);
                }
            }
        }
        for point in curve.points.iter().filter(|_| letter.is_some()) {
            if let Some((index, _)) = canvas.at(place(point)) {
                canvas.letters[index] = letter;
            }
        }
        if !curve.name.is_empty() {
            let is_upright = curve.points.windows(2).all(|pair| pair[0].0 == pair[1].0);
            let line = if is_dashed { "⠒ ⠒" } else { ["⠒⠒⠒", "⡇"][usize::from(is_upright)] };
            let sample = letter.map_or_else(|| line.to_owned(), String::from);
            add_entry(&mut legend, &format!("{sample} {}", curve.name));
        }
    }
    let title = [chart.title.as_str(), &chart.up.title].join(if chart.title.is_empty() { "" } else { ": " });
    let mut text = [title, legend]
        .into_iter()
        .filter(|line| !line.is_empty())
        .fold(String::new(), |text, line| text + &line + "\n");
    // The row of each label: that of its dot.
    let row_of = |at: f64| ((high - at) / (high - low) * (4 * rows - 1) as f64).round() as usize / 4;
    for (row, line) in canvas.rows().enumerate() {
        let label = up.iter().zip(&labels).find(|(at, _)| row_of(**at) == row);
        let (label, tick) = label.map_or(("", '│'), |(_, label)| (label.as_str(), '┤'));
        text += format!("{label:>margin$} {tick}{line}").trim_end();
        text.push('\n');
    }
    text += &axis(chart, &across, margin, columns);
    text
}

/// Adds an entry to a legend, in a line of its own where the last one has no room.
fn add_entry(legend: &mut String, entry: &str) {
    let last = legend.rsplit('\n').next().unwrap_or_default().chars().count();
    *legend += match last {
        0 => "",
        _ if last + entry.chars().count() + 3 > WIDTH => "\n",
        _ => "   ",
    };
    *legend += entry;
}

fn shade(chart: &Chart, canvas: &mut Canvas, rows: usize) {
    let Some(field) = &chart.field else { return };
    let inside =
        |edges: &[f64], value: f64| edges.windows(2).position(|pair| (pair[0]..=pair[1]).contains(&value));
    let value = |axis: &Axis, part: f64| {
        let [first, last] = axis.ends();
        let at = first + part * (last - first);
        if axis.is_logarithmic { 10f64.powf(at) } else { at }
    };
    let (shades, columns) = (field.shades(), canvas.columns);
    for (index, letter) in canvas.letters.iter_mut().enumerate() {
        let part = |at: usize, count: usize| (at as f64 + 0.5) / count as f64;
        let x = inside(&field.edges[0], value(&chart.across, part(index % columns, columns)));
        let y = inside(&field.edges[1], value(&chart.up, 1.0 - part(index / columns, rows)));
        let shade = x.zip(y).and_then(|(x, y)| *shades.get(y * (field.edges[0].len() - 1) + x)?);
        *letter = shade.map(|shade| BLOCKS[shade * BLOCKS.len() / SHADES]);
    }
}

/// The abscissa: its ticks, their numbers, and its title.
fn axis(chart: &Chart, across: &[f64], margin: usize, columns: usize) -> String {
    let [left, right] = chart.across.ends();
    let (mut line, mut numbers) = (vec!['─'; columns], String::new());
    for at in across {
        let column = ((at - left) / (right - left) * (columns - 1) as f64).round() as usize;
        if let Some(cell) = line.get_mut(column) {
            *cell = '┬';
        }
        let label = chart.across.label(*at, across);
        let length = label.chars().count();
        let from = (margin + 2 + column).saturating_sub(length / 2).min(WIDTH - length);
        let end = numbers.chars().count();
        if end == 0 || from > end {
            numbers += &format!("{:1$}{label}", "", from - end);
        }
    }
    let line: String = line.into_iter().collect();
    format!(
        "{:margin$} └{line}\n{numbers}\n{:>2$}\n",
        "",
        chart.across.title,
        margin + 2 + columns / 2 + chart.across.title.chars().count() / 2
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::chart::Curve;
    use crate::report::svg::BLUE;

    fn drawn(chart: &Chart) -> Vec<String> {
        let text = terminal(chart, 11);
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH && line == line.trim_end()), "{text}");
        text.lines().map(str::to_owned).collect()
    }

    #[test]
    fn a_line_rises_from_corner_to_corner_and_points_have_letters_at_their_places() {
        let across = Axis::linear("time [s]", [0.0, 10.0], 5);
        let up = Axis::linear("gap [mm]", [0.0, 1.0], 5);
        let line = Curve::new("", BLUE, Mark::line(0, 1.0), [(0.0, 0.0), (10.0, 1.0)]);
        let points =
            Curve::new("runs", BLUE, Mark::point(0, 4.0), [(5.0, 0.0), (f64::NAN, 0.5), (20.0, 0.5)]);
        let lines = drawn(&Chart::new("title", across, up, vec![line, points]));
        assert_eq!((lines[0].as_str(), lines[1].as_str()), ("title: gap [mm]", "o runs"));
        // The first row of the plot has the last dots, the last row the first ones and the only point within the axes.
        assert!(lines[2].starts_with("  1 ┤") && lines[2].chars().count() == WIDTH, "{lines:?}");
        let bottom: Vec<char> = lines[12].chars().collect();
        assert!(
            lines[12].starts_with("  0 ┤") && ('\u{2801}'..='\u{28ff}').contains(&bottom[5]),
            "{lines:?}"
        );
        assert_eq!(bottom.iter().position(|letter| *letter == 'o'), Some(5 + 47));
        assert_eq!(lines.iter().map(|line| line.matches('o').count()).sum::<usize>(), 2, "{lines:?}");
        // From the left of one row to the right of it the columns rise.
        let first = |line: &String| line.chars().skip(5).position(|letter| letter != ' ');
        assert!(lines[2..13].windows(2).all(|pair| first(&pair[0]) > first(&pair[1])), "{lines:?}");
        assert!(lines[14].split_whitespace().eq(["0", "2", "4", "6", "8", "10"]), "{lines:?}");
        assert_eq!(lines[15].trim(), "time [s]");
    }

    #[test]
    fn cells_are_blocks_by_their_values() {
        let axes = ["x", "y"].map(|title| Axis::linear(title, [0.0, 1.0], 4));
        let values = vec![Some(0.0), None, Some(1.0), Some(2.0)];
        let scale = Axis::linear("power [W]", [0.0, 2.0], 4);
        let lines = drawn(&Chart::map(axes, [vec![0.5, 1.5], vec![1.0, 2.0]], scale, values));
        let ends = |line: &String| (line.chars().nth(10), line.chars().nth(95));
        assert_eq!(ends(&lines[1]), (Some('▒'), Some('█')), "{lines:?}");
        assert_eq!(ends(&lines[10]), (Some('·'), None), "{lines:?}");
    }
}

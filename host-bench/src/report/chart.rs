//! A chart as data: axes, curves and cells of colours. [`super::draw`] makes an SVG of it, [`super::page`] an interactive page.

use plotters::style::RGBColor;

use super::svg::{decimal, even_ticks, extremes, linear_ticks, logarithmic_ticks, range, shade, tick_label};

#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Axis {
    /// The quantity with its unit.
    pub(crate) title: String,
    /// Its first and its last value.
    pub(crate) span: [f64; 2],
    /// Approximate number of labels.
    ticks: usize,
    pub(super) is_logarithmic: bool,
    /// The numbers at places from 0 to 1 at equal distances, of an axis whose values are such places.
    pub(super) numbers: Option<Vec<f64>>,
}

/// The span of an ordinate that holds the points of its chart. An end that is no number holds the points too.
pub(crate) const FITTING: [f64; 2] = [f64::NAN; 2];
pub(crate) const FROM_ZERO: [f64; 2] = [0.0, f64::NAN];

impl Axis {
    /// Equal distances for equal differences.
    pub(crate) fn linear(title: impl Into<String>, span: [f64; 2], ticks: usize) -> Self {
        Self { title: title.into(), span, ticks, is_logarithmic: false, numbers: None }
    }

    /// Equal distances for equal ratios.
    pub(crate) fn logarithmic(title: impl Into<String>, span: [f64; 2]) -> Self {
        Self { title: title.into(), span, ticks: 12, is_logarithmic: true, numbers: None }
    }

    /// Equal distances for equal ratios if `is_logarithmic`, else for equal differences.
    pub(crate) fn scaled(is_logarithmic: bool, title: impl Into<String>, span: [f64; 2]) -> Self {
        if is_logarithmic { Self::logarithmic(title, span) } else { Self::linear(title, span, 8) }
    }

    /// Places from 0 to 1 with these numbers at equal distances.
    pub(crate) fn of_numbers(title: impl Into<String>, numbers: Vec<f64>) -> Self {
        Self { numbers: Some(numbers), ..Self::linear(title, [0.0, 1.0], 8) }
    }

    /// The place of a value on a linear scale.
    pub(super) fn place(&self, value: f64) -> f64 {
        if self.is_logarithmic { value.log10() } else { value }
    }

    /// Places of both ends.
    pub(super) fn ends(&self) -> [f64; 2] {
        self.span.map(|value| self.place(value))
    }

    pub(super) fn places(&self) -> Vec<f64> {
        let [first, last] = self.ends();
        if let Some(numbers) = &self.numbers {
            even_ticks(numbers)
        } else if self.is_logarithmic {
            logarithmic_ticks(first, last, self.ticks)
        } else {
            linear_ticks(first, last, self.ticks)
        }
    }

    /// The number at a place among all of them.
    pub(super) fn label(&self, place: f64, all: &[f64]) -> String {
        if let Some(numbers) = &self.numbers {
            // On the line between two.
            let at = place.clamp(0.0, 1.0) * (numbers.len() - 1) as f64;
            let below = (at as usize).min(numbers.len().saturating_sub(2));
            let rise = numbers.get(below + 1).map_or(0.0, |next| next - numbers[below]);
            // To a hundredth of the decade of the span, as its ticks are.
            let span = numbers[numbers.len() - 1] - numbers[0];
            let digits = (2.0 - span.log10().floor()).clamp(0.0, 9.0) as usize;
            return decimal(numbers[below] + (at - below as f64) * rise, digits);
        }
        let value = |place: f64| if self.is_logarithmic { 10f64.powf(place) } else { place };
        tick_label(value(place), all.iter().map(|place| value(*place)), self.is_logarithmic)
    }

    /// Edges of the cells around these values, of which there are at least two.
    fn edges(&self, middles: &[f64]) -> Vec<f64> {
        let at = |index: usize| self.place(middles[index]);
        let between = |index: usize| 0.5 * (at(index) + at(index + 1));
        let last = middles.len() - 1;
        let inner = (0..last).map(between);
        let all = std::iter::once(2.0 * at(0) - between(0)).chain(inner);
        let all = all.chain([2.0 * at(last) - between(last - 1)]);
        all.map(|place| if self.is_logarithmic { 10f64.powf(place) } else { place }).collect()
    }
}

/// How a curve is drawn: a line through its points, a sign at each of them, or both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mark {
    /// The width of the line; 0 of an unbroken one, or one more than the index of its dashes.
    pub(super) line: Option<(f64, usize)>,
    /// The size of the signs; 0 of a circle, or one more than the index of a polygon; whether they are filled.
    pub(super) point: Option<(f64, usize, bool)>,
}

/// Lengths in pixels of dashes and of the gaps behind them.
pub(super) const DASHES: [&str; 5] = ["7 5", "2 4", "14 4 2 4", "16 6", "9 3 2 3 2 3"];
/// The corners of a square, a cross, a triangle, a lozenge and a triangle on its head, to the right and down, in half of their size.
pub(super) const SIGNS: [&[[f64; 2]]; 5] = [
    &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9], [-0.9, -0.9]],
    &[[-1.0, -1.0], [1.0, 1.0], [0.0, 0.0], [1.0, -1.0], [-1.0, 1.0], [0.0, 0.0], [-1.0, -1.0]],
    &[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8], [0.0, -1.2]],
    &[[-1.2, 0.0], [0.0, -1.2], [1.2, 0.0], [0.0, 1.2], [-1.2, 0.0]],
    &[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8], [0.0, 1.2]],
];
/// Kinds of points of one chart whose signs differ.
pub(crate) const MARKS: usize = 2 + SIGNS.len();

impl Mark {
    /// The line of a curve among others, by its number: its dashes tell it to those who do not see its colour.
    pub(crate) const fn line(number: usize, width: f64) -> Self {
        Self { line: Some((width, number % (1 + DASHES.len()))), point: None }
    }

    /// The signs of the points of one kind among others, by its number.
    pub(crate) const fn point(number: usize, size: f64) -> Self {
        let number = number % MARKS;
        Self { line: None, point: Some((size, number.saturating_sub(1), number == 0)) }
    }

    /// Both: a line of this width with a dot of this diameter at each point; a dashed one with rings by the number 1.
    pub(crate) const fn dotted(number: usize, [line, dot]: [f64; 2]) -> Self {
        Self { point: Self::point(number, dot).point, ..Self::line(number, line) }
    }

    /// Both, with signs of this shape: a line with filled ones, or dashes with hollow ones.
    pub(crate) const fn of_shape(shape: usize, is_hollow: bool, [line, size]: [f64; 2]) -> Self {
        Self { point: Some((size, shape, !is_hollow)), ..Self::line(is_hollow as usize, line) }
    }

    /// The line alone, and the signs alone, as far as there are any.
    pub(super) fn parts(self) -> impl Iterator<Item = Self> {
        let parts = [Self { point: None, ..self }, Self { line: None, ..self }];
        parts.into_iter().filter(|part| part.line.is_some() || part.point.is_some())
    }

    /// The width of the line, or the size of signs alone.
    pub(super) fn size(self) -> f64 {
        self.line.map(|line| line.0).or(self.point.map(|point| point.0)).unwrap_or(0.0)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    /// Name in the legend; empty for a curve that the legend does not have.
    pub(crate) name: String,
    pub(crate) colour: RGBColor,
    pub(crate) mark: Mark,
    /// A line has a gap at a point that is not a number.
    pub(crate) points: Vec<(f64, f64)>,
    /// For each point half the length of its vertical bar, such as a standard deviation; empty without bars.
    pub(crate) bars: Vec<f64>,
    /// For each point what a page says of it besides its values; empty without.
    pub(crate) notes: Vec<String>,
    /// Whether only a page has it, after a click on its name.
    pub(crate) is_hidden: bool,
}

/// Least part of the height of a curve that a jump has, and how much larger than the differences beside it it is.
const JUMP: [f64; 2] = [0.08, 5.0];

impl Curve {
    pub(crate) fn new(
        name: impl Into<String>,
        colour: RGBColor,
        mark: Mark,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points = points.into_iter().collect();
        let (bars, notes) = (Vec::new(), Vec::new());
        Self { name: name.into(), colour, mark, points, bars, notes, is_hidden: false }
    }

    /// Those of one kind by their names and points, told apart by colours and by the marks of this size of their numbers.
    pub(crate) fn distinct<N: Into<String>, P: IntoIterator<Item = (f64, f64)>>(
        colours: &[RGBColor],
        (mark, size): (fn(usize, f64) -> Mark, f64),
        named: impl IntoIterator<Item = (N, P)>,
    ) -> Vec<Self> {
        let numbered = named.into_iter().zip(colours.iter().cycle()).enumerate();
        numbered
            .map(|(at, ((name, points), colour))| Self::new(name, *colour, mark(at, size), points))
            .collect()
    }

    /// Points with a note each; nothing without a point.
    pub(crate) fn noted(
        name: &str,
        colour: RGBColor,
        mark: Mark,
        points: impl Iterator<Item = ((f64, f64), String)>,
    ) -> Option<Self> {
        let (points, notes): (Vec<(f64, f64)>, Vec<String>) = points.unzip();
        (!points.is_empty()).then(|| Self { notes, ..Self::new(name, colour, mark, points) })
    }

    /// The same with a gap at each jump: where neighbours differ by much more than those beside, a line would show a slope that was not computed.
    pub(crate) fn broken_at_jumps(self) -> Self {
        let points = &self.points;
        let (low, high) = extremes(points.iter().map(|point| point.1));
        let difference = |index: Option<usize>| {
            let pair = index.and_then(|index| Some([points.get(index)?.1, points.get(index + 1)?.1]));
            pair.map_or(0.0, |[one, next]| (next - one).abs())
        };
        let jumps = |index: usize| {
            let beside = difference(index.checked_sub(1)).max(difference(Some(index + 1)));
            let here = difference(Some(index));
            here > JUMP[0] * (high - low) && here > JUMP[1] * beside
        };
        // Fewer points have no neighbours to compare with.
        if points.len() < 5 {
            return self;
        }
        let mut broken = Vec::with_capacity(points.len());
        for (index, point) in points.iter().enumerate() {
            broken.push(*point);
            if jumps(index) {
                broken.push((f64::NAN, f64::NAN));
            }
        }
        Self { points: broken, ..self }
    }
}

/// Cells between the edges of columns and rows; the columns run fastest.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Field {
    /// Edges on the abscissa and on the ordinate, rising, one more than columns and rows.
    pub(super) edges: [Vec<f64>; 2],
    /// What the colour of each cell is of; a cell without is white.
    pub(super) values: Vec<Option<f64>>,
    /// The quantity of the values, and those of the first and of the last colour.
    pub(super) scale: Axis,
    /// The readouts of a cell at the pointer: values of its column, of its row, and of itself.
    pub(crate) readouts: Vec<Readout>,
}

/// A readout at the pointer: a quantity with its unit in brackets, and its value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Readout {
    /// Of each column.
    Column(String, Vec<f64>),
    /// Of each row.
    Row(String, Vec<f64>),
    /// Of each cell.
    Cell(String, Vec<Option<f64>>),
    /// Of each cell one of these texts, by its index.
    Text(&'static [&'static str], Vec<usize>),
}

/// Colours from the least to the largest value.
pub(super) const SHADES: usize = 64;

pub(super) fn colour(shade_index: usize) -> RGBColor {
    shade(shade_index as f64, 0.0, (SHADES - 1) as f64)
}

impl Field {
    /// The index of the colour of each cell.
    pub(super) fn shades(&self) -> Vec<Option<usize>> {
        let [least, most] = self.scale.ends();
        let index = |value: &Option<f64>| {
            let place = self.scale.place((*value)?);
            let part = if most > least { (place - least) / (most - least) } else { 0.5 };
            Some((part.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as usize)
        };
        self.values.iter().map(index).collect()
    }
}

/// Curves, and cells of colours below them, over two axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Chart {
    pub(crate) title: String,
    pub(crate) across: Axis,
    pub(crate) up: Axis,
    pub(crate) curves: Vec<Curve>,
    pub(crate) field: Option<Field>,
    /// Whether curves are drawn in the order of their points, such as orbits; else over rising abscissae.
    pub(crate) is_orbit: bool,
    pub(crate) note: String,
    /// In pixels.
    pub(crate) height: u32,
    /// Whether it has half of the width of an SVG.
    pub(crate) is_half: bool,
    /// Whether an SVG does not have it.
    pub(crate) is_of_page: bool,
    /// Charts of one group show the same part of the abscissa.
    pub(crate) group: String,
}

impl Chart {
    /// Curves over axes, of which the ordinate may be [`FITTING`] or [`FROM_ZERO`].
    pub(crate) fn new(title: impl Into<String>, across: Axis, mut up: Axis, curves: Vec<Curve>) -> Self {
        let ordinates = || curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
        let (low, high) = if ordinates().any(f64::is_finite) { range(ordinates()) } else { (0.0, 1.0) };
        let [first, last] = up.span;
        up.span = [if first.is_nan() { low } else { first }, if last.is_nan() { high } else { last }];
        // Values that are all 0 have no range of their own.
        if up.span[1] - up.span[0] < 1e-250 && first.is_finite() && last.is_nan() {
            up.span[1] = up.span[0] + 1.0;
        }
        Self { title: title.into(), across, up, curves, height: 320, ..Self::default() }
    }

    /// Cells around the values of both axes, which rise, with the quantity of their values.
    pub(crate) fn map(
        [mut across, mut up]: [Axis; 2],
        [columns, rows]: [Vec<f64>; 2],
        mut scale: Axis,
        values: Vec<Option<f64>>,
    ) -> Self {
        let (least, most) = extremes(values.iter().flatten().copied());
        if scale.span[1].is_nan() {
            scale.span = if least <= most { [least, most] } else { [f64::from(scale.is_logarithmic); 2] };
        }
        let edges = [across.edges(&columns), up.edges(&rows)];
        [across.span, up.span] = edges.each_ref().map(|edges| [edges[0], edges[edges.len() - 1]]);
        let readouts = vec![
            Readout::Column(across.title.clone(), columns),
            Readout::Row(up.title.clone(), rows),
            Readout::Cell(scale.title.clone(), values.clone()),
        ];
        let field = Some(Field { edges, values, scale, readouts });
        Self { field, height: 560, ..Self::new("", across, up, Vec::new()) }
    }

    /// What it shows, for those who do not see it.
    pub(super) fn words(&self) -> String {
        let colours =
            self.field.as_ref().map_or_else(String::new, |field| format!("{} over ", field.scale.title));
        let axes = format!("{colours}{} over {}", self.up.title, self.across.title);
        if self.title.is_empty() { axes } else { format!("{}: {axes}", self.title) }
    }

    /// Whether it has a cell without a value.
    pub(crate) fn has_white(&self) -> bool {
        self.field.as_ref().is_some_and(|field| field.values.iter().any(Option::is_none))
    }

    /// The same of a group, with a height in pixels.
    pub(crate) fn grouped(self, group: &str, height: u32) -> Self {
        Self { group: group.to_owned(), height, ..self }
    }
}

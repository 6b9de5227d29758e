//! The pictures of all commands, each as SVG or as a page, and the report on error against run time.

pub(crate) mod chart;
mod draw;
pub(crate) mod file;
pub(crate) mod page;
pub(crate) mod setting;
pub(crate) mod svg;
mod terminal;

use plotters::style::RGBColor;

use self::chart::{Axis, Chart, Curve, Mark};
pub(crate) use self::draw::draw;
use self::file::refused;
use self::page::{Page, escaped};
pub(crate) use self::terminal::terminal;
use crate::method::{Failure, Math, Method, Precision};
use crate::rows::headings;
use crate::work_precision::table::resistance;
use crate::work_precision::triboelectric::method_name;
use crate::work_precision::{Comparison, Variant};

/// What a command shows: charts, drawn as SVG or as a page.
#[derive(Debug, Default)]
pub(crate) struct Picture {
    pub(crate) title: String,
    /// Of an SVG, in pixels.
    pub(crate) width: u32,
    pub(crate) charts: Vec<Chart>,
    /// An SVG below the charts, with its height.
    pub(crate) figure: Option<(u32, String)>,
    /// Plain text below the charts of a page.
    pub(crate) text: String,
}

impl Picture {
    pub(crate) fn svg(&self) -> Result<String, Failure> {
        if self.charts.is_empty() && self.figure.is_none() {
            return Err(refused("there is nothing to show"));
        }
        file::svg(self.width, &self.title, &self.charts, self.figure.as_ref()).map_err(refused)
    }

    pub(crate) fn page(&self) -> Result<String, Failure> {
        if self.charts.is_empty() && self.figure.is_none() {
            // An error that says so.
            return self.svg();
        }
        let mut page = Page::new(&self.title);
        self.add_to(&mut page)?;
        Ok(page.html())
    }

    /// Adds the charts and the text to a page; on paper and without scripts the SVG stands for the charts.
    pub(crate) fn add_to(&self, page: &mut Page) -> Result<(), Failure> {
        self.charts.iter().for_each(|chart| page.chart(chart));
        if self.charts.iter().any(|chart| !chart.is_of_page) {
            page.still(&draw(self.width, "", &self.charts, None).map_err(refused)?);
        }
        if let Some((_, figure)) = &self.figure {
            page.add(&format!("<figure>{figure}</figure>\n"));
        }
        if !self.text.is_empty() {
            page.add(&format!("<pre>{}</pre>\n", escaped(&self.text)));
        }
        Ok(())
    }
}

pub(crate) fn report(comparisons: &[Comparison]) -> Result<String, Failure> {
    let mut page = Page::new("Vibration energy harvesters: error against run time");
    page.add(
        "<p>The triboelectric harvesters on the embedded core, run on this host, against an independent \
         reference in double precision. Lower and further left is better. In contact-separation the motion \
         hits the dielectric in every period, and the power comes in a spike at each contact; in sliding, \
         friction turns round at every reversal and the overlap has a corner in the middle. Rows with an error above 1 are \
         in the tables only.</p>\n",
    );
    for comparison in comparisons {
        let quantity = match comparison.scene.bump_stop() {
            Err(_) => {
                let load = resistance(comparison.scene.load.resistance_ohm());
                let methods = [Method::ExponentialRadau, Method::TrBdf2, Method::Rk4, Method::Reference];
                let fastest = comparison.fastest_note(methods, |row| row.variant.control.to_string());
                let (file, summary) = (escaped(&comparison.file()), escaped(&fastest));
                page.add(&format!("<h2>{file}, load: {load}</h2>\n<p>{summary}</p>\n"));
                let charts = vec![chart(comparison)];
                Picture { width: 980, charts, ..Picture::default() }.add_to(&mut page)?;
                "mean power"
            }
            Ok(_) => {
                let title = escaped(&comparison.title());
                page.add(&format!(
                    "<h2>Bump-stop harvester</h2>\n<p>A piezoelectric cantilever that hits a rod, by the core's method \
                     (exact modal steps, the contact a discrete gradient) beside general methods on the host. {title}</p>\n"
                ));
                "RMS voltage"
            }
        };
        let rows = comparison.rows.iter().map(|row| {
            let is_beyond = !comparison.reaches_target(row) && row.variant.method != Method::Reference;
            (if is_beyond { "beyond" } else { "" }, comparison.cells(row))
        });
        page.table(&headings(comparison.kind.columns), rows, comparison.kind.words);
        let grey = format!("Grey: {quantity} not within {:.0e} of the reference.", comparison.target_error());
        std::iter::once(grey).chain(comparison.notes()).for_each(|note| page.note(&note));
    }
    Ok(page.html())
}

/// The part of a comparison that a terminal has room for: a curve for each method in double precision, and what `auto` takes.
pub(crate) fn short_chart(comparison: &Comparison) -> Chart {
    let mut chart = chart(comparison);
    chart.curves.retain(|curve| !curve.name.ends_with("f32"));
    for curve in &mut chart.curves {
        curve.mark = Mark::point(0, 8.0);
        curve.name = curve.name.replace(", f64", "");
    }
    let points = || chart.curves.iter().flat_map(|curve| &curve.points);
    let spans = [decades(points().map(|point| point.0)), decades(points().map(|point| point.1))];
    (chart.across.span, chart.up.span) = (spans[0], spans[1]);
    let asked = comparison.target_error();
    let line = spans[0].map(|time| (time, asked));
    chart.curves.push(Curve::new(format!("asked: {asked:.0e}"), svg::BLACK, Mark::line(1, 1.0), line));
    Chart { title: String::new(), ..chart }
}

/// Error against run time: a curve for each method and precision. Rows with other elementary functions than the polynomials,
/// and rows with an error above 1, are in the table only.
fn chart(comparison: &Comparison) -> Chart {
    let mut curves: Vec<Curve> = Vec::new();
    for row in &comparison.rows {
        let Some(found) = &row.found else { continue };
        let Some(error) = comparison.error(row) else { continue };
        if error > 1.0 || row.variant.math.is_some_and(|math| math != Math::Polynomial) {
            continue;
        }
        let name = format!("{}, {}", method_name(&row.variant), row.variant.precision.name());
        let place = curves.iter().position(|curve| curve.name == name).unwrap_or_else(|| {
            let (colour, shape, size) = look(&row.variant);
            let mark = Mark::of_shape(shape, row.variant.precision == Precision::F32, [2.0, size]);
            curves.push(Curve::new(name, colour, mark, []));
            curves.len() - 1
        });
        // In the order of their times.
        let Curve { points, notes, .. } = &mut curves[place];
        let time = found.ns_per_s / 1e3;
        let at = points.partition_point(|point| point.0 <= time);
        points.insert(at, (time, error.max(1e-16)));
        notes.insert(at, format!("step or tolerance: {}", row.variant.control));
    }
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let spans = [decades(all().map(|point| point.0)), decades(all().map(|point| point.1))];
    let title = format!("{}, R = {}", comparison.file(), resistance(comparison.scene.load.resistance_ohm()));
    let across = Axis::logarithmic("host time per simulated second [µs]", spans[0]);
    let up = Axis::logarithmic("relative error of mean power", spans[1]);
    Chart { height: 520, ..Chart::new(title, across, up, curves) }
}

/// Colour, shape and size of the signs of a method. Of auto, one row, the sign is wider than that of the method which it takes.
fn look(variant: &Variant) -> (RGBColor, usize, f64) {
    match method_name(variant) {
        "exponential Radau" => (svg::BLACK, 0, 8.0),
        "auto" => (svg::SKY, 0, 14.0),
        "exponential Radau, fixed step" => (svg::PURPLE, 1, 8.0),
        "TR-BDF2" => (svg::BLUE, 3, 8.0),
        "TR-BDF2, fixed step" => (svg::ORANGE, 4, 8.0),
        "RK4, fixed step" => (svg::VERMILION, 5, 8.0),
        _ => (svg::GREEN, 2, 8.0),
    }
}

/// The whole decades that hold the values.
fn decades(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = svg::extremes(values);
    if !(high > 0.0) {
        return [0.97e-1, 1.03];
    }
    let (low, high) = (low.log10().floor(), high.log10().ceil());
    // A little wider than the decades, so that both ends have ticks.
    [0.97 * 10f64.powf(low), 1.03 * 10f64.powf(if high > low { high } else { low + 1.0 })]
}

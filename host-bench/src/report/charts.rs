//! Charts of a page with zoom, hover and toggles. The page is one file and needs no network.
//!
//! uPlot 1.6.32 (MIT, its licence beside it) draws the curves of a [`Plot`].

use serde_json::{Value, json};

use super::field::Field;
use super::plot::{Curve, Mark, Plot};
use super::svg::extremes;

const LIBRARY: &str = include_str!("uplot/uPlot.iife.min.js");
const STYLE: &str = include_str!("uplot/uPlot.min.css");
/// The text beside the pointer.
const TIP: &str = ".tip{position:absolute;display:none;pointer-events:none;white-space:pre;z-index:10;background:#fff;\
border:1px solid #57606a;border-radius:4px;padding:.2rem .5rem;font-size:.8rem;line-height:1.35}.uplot{margin:1rem 0}.frame{display:none!important}\
.scale{font-size:.85rem;margin:0 0 1rem 4.5rem}.scale span{display:inline-block;width:16rem;height:.8rem;margin:0 .4rem}";
/// Makes a chart of each object of `charts`.
const SCRIPT: &str = include_str!("charts.js");

/// What a reader can do, as a paragraph.
pub(crate) const HINT: &str = "<p>Drag over a chart to zoom, double-click for all of it. The pointer shows the nearest point; \
a click on a name hides its curve.</p>\n";

/// How a chart stands in its page.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Look<'a> {
    /// In pixels, names of the curves excluded.
    pub(crate) height: u32,
    /// Charts of one group show the same part of the abscissa.
    pub(crate) group: Option<&'a str>,
}

impl Look<'_> {
    pub(crate) const ALONE: Self = Look { height: 420, group: None };
}

/// What is particular of a chart.
#[derive(Debug, Clone, Copy)]
enum Kind<'a> {
    /// Curves over rising abscissae.
    Curves,
    /// Curves in the order of their points, such as orbits.
    Orbits,
    /// Cells of colours below the curves.
    Cells(&'a Field),
}

/// The charts of one page.
#[derive(Debug, Default)]
pub(crate) struct Charts(Vec<Value>);

impl Charts {
    /// Adds a chart, and returns the element of the page in which it will stand.
    pub(crate) fn place(&mut self, plot: &Plot, look: Look<'_>) -> String {
        self.place_kind(plot, look, Kind::Curves)
    }

    /// As [`Charts::place`], of curves whose points stay in their order.
    pub(crate) fn place_orbits(&mut self, plot: &Plot, look: Look<'_>) -> String {
        self.place_kind(plot, look, Kind::Orbits)
    }

    /// As [`Charts::place`], with cells below the curves and the scale of their colours below the chart.
    pub(crate) fn place_field(&mut self, plot: &Plot, field: &Field, look: Look<'_>) -> String {
        self.place_kind(plot, look, Kind::Cells(field)) + &field.scale()
    }

    fn place_kind(&mut self, plot: &Plot, look: Look<'_>, kind: Kind<'_>) -> String {
        let element = format!("<div id=\"chart-{}\"></div>\n", self.0.len());
        let is_orbit = matches!(kind, Kind::Orbits);
        self.0.push(json!({
            "title": plot.title,
            "across": plot.across.title,
            "up": plot.up.title,
            "logarithmic": [plot.across.is_logarithmic(), plot.up.is_logarithmic()],
            "height": look.height,
            "group": look.group,
            "curves": curves(plot, is_orbit),
            "orbits": is_orbit,
            "span": (!matches!(kind, Kind::Curves)).then_some([plot.across.span, plot.up.span]),
            "field": if let Kind::Cells(field) = kind { field.json() } else { Value::Null },
        }));
        element
    }

    /// Style and scripts, which stand behind the elements.
    pub(crate) fn scripts(&self) -> String {
        // A text in the data must not end the script, nor begin a comment or a script in it.
        let data = Value::Array(self.0.clone()).to_string().replace('<', "\\u003c");
        format!(
            "<style>{STYLE}{TIP}</style>\n<script>{LIBRARY}</script>\n<script>const charts = {data};\n{SCRIPT}</script>\n"
        )
    }
}

/// The curves as the script wants them. Dots without a name are those of the line before them.
fn curves(plot: &Plot, is_orbit: bool) -> Vec<Value> {
    let mut all: Vec<Value> = Vec::new();
    let mut before: Option<&Curve> = None;
    for one in &plot.curves {
        let dot = match one.mark {
            Mark::Dots(size) | Mark::Rings(size) => Some((size, matches!(one.mark, Mark::Rings(_)))),
            Mark::Line(_) | Mark::Dashes(_) => None,
        };
        let is_of_line =
            |line: &&Curve| matches!(line.mark, Mark::Line(_) | Mark::Dashes(_)) && line.colour == one.colour;
        match (dot, before.filter(is_of_line), all.last_mut()) {
            (Some((size, is_ring)), Some(_), Some(last)) if one.name.is_empty() => {
                last["dot"] = json!(size);
                last["ring"] = json!(is_ring);
            }
            _ => all.push(curve(one, &plot.up.title, is_orbit)),
        }
        before = Some(one);
    }
    all
}

fn curve(curve: &Curve, quantity: &str, is_orbit: bool) -> Value {
    let (line, dot) = match curve.mark {
        Mark::Line(width) | Mark::Dashes(width) => (width, 0.0),
        Mark::Dots(size) | Mark::Rings(size) => (0.0, size),
    };
    let mut value = json!({
        "name": if curve.name.is_empty() { quantity } else { &curve.name },
        "named": !curve.name.is_empty(),
        "colour": format!("#{:02X}{:02X}{:02X}", curve.colour.0, curve.colour.1, curve.colour.2),
        "line": line,
        "dashed": matches!(curve.mark, Mark::Dashes(_)),
        "dot": dot,
        "ring": matches!(curve.mark, Mark::Rings(_)),
    });
    let (rows, x): (Vec<usize>, Vec<f64>) = abscissae(&curve.points).into_iter().unzip();
    let rows = if is_orbit { (0..curve.points.len()).collect() } else { rows };
    let of = |values: &[f64]| rows.iter().map(|&row| short(values[row])).collect::<Vec<Value>>();
    value["x"] = if is_orbit {
        of(&curve.points.iter().map(|point| point.0).collect::<Vec<f64>>()).into()
    } else {
        json!(x)
    };
    value["y"] = of(&curve.points.iter().map(|point| point.1).collect::<Vec<f64>>()).into();
    if curve.bars.len() == curve.points.len() && !curve.bars.is_empty() {
        value["bars"] = of(&curve.bars).into();
    }
    if curve.notes.len() == curve.points.len() && !curve.notes.is_empty() {
        value["notes"] = rows.iter().map(|&row| json!(curve.notes[row])).collect();
    }
    value
}

/// Seven digits, more than a screen shows; nothing for what is not a number.
pub(super) fn short(value: f64) -> Value {
    json!(format!("{value:.6e}").parse::<f64>().ok().filter(|value| value.is_finite()))
}

/// The points in the order of their abscissae, with these: the library takes rising ones only. A step has two points at one
/// abscissa, and a gap, which has none, is between its neighbours.
fn abscissae(points: &[(f64, f64)]) -> Vec<(usize, f64)> {
    let (low, high) = extremes(points.iter().map(|point| point.0).filter(|x| x.is_finite()));
    // The digits of a double allow for it, and no screen shows it.
    let little = 1e-9 * if high > low { high - low } else { 1.0 };
    let at = |index: usize| points.get(index).map(|point| point.0).filter(|x| x.is_finite());
    let place = |index: usize| {
        let beside = [index.checked_sub(1).and_then(at), at(index + 1)];
        at(index).unwrap_or(match beside {
            [Some(before), Some(next)] => 0.5 * (before + next),
            [Some(one), None] | [None, Some(one)] => one,
            [None, None] => 0.0,
        })
    };
    let mut all: Vec<(usize, f64)> = (0..points.len()).map(|index| (index, place(index))).collect();
    all.sort_by(|one, other| one.1.total_cmp(&other.1));
    let mut last = f64::NEG_INFINITY;
    for (_, x) in &mut all {
        *x = x.max(last + little);
        last = *x;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::Axis;
    use crate::report::svg::BLUE;

    fn first(curves: Vec<Curve>) -> Vec<Value> {
        let plot = Plot {
            title: "</script>".to_owned(),
            across: Axis::linear("time [s]", [0.0, 3.0], 4),
            up: Axis::linear("gap [mm]", [0.0, 1.0], 4),
            curves,
        };
        super::curves(&plot, false)
    }

    #[test]
    fn dots_without_a_name_belong_to_their_line() {
        let curves = Curve::dotted("gap", BLUE, [1.5, 6.0], [(0.0, 1.0), (1.0, 2.0)]);
        let found = first(curves.to_vec());
        assert_eq!(found.len(), 1);
        assert_eq!((&found[0]["line"], &found[0]["dot"]), (&json!(1.5), &json!(6.0)));
        let alone = Curve::new("impact", BLUE, Mark::Dots(6.0), [(0.5, 1.0)]);
        assert_eq!(first([&curves[..], &[alone]].concat()).len(), 2);
    }

    #[test]
    fn abscissae_rise_through_steps_and_gaps() {
        let points =
            [(0.0, 1.0), (1.0, 1.0), (1.0, 2.0), (f64::NAN, f64::NAN), (2.0, 2.0), (3.0, f64::INFINITY)];
        let found = &first(vec![Curve::new("", BLUE, Mark::Line(1.0), points)])[0];
        let x: Vec<f64> = found["x"].as_array().expect("a list").iter().filter_map(Value::as_f64).collect();
        assert_eq!(x.len(), 6);
        assert!(x.windows(2).all(|pair| pair[0] < pair[1]), "{x:?}");
        assert!((x[2] - 1.0).abs() < 1e-8 && (x[3] - 1.5).abs() < 1e-8, "{x:?}");
        // A gap and an infinite value are no numbers.
        assert_eq!(found["y"], json!([1.0, 1.0, 2.0, null, 2.0, null]));
    }

    #[test]
    fn an_orbit_keeps_the_order_of_its_points() {
        let plot = Plot {
            title: String::new(),
            across: Axis::linear("gap [mm]", [-2.0, 2.0], 4),
            up: Axis::linear("velocity [m/s]", [-2.0, 2.0], 4),
            curves: vec![Curve::new("", BLUE, Mark::Line(1.0), [(1.0, 0.0), (-1.0, 1.0), (0.5, -1.0)])],
        };
        let mut charts = Charts::default();
        charts.place_orbits(&plot, Look::ALONE);
        let found = &charts.0[0];
        assert_eq!(found["curves"][0]["x"], json!([1.0, -1.0, 0.5]));
        assert_eq!(found["curves"][0]["y"], json!([0.0, 1.0, -1.0]));
        assert_eq!(found["span"], json!([[-2.0, 2.0], [-2.0, 2.0]]));
    }

    #[test]
    fn a_title_cannot_end_the_script() {
        let mut charts = Charts::default();
        let plot = Plot {
            title: "</script><!--<script>".to_owned(),
            across: Axis::linear("x", [0.0, 1.0], 4),
            up: Axis::linear("y", [0.0, 1.0], 4),
            curves: Vec::new(),
        };
        assert_eq!(charts.place(&plot, Look::ALONE), "<div id=\"chart-0\"></div>\n");
        let scripts = charts.scripts();
        assert_eq!([scripts.matches("</script>").count(), scripts.matches("<!--").count()], [2, 0]);
    }
}

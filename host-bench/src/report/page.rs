//! Charts as a page with zoom, hover and toggles. A page is one file and needs no network.
//!
//! uPlot 1.6.32 (MIT, its licence beside it) draws the curves of a [`Chart`].

use std::fmt::Write;

use serde_json::{Value, json};

use super::chart::{Chart, Curve, DASHES, Field, Readout, SHADES, SIGNS, colour};
use super::svg::{extremes, hex, tick};
pub(crate) use crate::name::escaped;

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;color:#1b1f24;background:#fff;max-width:72rem;\
margin:2rem auto;padding:0 1rem}h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2.5rem}\
body>svg,figure>svg{max-width:100%;height:auto}figure{margin:0}.wide{overflow-x:auto}\
.panels{display:flex;flex-wrap:wrap;gap:.5rem}.panels>figure{flex:0 1 auto}\
table{border-collapse:collapse;font-size:clamp(.6rem,1.25vw,.85rem);font-variant-numeric:tabular-nums}\
th{text-align:left;border-bottom:2px solid #57606a;padding:.35em .6em;vertical-align:bottom}\
td{border-bottom:1px solid #d0d7de;padding:.25em .6em}\
td.number,th.number{text-align:right}td.number{white-space:nowrap}tr.beyond td{color:#6e7781}\
pre{white-space:pre-wrap;overflow-wrap:anywhere}p.note{font-size:.85rem;color:#57606a;margin:.3rem 0}\
@media screen and (prefers-color-scheme:dark){html{background:#fff;filter:invert(.9) hue-rotate(180deg)}}\
.still{display:none}@media print{.still{display:block;break-inside:avoid}.screen{display:none}\
body{margin:0;max-width:none;font-size:11px}h2{break-after:avoid}}";
/// Without scripts the stills stand for the charts.
const WITHOUT_SCRIPTS: &str = ".still{display:block}.screen{display:none}";

const LIBRARY: &str = include_str!("uplot/uPlot.iife.min.js");
const CHART_STYLE: &str = include_str!("uplot/uPlot.min.css");
/// The text beside the pointer.
const TIP: &str = ".tip{position:absolute;display:none;pointer-events:none;white-space:pre;z-index:10;background:#fff;\
border:1px solid #57606a;border-radius:4px;padding:.2rem .5rem;font-size:.8rem;line-height:1.35}.u-legend th,.u-legend td{border:0}.uplot{margin:1rem 0}.frame{display:none!important}\
.scale{font-size:.85rem;margin:0 0 1rem 4.5rem}.scale span{display:inline-block;width:16rem;height:.8rem;margin:0 .4rem}";
/// Makes a chart of each object of `charts`.
const SCRIPT: &str = include_str!("charts.js");

/// What a reader can do, as a paragraph.
const HINT: &str = "<p class=\"screen\">Drag over a chart to zoom, double-click for all of it. The pointer shows the nearest point; \
a click on a name hides its curve. By the keyboard: Tab chooses, arrows move, + and − zoom, Escape shows all, Enter on a name hides its curve.</p>\n";

/// A page: its body as it grows, and its charts.
#[derive(Debug)]
pub(crate) struct Page {
    title: String,
    body: String,
    charts: Vec<Value>,
}

impl Page {
    /// The title is plain text.
    pub(crate) fn new(title: &str) -> Self {
        let body = format!("<h1>{}</h1>\n", escaped(title));
        Self { title: title.to_owned(), body, charts: Vec::new() }
    }

    pub(crate) fn add(&mut self, html: &str) {
        self.body += html;
    }

    /// Adds a paragraph of small plain text.
    pub(crate) fn note(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p class=\"note\">{}</p>", escaped(text));
    }

    /// Adds a table of plain text: its headings, and rows with their class, whose cells behind the first few `words` are numbers.
    pub(crate) fn table<'a>(
        &mut self,
        headings: &[impl AsRef<str>],
        rows: impl IntoIterator<Item = (&'a str, Vec<String>)>,
        words: usize,
    ) {
        let line = |cells: &mut dyn Iterator<Item = &str>, tag: &str| -> String {
            let of = |index: usize| if index < words { "" } else { " class=\"number\"" };
            let cells = cells.enumerate();
            cells.map(|(index, cell)| format!("<{tag}{}>{}</{tag}>", of(index), escaped(cell))).collect()
        };
        let heading = line(&mut headings.iter().map(AsRef::as_ref), "th");
        let row = |(class, cells): (&str, Vec<String>)| {
            let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
            format!("<tr{class}>{}</tr>\n", line(&mut cells.iter().map(String::as_str), "td"))
        };
        let rows: String = rows.into_iter().map(row).collect();
        let _ = writeln!(
            self.body,
            "<div class=\"wide\"><table>\n<thead><tr>{heading}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>"
        );
    }

    /// The same of rows of which the first has the headings; nothing without rows.
    pub(crate) fn table_of(&mut self, rows: &[Vec<String>], words: usize) {
        if let Some((headings, rows)) = rows.split_first() {
            self.table(headings, rows.iter().map(|row| ("", row.clone())), words);
        }
    }

    /// Adds a chart, with its note and the scale of its colours.
    pub(crate) fn chart(&mut self, chart: &Chart) {
        if self.charts.is_empty() {
            self.body += HINT;
        }
        // A chart of the page alone has no still.
        let class = if chart.is_of_page { "" } else { " class=\"screen\"" };
        let _ = writeln!(self.body, "<div{class}><div id=\"chart-{}\"></div>", self.charts.len());
        self.body += &chart.field.as_ref().map(scale).unwrap_or_default();
        if !chart.note.is_empty() {
            self.note(&chart.note);
        }
        self.body += "</div>\n";
        let is_curves = !chart.is_orbit && chart.field.is_none();
        self.charts.push(json!({
            "title": chart.title,
            "words": chart.words(),
            "across": chart.across.title,
            "up": chart.up.title,
            "logarithmic": [chart.across.is_logarithmic, chart.up.is_logarithmic],
            "height": chart.height,
            "group": Some(&chart.group).filter(|group| !group.is_empty()),
            "curves": chart.curves.iter().map(|one| curve(one, chart)).collect::<Vec<Value>>(),
            "orbits": chart.is_orbit,
            "span": (!is_curves).then_some([chart.across.span, chart.up.span]),
            "field": chart.field.as_ref().map(|field| cells(field, chart.across.numbers.as_deref())),
        }));
    }

    /// Adds an SVG that stands for charts on paper and without scripts.
    pub(crate) fn still(&mut self, svg: &str) {
        let _ = writeln!(self.body, "<figure class=\"still\">{svg}</figure>");
    }

    /// The page, with style and scripts behind the elements.
    pub(crate) fn html(mut self) -> String {
        if !self.charts.is_empty() {
            // A text in the data must not end the script, nor begin a comment or a script in it.
            let data = Value::Array(self.charts).to_string().replace('<', "\\u003c");
            let _ = writeln!(
                self.body,
                "<style>{CHART_STYLE}{TIP}</style>\n<script>{LIBRARY}</script>\n<script>const charts = {data};\n{SCRIPT}</script>"
            );
        }
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{}</title>\n<style>{STYLE}</style>\n<noscript><style>{WITHOUT_SCRIPTS}</style></noscript>\n</head>\n<body>\n{}</body>\n</html>\n",
            escaped(&self.title),
            self.body
        )
    }
}

fn curve(curve: &Curve, chart: &Chart) -> Value {
    let (width, dashes) = curve.mark.line.unwrap_or_default();
    let (size, shape, is_filled) = curve.mark.point.unwrap_or_default();
    let mut value = json!({
        "name": if curve.name.is_empty() { &chart.up.title } else { &curve.name },
        "named": !curve.name.is_empty(),
        "colour": hex(curve.colour),
        "line": width,
        "dash": dashes.checked_sub(1).map(|at| DASHES[at]),
        "dot": size,
        "filled": is_filled,
        "sign": shape.checked_sub(1).map(|at| SIGNS[at]),
        "hidden": curve.is_hidden,
    });
    let (rows, x): (Vec<usize>, Vec<f64>) = if chart.is_orbit {
        curve.points.iter().map(|point| point.0).enumerate().unzip()
    } else {
        abscissae(&curve.points).into_iter().unzip()
    };
    let numbers = |of: &dyn Fn(usize) -> f64| rows.iter().map(|&row| short(of(row))).collect::<Vec<Value>>();
    value["x"] = if chart.is_orbit { numbers(&|row| x[row]).into() } else { json!(x) };
    value["y"] = numbers(&|row| curve.points[row].1).into();
    if curve.bars.len() == curve.points.len() && !curve.bars.is_empty() {
        value["bars"] = numbers(&|row| curve.bars[row]).into();
    }
    if curve.notes.len() == curve.points.len() && !curve.notes.is_empty() {
        value["notes"] = rows.iter().map(|&row| json!(curve.notes[row])).collect();
    }
    value
}

/// Seven digits, more than a screen shows; nothing for what is not a number.
fn short(value: f64) -> Value {
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

fn readout(readout: &Readout) -> Value {
    let numbers = |values: &[f64]| values.iter().map(|value| short(*value)).collect::<Vec<Value>>();
    match readout {
        Readout::Column(title, values) => {
            json!({ "of": "column", "title": title, "values": numbers(values) })
        }
        Readout::Row(title, values) => json!({ "of": "row", "title": title, "values": numbers(values) }),
        Readout::Cell(title, values) => {
            let values: Vec<f64> = values.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
            json!({ "of": "cell", "title": title, "values": numbers(&values) })
        }
        Readout::Text(texts, indices) => json!({ "of": "cell", "texts": texts, "values": indices }),
    }
}

fn cells(field: &Field, numbers: Option<&[f64]>) -> Value {
    let [x, y] = &field.edges;
    json!({
        "x": x,
        "y": y,
        "palette": (0..SHADES).map(|index| hex(colour(index))).collect::<Vec<String>>(),
        "shades": field.shades(),
        "readouts": field.readouts.iter().map(readout).collect::<Vec<Value>>(),
        "numbers": numbers,
    })
}

fn scale(field: &Field) -> String {
    let [least, most] = field.scale.span.map(tick);
    let stops: Vec<String> = (0..SHADES).step_by(7).map(|index| hex(colour(index))).collect();
    format!(
        "<p class=\"scale\">{}: {least} <span style=\"background:linear-gradient(to right,{})\"></span> {most}</p>\n",
        escaped(&field.scale.title),
        stops.join(",")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::chart::{Axis, Mark};
    use crate::report::svg::BLUE;

    fn orbit_or_not(is_orbit: bool, title: &str, points: &[(f64, f64)]) -> Value {
        let axes = ["time [s]", "gap [mm]"].map(|title| Axis::linear(title, [-2.0, 2.0], 4));
        let [across, up] = axes;
        let curves = vec![Curve::new("", BLUE, Mark::dotted(0, [1.5, 6.0]), points.iter().copied())];
        let mut page = Page::new("");
        page.chart(&Chart { is_orbit, ..Chart::new(title, across, up, curves) });
        page.charts[0].clone()
    }

    #[test]
    fn a_dotted_line_is_one_curve() {
        let found = orbit_or_not(false, "", &[(0.0, 1.0), (1.0, 2.0)]);
        assert_eq!((&found["curves"][0]["line"], &found["curves"][0]["dot"]), (&json!(1.5), &json!(6.0)));
        assert_eq!((found["curves"][1].is_null(), &found["span"]), (true, &Value::Null));
    }

    #[test]
    fn abscissae_rise_through_steps_and_gaps() {
        let points =
            [(0.0, 1.0), (1.0, 1.0), (1.0, 2.0), (f64::NAN, f64::NAN), (2.0, 2.0), (3.0, f64::INFINITY)];
        let found = &orbit_or_not(false, "", &points)["curves"][0];
        let x: Vec<f64> = found["x"].as_array().expect("a list").iter().filter_map(Value::as_f64).collect();
        assert_eq!(x.len(), 6);
        assert!(x.windows(2).all(|pair| pair[0] < pair[1]), "{x:?}");
        assert!((x[2] - 1.0).abs() < 1e-8 && (x[3] - 1.5).abs() < 1e-8, "{x:?}");
        // A gap and an infinite value are no numbers.
        assert_eq!(found["y"], json!([1.0, 1.0, 2.0, null, 2.0, null]));
    }

    #[test]
    fn an_orbit_keeps_the_order_of_its_points() {
        let found = orbit_or_not(true, "", &[(1.0, 0.0), (-1.0, 1.0), (0.5, -1.0)]);
        assert_eq!(found["curves"][0]["x"], json!([1.0, -1.0, 0.5]));
        assert_eq!(found["curves"][0]["y"], json!([0.0, 1.0, -1.0]));
        assert_eq!(found["span"], json!([[-2.0, 2.0], [-2.0, 2.0]]));
    }

    #[test]
    fn a_title_cannot_end_the_script() {
        let mut page = Page::new("");
        page.charts.push(orbit_or_not(false, "</script><!--<script>", &[]));
        let html = page.html();
        assert_eq!([html.matches("</script>").count(), html.matches("<!--").count()], [2, 0]);
    }

    #[test]
    fn cells_have_shades_texts_and_gaps() {
        let axes = ["x", "y"].map(|title| Axis::linear(title, [0.0, 1.0], 4));
        let scale_axis = Axis::linear("<power> [W]", [1.0, 3.0], 4);
        let middles = [vec![0.5, 1.5], vec![1.0, 2.0]];
        let values = vec![Some(3.0), None, Some(1.0), Some(1.9)];
        let mut field = Chart::map(axes, middles, scale_axis, values).field.expect("a field");
        field.readouts.push(Readout::Text(&["one motion", "outside"], vec![0, 1, 0, 0]));
        let json = cells(&field, None);
        assert_eq!([&json["x"], &json["y"]], [&json!([0.0, 1.0, 2.0]), &json!([0.5, 1.5, 2.5])]);
        assert_eq!(json["shades"], json!([63, null, 0, 28]));
        assert_eq!(json["palette"][63], "#FDE725");
        assert_eq!(json["readouts"][2]["values"], json!([3.0, null, 1.0, 1.9]));
        assert_eq!(json["readouts"][3]["texts"][1], "outside");
        assert!(scale(&field).contains("&lt;power&gt; [W]: 1 <") && scale(&field).contains("#FDE725"));
        // One value alone has the middle colour.
        field.values = vec![Some(1.0); 4];
        field.scale.span = [1.0, 1.0];
        assert_eq!(cells(&field, None)["shades"], json!([32, 32, 32, 32]));
    }
}

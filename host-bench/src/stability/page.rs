//! The page of the grid: counts, causes of errors, maps and the cases that fail.

use std::fmt::Write;

use clap::ValueEnum as _;

use super::summary::{causes, classes, statements};
use super::{Case, Class, Finding};
use crate::method::Precision;
use crate::outcome::name;
use crate::report::page::{Page, escaped};
use crate::report::svg::{power_of_ten, tick};

/// The file beside the page that has a row for each case.
pub(crate) const CASES: &str = "cases.csv";

/// A quantity with its unit, and its key of the scene, or [`STEP`].
type Axis = (&'static str, &'static str);

/// The key of the option `--step`.
const STEP: &str = "--step";

/// Which cases a map shows: those of a scene with both quantities.
#[derive(Debug, Clone, Copy)]
struct Map {
    /// The beginning of the name of the shipped scene.
    scene: &'static str,
    across: Axis,
    up: Axis,
}

/// The default of `--step`, below every step.
const DEFAULT: f64 = f64::NEG_INFINITY;

fn value((_, key): Axis, case: &Case) -> Option<f64> {
    if key == STEP { Some(case.step_s.unwrap_or(DEFAULT)) } else { case.number(key) }
}

const RESISTANCE: Axis = ("load resistance [Ω]", "load.resistance_ohm");
const DENSITY: Axis = ("charge density [C/m²]", "parameters.charge_density_c_per_m2");
const FREQUENCY: Axis = ("frequency [Hz]", "excitation.frequency_hz");
const FRICTION: Axis = ("kinetic friction", "parameters.kinetic_friction_active");
const AMPLITUDE: Axis = ("amplitude [m/s²]", "excitation.amplitude_m_per_s2");
const STEP_AXIS: Axis = ("step [s]", STEP);
const GAP: Axis = ("gap [m]", "stop.gap_m");
const BEAM_MODES: Axis = ("beam modes", "parameters.beam_modes");
const MODULUS: Axis = ("modulus of the rod [Pa]", "stop.young_modulus_pa");

const MAPS: [Map; 8] = [
    Map { scene: "contact-separation", across: RESISTANCE, up: DENSITY },
    Map { scene: "contact-separation", across: RESISTANCE, up: FREQUENCY },
    Map { scene: "sliding", across: RESISTANCE, up: DENSITY },
    Map { scene: "sliding", across: RESISTANCE, up: FREQUENCY },
    Map { scene: "sliding", across: AMPLITUDE, up: FRICTION },
    Map { scene: "bump-stop", across: STEP_AXIS, up: GAP },
    Map { scene: "bump-stop", across: STEP_AXIS, up: MODULUS },
    Map { scene: "bump-stop", across: STEP_AXIS, up: BEAM_MODES },
];

/// The page as HTML. The rows are those of the cases, in their order.
pub(crate) fn page(cases: &[Case], rows: &[Finding]) -> String {
    let mut page = Page::new("Stiff and extreme scenes");
    page.add(&format!(
        "<p>{} runs, each judged with its accuracy statement by a more accurate run. Each run is a row of \
         <a href=\"{CASES}\">{CASES}</a>, with the arguments that repeat it.</p>\n",
        rows.len()
    ));
    page.table_of(&classes(rows), 1);
    page.table_of(&statements(rows), 1);
    let causes = causes(rows);
    if causes.len() > 1 {
        page.add("<h2>Named errors by cause</h2>\n");
        page.table_of(&causes, 1);
    }
    for map in MAPS {
        if let Some(tables) = map.tables(cases, rows) {
            let title = format!("{}: {} against {}", map.scene, map.across.0, map.up.0);
            page.add(&format!("<h2>{}</h2>\n{tables}", escaped(&title)));
            page.note(
                "A cell holds every case with both values; the width of a colour is the share of the class.",
            );
        }
    }
    let failing: Vec<&Finding> = rows.iter().filter(|row| row.class.is_failure()).collect();
    if !failing.is_empty() {
        page.add("<h2>Wrong and broken</h2>\n");
        for row in failing {
            let (reason, arguments) = (escaped(&row.reason), escaped(&row.arguments));
            page.add(&format!("<p>{reason}<br><code>{arguments}</code></p>\n"));
        }
    }
    page.html()
}

/// How the tables of a map look.
const STYLE: &str = "<style>.cells{width:auto}.cells td{min-width:1.6rem;height:1.2rem;padding:0;border:1px solid #fff}\
.cells th{border:0;font-weight:normal;padding:0 .3rem}.cells caption,.cells tfoot th{text-align:center}\
.swatch{display:inline-block;width:.8rem;height:.8rem;border:1px solid #57606a;margin:0 .3rem 0 1rem}</style>\n";

impl Map {
    /// A table for each precision, with a coloured cell for each pair of values; `None` where no case has both quantities. The
    /// rows are those of the cases.
    fn tables(&self, cases: &[Case], rows: &[Finding]) -> Option<String> {
        let of_scene = cases.iter().zip(rows).filter(|(case, _)| case.scene.starts_with(self.scene));
        let points: Vec<([f64; 2], Precision, Class)> = of_scene
            .filter_map(|(case, row)| {
                Some(([value(self.across, case)?, value(self.up, case)?], case.precision, row.class))
            })
            .collect();
        points.first()?;
        let [columns, mut lines] = [0, 1].map(|index| values(points.iter().map(|(place, ..)| place[index])));
        lines.reverse();
        let mut text = format!("{STYLE}<p>");
        for class in Class::value_variants() {
            let word = name(class).replace('-', " ");
            let _ =
                write!(text, "<span class=\"swatch\" style=\"background:{}\"></span>{word}", colour(*class));
        }
        text += "</p>\n<div class=\"panels\">\n";
        for precision in [Precision::F32, Precision::F64] {
            let _ = writeln!(
                text,
                "<table class=\"cells\"><caption>{}</caption><tr><th>{}</th></tr>",
                precision.name(),
                escaped(self.up.0)
            );
            for up in &lines {
                let _ = write!(text, "<tr><th>{}</th>", label(*up));
                for across in &columns {
                    let here =
                        points.iter().filter(|(place, of, _)| *place == [*across, *up] && *of == precision);
                    text += &self.cell([*across, *up], &here.map(|(.., class)| *class).collect::<Vec<_>>());
                }
                text += "</tr>\n";
            }
            let labels: String = columns.iter().map(|value| format!("<th>{}</th>", label(*value))).collect();
            let (count, title) = (columns.len(), escaped(self.across.0));
            let _ = writeln!(
                text,
                "<tfoot><tr><th></th>{labels}</tr><tr><th></th><th colspan=\"{count}\">{title}</th></tr></tfoot></table>"
            );
        }
        Some(text + "</div>\n")
    }

    /// A cell with a part for each class, as wide as its share; the counts show where the pointer rests.
    fn cell(&self, place: [f64; 2], classes: &[Class]) -> String {
        let (mut counts, mut parts, mut from) = (Vec::new(), Vec::new(), 0.0);
        for class in Class::value_variants() {
            let count = classes.iter().filter(|found| *found == class).count();
            if count > 0 {
                let to = from + 100.0 * count as f64 / classes.len() as f64;
                counts.push(format!("{count} {}", name(class).replace('-', " ")));
                parts.push(format!("{} {from:.1}% {to:.1}%", colour(*class)));
                from = to;
            }
        }
        if counts.is_empty() {
            return "<td></td>".to_owned();
        }
        let words = [&self.across, &self.up].into_iter().zip(place);
        let words = words.map(|(axis, value)| format!("{} {}", axis.0, label(value)));
        format!(
            "<td title=\"{}: {}\" style=\"background:linear-gradient(to right,{})\"></td>",
            escaped(&words.collect::<Vec<_>>().join(", ")),
            counts.join(", "),
            parts.join(",")
        )
    }
}

fn values(all: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = all.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Colours of Okabe and Ito, and greys.
fn colour(class: Class) -> &'static str {
    match class {
        Class::Right => "#009E73",
        Class::Chaotic => "#0072B2",
        Class::Undecided => "#F0E442",
        Class::Warned => "#E69F00",
        Class::Refused => "#D0D7DE",
        Class::NamedError => "#8C959F",
        Class::StepLimit => "#56B4E9",
        Class::Unjudged => "#CC79A7",
        Class::Wrong => "#D55E00",
        Class::Broken => "#000000",
    }
}

/// A value on an axis: a power of ten as such.
fn label(value: f64) -> String {
    let exponent = value.log10();
    if value == DEFAULT {
        "default".to_owned()
    } else if value == f64::INFINITY {
        "∞".to_owned()
    } else if value > 0.0 && (exponent - exponent.round()).abs() < 1e-9 && !(0.1..=10.0).contains(&value) {
        power_of_ten(exponent)
    } else {
        tick(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Precision;
    use crate::stability::{Class, Effort};

    fn sliding(resistance: &str, density: &str, precision: Precision) -> Case {
        Case::of("sliding", &[resistance, density], precision).with("run", "{duration_s=0.1,settle_s=0}")
    }

    /// Two settings in both precisions, with rows of their own classes.
    fn judged() -> (Vec<Case>, Vec<Finding>) {
        let settings = [("load.resistance_ohm=1e6", "0e0"), ("load.resistance_ohm=inf", "2e-5")];
        let cases: Vec<Case> = settings
            .iter()
            .flat_map(|(resistance, density)| {
                let density = format!("parameters.charge_density_c_per_m2={density}");
                [Precision::F32, Precision::F64].map(|precision| sliding(resistance, &density, precision))
            })
            .collect();
        // Given up at once: the rows get their classes below.
        let effort = Effort { most_attempts: 1, by_reference: false, chaotic_pairs: 16 };
        let mut rows: Vec<Finding> =
            cases.iter().enumerate().flat_map(|case| Finding::judged(&[case], effort)).collect();
        let classes = [Class::Right, Class::Warned, Class::NamedError, Class::Wrong];
        for (row, class) in rows.iter_mut().zip(classes) {
            row.class = class;
            row.reason = "displacement = 0.02 is outside the model's domain at 1 s: <x>".to_owned();
        }
        (cases, rows)
    }

    #[test]
    fn the_page_has_counts_causes_maps_and_what_fails() {
        let (cases, rows) = judged();
        let page = page(&cases, &rows);
        for part in [
            "4 runs",
            "<td>right</td>",
            "<td>left the overlap of the patches</td>",
            "sliding: load resistance [Ω] against charge density [C/m²]",
            "load resistance [Ω] 10⁶, charge density [C/m²] 0: 1 right",
            "load resistance [Ω] ∞, charge density [C/m²] 2·10⁻⁵: 1 wrong",
            "model's domain at 1 s: &lt;x&gt;<br><code>run host-bench/scenes/sliding.toml --precision f64",
        ] {
            assert!(page.contains(part), "{part}: {page}");
        }
        // The other maps have no case.
        assert_eq!(page.matches("class=\"panels\"").count(), 1);
    }

    #[test]
    fn a_cell_is_in_the_panel_of_its_precision_at_its_values() {
        let (cases, rows) = judged();
        let tables = MAPS[2].tables(&cases, &rows).expect("has cases");
        let right = tables.find("1 right").expect("a cell");
        let warned = tables.find("1 warned").expect("a cell");
        assert!(right < warned, "f32 stands before f64: {tables}");
        assert_eq!(tables.matches("<td title=").count(), 4);
    }
}

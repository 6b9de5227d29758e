//! The report: one HTML page with its pictures in it.

mod bump_stop;
mod chart;
pub(crate) mod html;
pub(crate) mod plot;
pub(crate) mod svg;

use std::fmt::Write;

use self::html::{document, escaped};
use crate::work_precision::bump_stop::BumpStopComparison;
use crate::work_precision::{Comparison, TARGET_ERROR, table};

/// The page.
///
/// # Errors
/// If a picture cannot be drawn.
pub fn page(comparisons: &[Comparison], bump_stop: &[BumpStopComparison]) -> Result<String, String> {
    let mut body = String::new();
    body.push_str("<h1>Vibration energy harvesters: error against run time</h1>\n");
    body.push_str(
        "<p>The triboelectric harvesters on the embedded core, run on this host, against an independent \
         reference in double precision. Lower and further left is better. In contact-separation the motion \
         hits the dielectric in every period, and the power comes in a spike at each contact; in sliding, \
         friction turns round at every reversal and the overlap has a corner in the middle.</p>\n",
    );
    for comparison in comparisons {
        let resistance = table::resistance(comparison.resistance_ohm);
        let _ = writeln!(body, "<h2>{}, load: {resistance}</h2>", escaped(&comparison.file));
        let _ = writeln!(body, "<p>{}</p>", escaped(&summary(comparison)));
        body.push_str(&chart::draw(comparison)?);
        body.push('\n');
        body.push_str(&html_table(comparison));
        for note in comparison.notes() {
            let _ = writeln!(body, "<p class=\"note\">{}</p>", escaped(&note));
        }
    }
    bump_stop.iter().for_each(|comparison| body.push_str(&bump_stop::section(comparison)));
    Ok(document("Error against run time", &body))
}

/// What the picture shows, in the numbers of this run.
fn summary(comparison: &Comparison) -> String {
    let fastest = |embedded: bool, explicit: bool| {
        comparison
            .rows
            .iter()
            .filter_map(|row| {
                let found = row.found?;
                let own = row.variant.math.is_some();
                let rk4 = row.variant.method == crate::method::Method::Rk4;
                (own == embedded && rk4 == explicit && found.errors.mean_power_error? <= TARGET_ERROR).then(
                    || {
                        (
                            found.ns_per_s,
                            found.errors.mean_power_error,
                            row.cells()[..table::WORDS].join(", "),
                        )
                    },
                )
            })
            .min_by(|one, two| one.0.total_cmp(&two.0))
    };
    let told = |row: Option<(f64, Option<f64>, String)>| match row {
        Some((ns, error, name)) => {
            format!("{:.0} µs at an error of {:.1e} ({name})", ns / 1e3, error.unwrap_or(f64::NAN))
        }
        None => "no row reaches it".to_owned(),
    };
    let unstable = comparison.rows.iter().any(|row| {
        let error = row.found.and_then(|found| found.errors.mean_power_error);
        row.failure.is_some() || error.is_some_and(|error| error > 1.0)
    });
    format!(
        "The fastest rows with an error of mean power of at most {TARGET_ERROR:.0e}, in host time per simulated \
         second. TR-BDF2: {}. Explicit RK4: {}. The integrator of the reference at a loose tolerance: {}.{}",
        told(fastest(true, false)),
        told(fastest(true, true)),
        told(fastest(false, false)),
        if unstable { " Explicit steps too long to be stable are in the table and not drawn." } else { "" },
    )
}

fn html_table(comparison: &Comparison) -> String {
    let class = |index: usize| if index < table::WORDS { "" } else { " class=\"number\"" };
    let mut text = String::from("<div class=\"wide\"><table>\n<thead><tr>");
    for (index, heading) in table::HEADINGS.iter().enumerate() {
        let _ = write!(text, "<th{}>{}</th>", class(index), escaped(heading));
    }
    text.push_str("</tr></thead>\n<tbody>\n");
    for row in &comparison.rows {
        let reached = row.found.and_then(|found| found.errors.mean_power_error);
        let beyond = !reached.is_some_and(|error| error <= TARGET_ERROR) && row.variant.math.is_some();
        text.push_str(if beyond { "<tr class=\"beyond\">" } else { "<tr>" });
        for (index, cell) in row.cells().iter().enumerate() {
            let _ = write!(text, "<td{}>{}</td>", class(index), escaped(cell));
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody>\n</table></div>\n");
    let _ = writeln!(
        text,
        "<p class=\"note\">Grey: mean power not within {TARGET_ERROR:.0e} of the reference.</p>"
    );
    text
}

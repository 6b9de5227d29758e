//! The report on error against run time: one HTML page with its pictures in it.

mod chart;
pub(crate) mod charts;
pub(crate) mod colour_bar;
pub(crate) mod field;
pub(crate) mod html;
pub(crate) mod label;
pub(crate) mod plot;
pub(crate) mod setting;
pub(crate) mod svg;

use std::fmt::Write;

use self::charts::{Charts, HINT, Look};
use self::html::{document, escaped};
use crate::method::Method;
use crate::scene_file::Model;
use crate::work_precision::Comparison;
use crate::work_precision::table::resistance;

/// How error against run time stands in its page.
const CHART: Look<'_> = Look { height: 520, group: None };

pub(crate) fn page(comparisons: &[Comparison]) -> Result<String, String> {
    let mut body = String::new();
    let mut charts = Charts::default();
    body.push_str("<h1>Vibration energy harvesters: error against run time</h1>\n");
    body.push_str(
        "<p>The triboelectric harvesters on the embedded core, run on this host, against an independent \
         reference in double precision. Lower and further left is better. In contact-separation the motion \
         hits the dielectric in every period, and the power comes in a spike at each contact; in sliding, \
         friction turns round at every reversal and the overlap has a corner in the middle.</p>\n",
    );
    body.push_str(HINT);
    for comparison in comparisons {
        let quantity = match comparison.scene.model {
            Model::ContactSeparation(_) | Model::Sliding(_) => {
                let load = resistance(comparison.scene.load.resistance_ohm());
                let _ = writeln!(body, "<h2>{}, load: {load}</h2>", escaped(&comparison.file()));
                let _ = writeln!(body, "<p>{}</p>", escaped(&summary(comparison)));
                body += &charts.place(&chart::plot(comparison), CHART);
                // Without scripts the picture stands there.
                let _ = writeln!(body, "<noscript><figure>{}</figure></noscript>", chart::draw(comparison)?);
                "mean power"
            }
            Model::BumpStop(_) => {
                body.push_str("<h2>Bump-stop harvester</h2>\n");
                let _ = writeln!(
                    body,
                    "<p>A piezoelectric cantilever that hits a rod, by the core's method (exact modal steps, the \
                     contact a discrete gradient) beside general methods on the host. {}</p>",
                    escaped(&comparison.title())
                );
                "RMS voltage"
            }
        };
        body.push_str(&html_table(comparison));
        let grey = format!("Grey: {quantity} not within {:.0e} of the reference.", comparison.target_error());
        for note in std::iter::once(grey).chain(comparison.notes()) {
            let _ = writeln!(body, "<p class=\"note\">{}</p>", escaped(&note));
        }
    }
    body += &charts.scripts();
    Ok(document("Error against run time", &body))
}

/// What the picture shows, in the numbers of this run.
fn summary(comparison: &Comparison) -> String {
    let fastest = |method: Method| match comparison.fastest(|variant| variant.method == method) {
        Some((row, found)) => format!(
            "{:.0} µs at an error of {:.1e} ({})",
            found.ns_per_s / 1e3,
            comparison.error(row).unwrap_or(f64::NAN),
            comparison.cells(row)[..comparison.kind.words].join(", ")
        ),
        None => "no row reaches it".to_owned(),
    };
    let unstable = comparison
        .rows
        .iter()
        .any(|row| row.failure.is_some() || comparison.error(row).is_some_and(|error| error > 1.0));
    format!(
        "The fastest rows with an error of mean power of at most {:.0e}, in host time per simulated \
         second. Exponential Radau: {}. TR-BDF2: {}. Explicit RK4: {}. The integrator of the reference at a loose tolerance: {}.{}",
        comparison.target_error(),
        fastest(Method::ExponentialRadau),
        fastest(Method::TrBdf2),
        fastest(Method::Rk4),
        fastest(Method::Reference),
        if unstable { " Explicit steps too long to be stable are in the table and not drawn." } else { "" },
    )
}

fn html_table(comparison: &Comparison) -> String {
    let class = |index: usize| if index < comparison.kind.words { "" } else { " class=\"number\"" };
    let mut text = String::from("<div class=\"wide\"><table>\n<thead><tr>");
    for (index, heading) in comparison.kind.headings().iter().enumerate() {
        let _ = write!(text, "<th{}>{}</th>", class(index), escaped(heading));
    }
    text.push_str("</tr></thead>\n<tbody>\n");
    for row in &comparison.rows {
        let beyond = !comparison.reaches_target(row) && row.variant.method != Method::Reference;
        text.push_str(if beyond { "<tr class=\"beyond\">" } else { "<tr>" });
        for (index, cell) in comparison.cells(row).iter().enumerate() {
            let _ = write!(text, "<td{}>{}</td>", class(index), escaped(cell));
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody>\n</table></div>\n");
    text
}

//! `budget`: a day of a sensor node.

use std::path::PathBuf;

use super::files::{Outputs, make_folder, report_folder};
use super::{FileArguments, Watch, check_overrides, count, is_called, print};
use crate::accuracy::{Statements, print_warnings, run_as_it_is};
use crate::budget::outcome::Source;
use crate::budget::{income, picture, simulate};
use crate::method::{Failure, Precision};
use crate::outcome::Format;
use crate::report::Picture;
use crate::scene_file::{self, Load, finite_number_in};

/// The picture, and the page with it.
const REPORT: [&str; 2] = ["budget.svg", "budget.html"];

#[derive(Debug, Clone, clap::Args)]
#[command(
    mut_arg("scene", |arg| arg.help("Scene file with a table [node]")),
    mut_arg("overrides", |arg| arg.help("Another value for a key of the scene, such as node.update_s=30; may be repeated"))
)]
pub struct BudgetArguments {
    #[command(flatten)]
    scene: FileArguments,
    /// Take every step of the harvester's day, in place of its mean power at each amplitude
    #[arg(long)]
    exact: bool,
    /// Days before the one that is shown, in which the node learns when income comes
    #[arg(long, value_name = "COUNT", default_value_t = 2, value_parser = count::<u32>(0..=366))]
    learning_days: u32,
    /// Precision of the harvester and the budget
    #[arg(long, value_enum, default_value = "f32")]
    precision: Precision,
    /// Relative tolerance of the adaptive step [default: 0.05]
    #[arg(long, value_name = "REL", allow_hyphen_values = true, value_parser = finite_number_in("", "REL"))]
    tolerance: Option<f64>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write the picture to this file (.svg), or a page with zoom (.html) [default: report/budget.svg and budget.html]
    #[arg(long, value_name = "FILE.svg|.html", visible_alias = "picture")]
    svg: Option<PathBuf>,
}

/// Simulates the day, draws it and prints its numbers.
pub(super) fn run(arguments: &BudgetArguments) -> Result<(), Failure> {
    let learning_days = arguments.learning_days;
    let (scene, node) = scene_file::read_with_node(&arguments.scene.scene, &arguments.scene.overrides)?;
    check_overrides(&arguments.scene.overrides, &[])?;
    let options = income::options(&scene, arguments.precision, arguments.tolerance);
    options.check()?;
    let outputs = Outputs::of(&arguments.scene.scene, &arguments.scene.overrides)?;
    outputs.check_picture("--svg", &arguments.svg)?;
    if arguments.svg.is_none() && !is_called() {
        outputs.check_in("", &report_folder(), &REPORT)?;
    }
    let bridged = matches!(scene.load, Load::RectifiedStore(_));
    if arguments.exact && !bridged {
        check_overrides(&arguments.scene.overrides, &[("run", "--exact runs the whole day")])?;
    }
    let is_looped = arguments.exact && bridged;
    if is_looped {
        income::check_looped(&scene, &node)?;
    }
    let watch = arguments.exact.then(Watch::new);
    let mut statements = Statements::default();
    let (income, whole_day) = if arguments.exact && !bridged {
        // A day has no other to compare with: the statement is that of a run of the scene.
        statements.add(&run_as_it_is(&scene, &options)?);
        let (income, day) = income::exact(&scene, &node, &options)?;
        (income, Some(day))
    } else {
        (income::by_level(&scene, &node, &options, &mut statements)?, None)
    };
    let stated = statements.fields(&[]);
    print_warnings(&stated);
    let in_loop = is_looped.then_some((&scene, &options));
    let day = simulate(&node, &income, learning_days, arguments.precision, in_loop)?;
    drop(watch);
    let source = Source {
        scene: scene.name(),
        precision: arguments.precision.name(),
        income: if arguments.exact { "exact" } else { "by-level" },
        learning_days,
        whole_day,
        stated,
    };
    print(&day.text(&source, arguments.format))?;
    keep(arguments, &picture::picture(&day, &source), &outputs)
}

fn keep(arguments: &BudgetArguments, picture: &Picture, outputs: &Outputs) -> Result<(), Failure> {
    match &arguments.svg {
        Some(file) => outputs.keep(file, picture.of_file(file)?),
        None if is_called() => {}
        None => {
            let folder = report_folder();
            make_folder(&folder)?;
            for file in REPORT.map(|name| folder.join(name)) {
                outputs.keep(&file, picture.of_file(&file)?);
            }
        }
    }
    outputs.ended()
}

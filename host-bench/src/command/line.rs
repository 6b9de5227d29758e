//! The command line: all commands, each with its help and an example.

use clap::CommandFactory;

use super::{
    attractors, be_quiet, budget, design, export, findings, fit, keys, map, needs, node_strategies,
    on_target, optimise, plot, print, resonance, run, set_width_mm, stability, stop, sweep, tolerance,
    width_mm, work_precision,
};
use crate::method::Failure;

/// Vibration energy harvesters: scenes, reference, reports
#[derive(Debug, clap::Parser)]
#[command(
    version,
    max_term_width = 100,
    after_help = "Examples:\n  \
    host-bench run scene.toml --set load.resistance_ohm=10M --set excitation.amplitude_m_per_s2=0.2g\n  \
    host-bench new contact-separation | host-bench run -\n\nA file is - for standard input or output. Values of --set \
    and --over take a prefix and a unit: 10M, 33kΩ, 20us, 0.2g. A COMMAND --help has examples of the command."
)]
pub struct Arguments {
    /// Without one: error against run time in short, and a report in report/
    #[command(subcommand)]
    command: Option<Command>,
    /// Print errors and warnings only: no progress, no names of the files written
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Printed width of pictures in .svg (.pdf, .png): text of 7 pt, panels below each other where narrow, such as 85mm
    #[arg(long, global = true, value_name = "LENGTH", value_parser = width_mm)]
    width: Option<f64>,
}

/// All commands, with their arguments.
#[derive(Debug, clap::Subcommand)]
pub enum Command {
    /// The steady motions to which the starts of a scene lead, with their powers
    Attractors(attractors::AttractorsArguments),
    /// Simulate a day of a sensor node: stored energy, income and actions
    #[command(after_help = "Run time: below a second; with --exact 5 s of one core for node.toml")]
    Budget(budget::BudgetArguments),
    /// A script by which a shell completes commands and options
    Completions {
        /// Which shell
        shell: clap_complete::Shell,
    },
    /// Mean power of a beam without a trajectory, and whether that holds
    ClosedForm(run::ClosedFormArguments),
    /// A scene as a netlist of SPICE, all but a cantilever with a stop, or as an FMU
    #[command(after_help = "Run time: below a second")]
    Export(export::ExportArguments),
    /// Rebuild the figures of the two papers: sliding 3 to 6, contact-separation 8 to 11, bump-stop 6 to 11
    Figures(findings::FiguresArguments),
    /// What the two papers find, measured on the shipped scenes
    Findings(findings::FindingsArguments),
    /// Fit parameters of a scene to measurements
    #[command(
        after_help = "Run time: below a second for a sweep of 28 values; it grows with rows times free keys: minutes for long traces, and for a beam that hits a stop"
    )]
    Fit(fit::FitArguments),
    /// Every key of scene files: unit, bounds, default, meaning
    Keys(keys::KeysArguments),
    /// The income over amplitude and frequency, for a node to look up
    Map(map::MapArguments),
    /// Which parts of a scene its mean power needs, and what runs the scene without the others
    #[command(
        after_help = "Run time: a second for triboelectric scenes, a quarter of a minute for bump-stop.toml; with --core a build of the firmware besides"
    )]
    Needs(needs::NeedsArguments),
    /// A commented template of a scene file
    New(keys::NewArguments),
    /// Ways by which a node knows its income and decides on its actions: errors, costs, actions beside the most possible
    NodeStrategies(node_strategies::NodeStrategiesArguments),
    /// Years of a node of either tier: nights, seasons, ageing, clock steps, updates, losses of power
    NodeYears(node_strategies::NodeYearsArguments),
    /// The motion of one run or of several as a picture
    #[command(
        after_help = "Run time: that of the runs: below a second each for triboelectric scenes, some seconds for a beam that hits a stop"
    )]
    Plot(plot::PlotArguments),
    /// One page on a design: motion, resonance, load curve, margins, stress, tolerance, and the day of its node
    #[command(
        after_help = "Run time: that of the run, 82 points of a sweep and 100 samples of a tolerance, on all cores"
    )]
    Report(design::ReportArguments),
    /// The frequency at which the steady state of a scene responds most
    #[command(
        after_help = "Run time: below a second for triboelectric scenes, 10 s of one core for bump-stop.toml"
    )]
    Resonance(resonance::ResonanceArguments),
    /// Run one scene
    #[command(
        after_help = "Run time: below a second for triboelectric scenes, some seconds for a beam that hits a stop; more with a tighter --accuracy and a longer [run], and times --seeds"
    )]
    Run(run::RunArguments),
    /// Build the firmware for each core, run it under QEMU
    #[command(
        after_help = "Run time: two minutes on two cores for all cores, most of it a build of the firmware for each; half a minute for another report or one core; the first time a minute more"
    )]
    OnTarget(on_target::OnTargetArguments),
    /// The values of one to four keys at which a number of the result is largest or smallest
    #[command(alias = "optimize", after_help = optimise::run_time())]
    Optimise(optimise::OptimiseArguments),
    /// Stiff and extreme scenes: each right, refused, or a named error
    Stability(stability::StabilityArguments),
    /// What the stop of a bump-stop scene saves in stress at the clamp, and what it costs in power
    #[command(after_help = "Run time: that of its points, each a run or two, on all cores")]
    Stop(stop::StopArguments),
    /// Run a scene over a grid of values
    #[command(
        after_help = "Run time: that of its points on all cores; the accuracy statement of a point takes further runs, --no-accuracy leaves it out"
    )]
    Sweep(sweep::SweepArguments),
    /// How a number of the result spreads where keys vary from part to part: percentiles, yield, and which key matters
    #[command(
        after_help = "Run time: that of its samples on all cores, each with its accuracy statement as a point of sweep; --no-accuracy and --single-start leave runs out"
    )]
    Tolerance(tolerance::ToleranceArguments),
    /// Published measurements beside the models
    Validation(findings::ValidationArguments),
    /// Error against run time: methods, steps, tolerances, precisions, math backends
    WorkPrecision(work_precision::WorkPrecisionArguments),
    #[cfg(feature = "peers")]
    #[command(hide = true)]
    WorkPrecisionRow(work_precision::RowArguments),
}

/// An example of each command for its help.
const EXAMPLES: [&str; 26] = [
    "attractors scene.toml --starts 50 --picture basins.svg",
    "budget node.toml --set node.storage.capacitance_f=300m",
    "closed-form beam.toml --set load.resistance_ohm=33k",
    "completions bash",
    "export beam.toml --spice harvester.cir --deck harvester_test.cir",
    "figures --only sliding",
    "findings --only 8,9",
    "fit measured.toml --data sweep.csv --free parameters.damping_ratio --output fitted.toml",
    "keys contact-separation",
    "map scene.toml --amplitude 0.5:4 --frequency 15:25 --output map.rs",
    "needs scene.toml --accuracy 1e-2 --emit cut.rs",
    "new sliding --output scene.toml",
    "node-strategies",
    "node-years --years 1",
    "on-target --core m4f",
    "optimise beam.toml --maximise mean_power_w --over load.resistance_ohm=1k:1M:log \\\n    \
     --over excitation.frequency_hz=45:60 --steady-state",
    "plot scene.toml --compare load.resistance_ohm=1M,100M --output motion.html",
    "report scene.toml --vary parameters.mass_kg=±2% --output design.html",
    "resonance scene.toml --from 15 --to 25",
    "run scene.toml --set excitation.amplitude_m_per_s2=0.2g --format json",
    "stability --grid coarse",
    "stop beam.toml --over stop.gap_m=0.1m:0.5m:9",
    "sweep scene.toml --over load.resistance_ohm=100k:1G:41:log --output target/sweep",
    "tolerance scene.toml --vary parameters.mass_kg=±2% --vary load.resistance_ohm=+-5%:normal \\\n    --at-least 1e-5",
    "validation --picture validation.svg",
    "work-precision scene.toml --format csv",
];

/// The command line, with an example in the help of each command.
pub fn command() -> clap::Command {
    EXAMPLES.iter().fold(Arguments::command(), |command, example| {
        let name = example.split(' ').next().unwrap_or_default();
        command.mut_subcommand(name, |one| {
            let before = one.get_after_help().map_or_else(String::new, |text| format!("{text}\n\n"));
            one.after_help(format!("{before}Example:\n  host-bench {example}"))
        })
    })
}

impl Arguments {
    /// Runs the command, or shows the library where there is none.
    ///
    /// # Errors
    /// Bad input, or a result that could not be had.
    pub fn run(&self) -> Result<(), Failure> {
        if self.quiet {
            be_quiet();
        }
        self.width.into_iter().for_each(set_width_mm);
        self.command.as_ref().map_or_else(work_precision::run_default, Command::run)
    }
}

impl Command {
    /// Runs the command: it prints its result.
    ///
    /// # Errors
    /// Bad input, or a result that could not be had.
    pub fn run(&self) -> Result<(), Failure> {
        match self {
            Self::Attractors(arguments) => attractors::run(arguments),
            Self::Budget(arguments) => budget::run(arguments),
            Self::Completions { shell } => completions(*shell),
            Self::ClosedForm(arguments) => run::run_closed_form(arguments),
            Self::Export(arguments) => export::run(arguments),
            Self::Figures(arguments) => findings::run_figures(arguments),
            Self::Findings(arguments) => findings::run(arguments),
            Self::Fit(arguments) => fit::run(arguments),
            Self::Keys(arguments) => keys::run(arguments),
            Self::Map(arguments) => map::run(arguments),
            Self::Needs(arguments) => needs::run(arguments),
            Self::New(arguments) => keys::new(arguments),
            Self::Plot(arguments) => plot::run(arguments),
            Self::Report(arguments) => design::run(arguments),
            Self::Resonance(arguments) => resonance::run(arguments),
            Self::Run(arguments) => run::run(arguments),
            Self::NodeStrategies(arguments) => node_strategies::run(arguments),
            Self::NodeYears(arguments) => node_strategies::run_years(arguments),
            Self::OnTarget(arguments) => {
                on_target::run(arguments).map_err(|error| Failure::Input(error.to_string()))
            }
            Self::Optimise(arguments) => optimise::run(arguments),
            Self::Stability(arguments) => stability::run(arguments),
            Self::Stop(arguments) => stop::run(arguments),
            Self::Sweep(arguments) => sweep::run(arguments),
            Self::Tolerance(arguments) => tolerance::run(arguments),
            Self::Validation(arguments) => findings::run_validation(arguments),
            Self::WorkPrecision(arguments) => work_precision::run(arguments),
            #[cfg(feature = "peers")]
            Self::WorkPrecisionRow(arguments) => work_precision::run_row(arguments),
        }
    }
}

fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), env!("CARGO_PKG_NAME"), &mut script);
    // The script of bash has the hyphen of the name in two ways, so that no command after it would be known.
    let script = String::from_utf8_lossy(&script).replace("host__subcmd__bench", "host__bench");
    print(&script)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_command_has_an_example_that_it_takes() {
        let names: Vec<String> =
            Arguments::command().get_subcommands().map(|one| one.get_name().to_owned()).collect();
        for name in names.iter().filter(|name| *name != "work-precision-row") {
            let example = EXAMPLES.iter().find(|example| example.split(' ').next() == Some(name));
            let words = example.unwrap_or_else(|| panic!("{name} has no example")).split_whitespace();
            let words = words.filter(|word| *word != "\\");
            let parsed = command().try_get_matches_from(std::iter::once("host-bench").chain(words));
            assert!(parsed.is_ok(), "{name}: {:?}", parsed.err().map(|error| error.to_string()));
        }
    }
}

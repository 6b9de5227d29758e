//! `needs`: which parts of a scene its mean power needs.

use std::path::{Path, PathBuf};
use std::time::Duration;

use comfy_table::presets;
use serde::Serialize;
use serde_json::{Value, json};

use super::files::Outputs;
use super::map::Range;
use super::on_target::rows::percent;
use super::{
    FileArguments, NODE, check_overrides, json_text, next_stage, one_more, print, progress, set_option, warn,
};
use crate::method::{Failure, Options, Precision};
use crate::name::Name;
use crate::needs::{
    Change, Control, Corner, Emission, Finding, Needs, Numerics, Part, Setting, Study, Verdict, cheapest,
    corner_name, cycles, impacts,
};
use crate::on_target::qemu::Core;
use crate::on_target::{self, Bench, Measurement, build};
use crate::outcome::{Fields, Format, SwitchCycles, fields, folded, name, rows_csv, small, table};
use crate::rows::{Digits, Rows};
use crate::run::run_scene;
use crate::scene_file::{self, Excitation, Override, Scene, finite_number_in};

#[derive(Debug, Clone, clap::Args)]
pub struct NeedsArguments {
    #[command(flatten)]
    scene: FileArguments,
    /// Relative change of mean power, RMS voltage and storage voltage that is accepted
    #[arg(long, value_name = "REL", default_value_t = 1e-2, allow_hyphen_values = true, value_parser = finite_number_in("", "REL"))]
    accuracy: f64,
    /// Lowest and highest amplitude in m/s² of one sine, at which the accuracy must hold too
    #[arg(long, value_name = "LO:HI", value_parser = Range::of("m/s²"))]
    amplitude: Option<Range>,
    /// Lowest and highest frequency in Hz of one sine, at which the accuracy must hold too
    #[arg(long, value_name = "LO:HI", value_parser = Range::of("Hz"))]
    frequency: Option<Range>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write the cut scene as a Rust module for firmware to this file
    #[arg(long, value_name = "FILE.rs")]
    emit: Option<PathBuf>,
    /// Build and run the cut scene on this core under QEMU, beside the full one: flash, stack and instructions
    #[arg(long, value_enum)]
    core: Option<Core>,
}

/// Bounds of the accuracy.
const ACCURACY: [f64; 2] = [1e-4, 0.5];

/// Leaves out each part of the scene, and prints what that changes, the cut scene, and what runs it.
pub(super) fn run(arguments: &NeedsArguments) -> Result<(), Failure> {
    let accuracy = arguments.accuracy;
    let [lowest, highest] = ACCURACY;
    if !(lowest..=highest).contains(&accuracy) {
        let text = format!("--accuracy {accuracy}: must be a number from {lowest:e} to {highest}");
        return Err(Failure::Input(text));
    }
    let scene = scene_file::read(&arguments.scene.scene, &arguments.scene.overrides)?;
    check_overrides(&arguments.scene.overrides, &[NODE])?;
    let outputs = Outputs::of(&arguments.scene.scene, &arguments.scene.overrides)?;
    if let Some(file) = &arguments.emit {
        outputs.check("--emit", file)?;
    }
    if arguments.core.is_some() {
        if scene.excitation.is_recorded() {
            return Err(Failure::Input("--core: must not be with a recorded acceleration".to_owned()));
        }
        build::workspace().map_err(|reason| Failure::Input(format!("--core: {reason}")))?;
    }
    let study = Study::with_corners(&scene, &corners(arguments, &scene)?, accuracy)?;
    study.full.warnings.iter().for_each(|warning| warn(warning));
    let bar = progress("parts", 1);
    let counted = |count: usize| {
        bar.set_length(count as u64);
        one_more(&bar);
    };
    let needs = study.needs(counted)?;
    next_stage(&bar, "steps and precisions", 1);
    let numerics = cheapest(&study, (&needs.cut_scene, needs.cut_change.sampling_error.is_some()), counted);
    bar.finish_and_clear();
    let emission = Emitting { study: &study, needs: &needs, numerics: &numerics };
    if let Some(file) = &arguments.emit {
        outputs.keep(file, emission.module(&needs.cut_scene, &needs.cut, &command(arguments, file))?);
    }
    let on_core = arguments.core.map(|core| emission.on_core(core)).transpose()?;
    let text = match arguments.format {
        Format::Table => {
            let costs = on_core.as_deref().map_or_else(String::new, costs_table);
            let all = report(&study, accuracy, &needs, &numerics) + &costs;
            all.lines().map(|line| folded(line, 0) + "\n").collect()
        }
        Format::Json => {
            let mut object = object(&study, accuracy, &needs, &numerics);
            object["on_core"] = json!(on_core);
            json_text(&object)?
        }
        Format::Csv => csv_text(&needs.findings, &numerics, on_core.as_deref().unwrap_or_default()),
    };
    print(&text)?;
    outputs.ended()
}

/// The scene at the corners of the range of amplitude and frequency; without a range there is none.
fn corners(arguments: &NeedsArguments, scene: &Scene) -> Result<Vec<(Corner, Scene)>, Failure> {
    let NeedsArguments { amplitude, frequency, .. } = *arguments;
    if amplitude.is_none() && frequency.is_none() {
        return Ok(Vec::new());
    }
    let Some(own) = sine(scene) else {
        let text = "--amplitude, --frequency: must be with an excitation of one sine";
        return Err(Failure::Input(text.to_owned()));
    };
    let ends = |range: Option<Range>, own: f64| range.map_or(vec![own], |Range(ends)| ends.to_vec());
    let mut corners = Vec::new();
    for frequency in ends(frequency, own[1]) {
        // Times in periods are those of the frequency.
        let change = Override::new("excitation.frequency_hz", &frequency.to_string());
        let there =
            scene_file::read(&arguments.scene.scene, &[&arguments.scene.overrides[..], &[change]].concat())?;
        for amplitude in ends(amplitude, own[0]) {
            let mut there = there.clone();
            if let Excitation::Sine(tone) = &mut there.excitation {
                tone.amplitude_m_per_s2 = amplitude;
            }
            corners.push(([amplitude, frequency], there));
        }
    }
    Ok(corners)
}

/// Amplitude in m/s² and frequency in Hz of one sine.
fn sine(scene: &Scene) -> Option<Corner> {
    match &scene.excitation {
        Excitation::Sine(tone) if tone.frequency_hz > 0.0 => {
            Some([tone.amplitude_m_per_s2, tone.frequency_hz])
        }
        _ => None,
    }
}

fn command(arguments: &NeedsArguments, file: &Path) -> String {
    let sets: String = arguments.scene.overrides.iter().map(set_option).collect();
    let NeedsArguments { accuracy, amplitude, frequency, .. } = arguments;
    let range = |name: &str, range: Option<Range>| {
        range.map_or_else(String::new, |Range([low, high])| format!(" --{name} {low}:{high}"))
    };
    let ranges = range("amplitude", *amplitude) + &range("frequency", *frequency);
    format!(
        "host-bench needs {}{}{ranges} --accuracy {accuracy:e} --emit {}",
        Name::new(arguments.scene.scene.to_string_lossy()).shell(),
        sets,
        Name::of_file(file).shell()
    )
}

/// The cut scene and the full one, for firmware.
struct Emitting<'a> {
    study: &'a Study,
    needs: &'a Needs,
    numerics: &'a [Numerics],
}

/// The cost of a scene on a core.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Cost {
    scene: &'static str,
    core: String,
    flash_bytes: u64,
    stack_bytes: u64,
    instructions_per_s: f64,
    mean_power_w: f64,
}

impl Emitting<'_> {
    fn setting(&self) -> Result<Setting, Failure> {
        least_single(self.numerics)
            .map(|found| found.setting)
            .ok_or_else(|| Failure::Step("no method of the core holds the accuracy in f32".to_owned()))
    }

    fn module(&self, scene: &Scene, cut: &[Part], command: &str) -> Result<String, Failure> {
        let setting = self.setting()?;
        // Means over whole cycles of a switch are no means of the module's window.
        let mean_power_w = match cycles(&self.study.full) {
            Some(_) => run_scene(scene, &setting.options())?.mean_power_w,
            None => self.study.full.mean_power_w,
        };
        let mean_power_w = mean_power_w.unwrap_or(0.0);
        let accuracy = self.study.accuracy_of_a_run();
        Emission { scene, cut, setting, command, accuracy, mean_power_w }.module()
    }

    /// Measures the full and the cut scene on a core, by the same setting.
    fn on_core(&self, core: Core) -> Result<Vec<Cost>, Failure> {
        let failure = |error: on_target::Error| Failure::Input(error.to_string());
        let bench = Bench::new(core, TIME_LIMIT).map_err(failure)?;
        let full = ("full", &self.study.scene, &[][..]);
        let cut = ("cut", &self.needs.cut_scene, self.needs.cut.as_slice());
        let mut costs = Vec::new();
        for (name, scene, left_out) in [full, cut] {
            let file = std::env::temp_dir().join(format!("needs-{}-{name}.rs", std::process::id()));
            let text = self.module(scene, left_out, "host-bench needs --core")?;
            std::fs::write(&file, text)
                .map_err(|error| Failure::Input(format!("{}: cannot be written: {error}", file.display())))?;
            let measured = bench.measure_emitted(&file).map_err(failure);
            // Nothing is lost if it stays.
            let _ = std::fs::remove_file(&file);
            costs.push(self.cost(name, core, scene, &measured?)?);
        }
        Ok(costs)
    }

    fn cost(&self, name: &'static str, core: Core, scene: &Scene, of: &Measurement) -> Result<Cost, Failure> {
        let workload = of.workloads.first();
        let (Some(workload), Some(bits)) =
            (workload, workload.and_then(|workload| workload.samples.last()?.bits.first().copied()))
        else {
            return Err(Failure::Step(format!("{core}: the firmware logged nothing")));
        };
        let energy = f32::from_bits(bits);
        let host = run_scene(scene, &Options { bare: true, ..self.setting()?.options() })?;
        if host.delivered_energy_j.map(|energy| (energy as f32).to_bits()) != Some(bits) {
            let other = host.delivered_energy_j.unwrap_or(f64::NAN);
            return Err(Failure::Step(format!("{core}: {energy:e} J, on the host {other:e} J")));
        }
        Ok(Cost {
            scene: name,
            core: core.to_string(),
            flash_bytes: of.flash,
            stack_bytes: workload.stack,
            instructions_per_s: workload.whole().instructions_per_second(),
            mean_power_w: f64::from(energy) / scene.run.window_s(),
        })
    }
}

/// Longest run under QEMU.
const TIME_LIMIT: Duration = Duration::from_secs(600);

fn costs_table(costs: &[Cost]) -> String {
    let columns = [
        ("scene", "scene", Digits::Word),
        ("flash", "flash_bytes", Digits::Six),
        ("stack", "stack_bytes", Digits::Six),
        ("instructions per s", "instructions_per_s", Digits::Fixed(1.0, 0)),
        ("mean power", "mean_power_w", Digits::By(|power_w| format!("{power_w:.4e} W"))),
    ];
    let core = costs.first().map_or("", |cost| cost.core.as_str());
    format!(
        "\nOn the {core}, in bytes and instructions per simulated second, both by that setting; the energy has the host's bits\n\n{}",
        Rows::of(costs).table(presets::NOTHING, &columns, 1)
    )
}

fn object(study: &Study, accuracy: f64, needs: &Needs, numerics: &[Numerics]) -> Value {
    json!({
        "accuracy": accuracy,
        "is_chaotic": study.is_chaotic,
        "is_sound": study.is_sound(),
        "runs": study.runs(),
        "full": study.full,
        "switch_cycles": cycles(&study.full),
        "corners": study.corners.iter().map(|(at, corner)| json!({"at": at, "full": corner.full})).collect::<Vec<_>>(),
        "parts": needs.findings,
        "left_out": needs.cut.iter().map(|part| part.name()).collect::<Vec<_>>(),
        "without_all": needs.cut_change,
        "numerics": numerics,
    })
}

/// One table of CSV. The column `table` has the list of the JSON object that a row is of; cells that this lacks are empty.
fn csv_text(parts: &[Finding], numerics: &[Numerics], on_core: &[Cost]) -> String {
    let mut rows: Vec<Fields> = Vec::new();
    let mut add = |table: &str, row: Fields| {
        rows.push([("table".to_owned(), table.into())].into_iter().chain(row).collect());
    };
    parts.iter().for_each(|part| add("parts", fields(part)));
    numerics.iter().for_each(|setting| add("numerics", fields(setting)));
    on_core.iter().for_each(|cost| add("on_core", fields(cost)));
    let mut columns: Vec<String> = Vec::new();
    for column in rows.iter().flat_map(Fields::keys) {
        if !columns.contains(column) {
            columns.push(column.clone());
        }
    }
    rows_csv(&columns, &rows)
}

fn report(study: &Study, accuracy: f64, needs: &Needs, numerics: &[Numerics]) -> String {
    let full = &study.full;
    let shown = |value: Option<f64>, unit: &str| {
        value.map_or_else(|| format!("no {unit}"), |value| format!("{value:.6e} {unit}"))
    };
    let mut text = format!(
        "Full scene: mean power {}, RMS voltage {}{}; estimated error {}.\n",
        shown(full.mean_power_w, "W"),
        shown(full.rms_voltage_v, "V"),
        impacts(full).map_or_else(String::new, |count| format!(", {count} impacts")),
        small(full.accuracy.total),
    );
    if let Some(SwitchCycles { count, from_s, until_s, .. }) = cycles(full) {
        text += &format!(
            "Means are over {count} whole cycles of the switch of the draw, {from_s:.3} to {until_s:.3} s; \"storage\" is its mean voltage.\n"
        );
    }
    text += &points(study);
    if !study.is_sound() {
        text += "Its error is not known to be below half the accuracy: the verdicts are not certain.\n";
    }
    if study.is_chaotic {
        text += "The motion is chaotic: a base acceleration larger by 1e-9 changes the mean power. Means over runs are compared, \
             with half their 95 % interval.\n";
        text.push_str(&format!("Runs of the full scene: {}.\n", study.runs()));
    }
    text.push_str(&format!("\nChange without a part; accepted: {}\n\n", percent(Some(accuracy))));
    let by_motion = study.is_by_motion();
    if by_motion {
        text.push_str("The scene has no power and no voltage: the largest motion decides.\n\n");
    }
    text.push_str(&parts_table(&needs.findings, by_motion));
    text.push_str(&left_out(needs, by_motion));
    text.push_str("\nWhat runs the cut scene within the accuracy of the full one, the least work first\n\n");
    text.push_str(&numerics_table(numerics, by_motion));
    text.push_str(&chosen(numerics));
    text
}

/// At which points the accuracy must hold.
fn points(study: &Study) -> String {
    let corner = |(at, corner): &(Corner, Study)| {
        format!("At {}: mean power {:.6e} W.\n", corner_name(*at), corner.full.mean_power_w.unwrap_or(0.0))
    };
    match sine(&study.scene) {
        Some(own) if study.corners.is_empty() => format!(
            "The verdicts are for {} alone; --amplitude and --frequency give a range.\n",
            corner_name(own)
        ),
        _ => study.corners.iter().map(corner).collect(),
    }
}

/// Heading of the changes of the largest displacement or gap.
const MOTION: &str = "largest motion";

fn cells(change: &Change, by_motion: bool) -> Vec<String> {
    let power = match change.sampling_error {
        Some(error) => format!("{} ± {}", percent(change.mean_power), percent(Some(error))),
        None => percent(change.mean_power),
    };
    let impacts = change.impacts.map_or_else(|| "-".to_owned(), |count| count.to_string());
    let motion = by_motion.then(|| percent(change.displacement));
    let electrical = [power, percent(change.rms_voltage), percent(change.store_voltage)];
    motion.into_iter().chain(electrical).chain([impacts]).collect()
}

fn parts_table(findings: &[Finding], by_motion: bool) -> String {
    let electrical = ["mean power", "RMS voltage", "storage", "impacts"];
    let columns: Vec<&str> = by_motion.then_some(MOTION).into_iter().chain(electrical).collect();
    let rows = findings.iter().map(|finding| {
        let values = finding
            .change
            .as_ref()
            .map_or_else(|| vec!["-".to_owned(); columns.len()], |change| cells(change, by_motion));
        let verdict = match (&finding.verdict, &finding.failure) {
            // The state at the failure follows; JSON has it.
            (_, Some(failure)) => format!("needed: {}", failure.split(": ").next().unwrap_or_default()),
            (Verdict::NotNeeded, None) if finding.part == Part::StickCharge => "either will do".to_owned(),
            (Verdict::Needed, None) => "needed".to_owned(),
            (Verdict::NotNeeded, None) => "not needed".to_owned(),
            (Verdict::ByChance, None) => "needed: with more modes it changes by more".to_owned(),
            (Verdict::Undecided, None) => {
                let runs = finding.change.map_or(0, |change| change.runs);
                format!("undecided: within the scatter of {runs} runs")
            }
            (Verdict::NotNeededAlone { with }, None) if with.is_empty() => {
                "not needed alone, needed without the others".to_owned()
            }
            (Verdict::NotNeededAlone { with }, None) => {
                format!("not needed alone, needed without {}", with.join(", "))
            }
        };
        let at = finding
            .change
            .and_then(|change| change.at)
            .map_or_else(String::new, |at| format!(" (at {})", corner_name(at)));
        [finding.part.name()].into_iter().chain(values).chain([verdict + &at]).collect::<Vec<String>>()
    });
    let headings: Vec<&str> =
        ["without"].into_iter().chain(columns.iter().copied()).chain(["verdict"]).collect();
    let words = headings.len();
    table(presets::NOTHING, headings, rows, words)
}

fn left_out(needs: &Needs, by_motion: bool) -> String {
    if needs.cut.is_empty() {
        return "\nNothing can be left out.\n".to_owned();
    }
    let names: Vec<String> = needs.cut.iter().map(|part| part.name()).collect();
    let change = &needs.cut_change;
    let changes = if by_motion {
        format!("{MOTION} {}", percent(change.displacement))
    } else {
        format!("mean power {}, RMS voltage {}", percent(change.mean_power), percent(change.rms_voltage))
    };
    format!("\nWithout {} together: {changes}.\n", names.join(", "))
}

fn control(setting: &Setting) -> String {
    match setting.control {
        Control::Tolerance(tolerance) => format!("tolerance {tolerance:e}"),
        Control::FixedStep(step_s) => format!("fixed step {step_s:.2e} s"),
        Control::ShortAndLong([short, long]) => format!("steps {short:.2e} and {long:.2e} s"),
    }
}

fn numerics_table(numerics: &[Numerics], by_motion: bool) -> String {
    let least = numerics.iter().map(|found| found.host_s_per_s).fold(f64::INFINITY, f64::min);
    let rows = numerics.iter().map(|found| {
        vec![
            name(&found.setting.method),
            found.setting.precision.name().to_owned(),
            control(&found.setting),
            percent(if by_motion { found.change.displacement } else { found.change.mean_power }),
            format!("{:.0}", found.steps_per_s),
            format!("{:.2}", found.host_s_per_s / least),
            percent(found.host_spread),
        ]
    });
    let deciding = if by_motion { MOTION } else { "mean power" };
    let headings = ["method", "precision", "control", deciding, "steps per s", "processor time", "spread"];
    table(presets::NOTHING, headings, rows, 3)
}

/// That of the least work in single precision.
fn least_single(numerics: &[Numerics]) -> Option<&Numerics> {
    numerics.iter().find(|found| found.setting.precision == Precision::F32)
}

fn chosen(numerics: &[Numerics]) -> String {
    let single = least_single(numerics);
    match single.or(numerics.first()) {
        None => "\nNo method of the core holds the accuracy.\n".to_owned(),
        Some(found) => {
            let setting = &found.setting;
            let only = if single.is_none() { "; f32 does not hold the accuracy" } else { "" };
            format!(
                "\nFor a node: {}, {}, {}{only}.\n",
                name(&setting.method),
                setting.precision.name(),
                control(setting)
            )
        }
    }
}

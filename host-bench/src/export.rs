//! Scenes for other programs: as netlists of SPICE, a subcircuit with the terminals of the harvester and a deck that runs it; as FMUs.

mod cantilever;
mod contact_separation;
mod fmu;
mod sliding;

use std::fmt::Write as _;
use std::path::Path;

use crate::method::Failure;
use crate::name::Name;
use crate::scene_file::{
    Excitation, ForceLaw, KEYS, Load, Model, Override, Scene, Tone, key::Value, number_at, rows_of,
};

pub(crate) use self::fmu::fmu;

pub(crate) struct Netlist {
    /// Equations, signs and accuracy, as lines of a comment.
    notes: String,
    parameters: Vec<Parameter>,
    elements: String,
    /// Time steps of the deck in a period of the excitation.
    points: f64,
    options: &'static str,
}

struct Parameter {
    name: String,
    value: f64,
    unit: &'static str,
    meaning: String,
}

impl Parameter {
    fn new(name: &str, value: f64, unit: &'static str, meaning: &str) -> Self {
        Self { name: name.to_owned(), value, unit, meaning: meaning.to_owned() }
    }

    /// A key of `[parameters]`, with its unit and meaning.
    fn of_key(key: &str, value: f64) -> Self {
        let row = rows_of(key)[0];
        Self::new(&key.trim_start_matches("parameters.").replace('.', "_"), value, row.unit, row.meaning)
    }
}

/// What every subcircuit has of terminals and signs.
const TERMINALS: &str = "p, n  electrical terminals. V(p,n) is the terminal voltage; positive, it drives a current out of p through the load.
acc   base acceleration as a voltage against node 0, 1 V for 1 m/s^2. Connect a source or a recorded acceleration.
A transient analysis starts in the state of the scene with the option uic.
";

impl Netlist {
    /// The netlist of a scene. Refuses parts that no netlist here has.
    pub(crate) fn new(scene: &Scene) -> Result<Self, Failure> {
        match &scene.model {
            Model::BumpStop(model) => cantilever::netlist(scene, model),
            Model::ContactSeparation(model) => Ok(contact_separation::netlist(model)),
            Model::Sliding(model) => Ok(sliding::netlist(model)),
        }
    }

    /// The file of the subcircuit; `command` made it.
    pub(crate) fn subcircuit(&self, scene: &Scene, overrides: &[Override], command: &str) -> String {
        let made = format!(
            "Harvester \"{}\" of {}, made by host-bench {}:\n{command}\n\n",
            scene.name(),
            Name::of_file(&scene.file).line(),
            env!("CARGO_PKG_VERSION")
        );
        let mut text = comment(&format!("{made}{TERMINALS}\n{}\n{}", self.notes, values(scene, overrides)));
        text += ".subckt harvester p n acc params:\n";
        for Parameter { name, value, unit, meaning } in &self.parameters {
            let _ = writeln!(text, "+ {name}={value:e} ; {}: {}", ascii(unit), ascii(meaning));
        }
        text + &self.elements + ".ends harvester\n"
    }

    /// A deck that includes the subcircuit from a file in its folder, with load, excitation and window of the scene. Refuses others.
    pub(crate) fn deck(&self, scene: &Scene, subcircuit: &Path) -> Result<String, Failure> {
        let refuse = |text: &str| Err(Failure::of_file(scene, text));
        let Excitation::Sine(Tone { amplitude_m_per_s2, frequency_hz, phase_rad }) = scene.excitation else {
            return refuse("excitation.kind: must be \"sine\" for --deck");
        };
        if !(frequency_hz > 0.0) {
            return refuse("excitation.frequency_hz: is 0, must be above 0 for --deck");
        }
        let ohm = match scene.load {
            Load::Resistor { resistance_ohm } if resistance_ohm > 0.0 && resistance_ohm.is_finite() => {
                resistance_ohm
            }
            Load::Resistor { .. } => {
                return refuse(
                    "load.resistance_ohm: must be above 0 and finite for --deck, which measures its power",
                );
            }
            Load::RectifiedStore(_) | Load::DcBus { .. } => {
                return refuse("load.kind: must be \"resistor\" for --deck; --spice alone takes any load");
            }
        };
        let (settle, end) = (scene.run.settle_s, scene.run.duration_s);
        let step = 1.0 / (frequency_hz * self.points);
        let name = Name::of_file(subcircuit).line();
        Ok(format!(
            "* Runs the subcircuit with load, excitation and window of the scene, in this folder: ngspice -b THIS_FILE
* mean_power_w and rms_voltage_v stand beside those of host-bench run SCENE.
.include \"{name}\"
Xharvester p 0 acc harvester
Vacc acc 0 SIN(0 {amplitude_m_per_s2:e} {frequency_hz:e} 0 0 {:e}) ; m/s^2, Hz, degrees
Rload p 0 {ohm:e}
Bpower power 0 V=V(p)*V(p)/{ohm:e} ; W
.save v(p) v(power)
.options {}
.tran {step:e} {end:e} {settle:e} {step:e} uic
.meas tran mean_power_w AVG v(power) from={settle:e} to={end:e}
.meas tran rms_voltage_v RMS v(p) from={settle:e} to={end:e}
.end
",
            phase_rad.to_degrees(),
            self.options,
        ))
    }
}

/// A force law in the notes, after its symbol.
fn law_name(law: ForceLaw) -> &'static str {
    match law {
        ForceLaw::TransferredCharge => " of force_law = \"transferred-charge\"",
        ForceLaw::GapField => " of force_law = \"gap-field\"",
        ForceLaw::None => " = 0",
    }
}

/// The numbers of a scene's tables of the harvester, with units.
fn values(scene: &Scene, overrides: &[Override]) -> String {
    let mut text = "Values of the scene:\n".to_owned();
    for table in KEYS.kind(scene.name()).map_or(&[][..], |kind| kind.keys) {
        let Value::Table(keys) = table.value else { continue };
        for key in keys.keys.iter().filter(|_| ["parameters", "tip_mass"].contains(&table.name)) {
            let place = format!("{}.{}", table.name, key.name);
            if let Ok(Some(value)) = number_at(&scene.file, overrides, &place) {
                let _ = writeln!(text, "{place} = {value:e} {}", key.unit);
            }
        }
    }
    text
}

fn comment(text: &str) -> String {
    text.lines().map(|line| format!("* {}", ascii(line)).trim_end().to_owned() + "\n").collect()
}

/// A text in the letters that every SPICE reads.
fn ascii(text: &str) -> String {
    let spelled =
        [("²", "^2"), ("³", "^3"), ("Ω", "ohm"), ("√", "sqrt "), ("·", " "), ("ε", "eps"), ("−", "-")];
    let text = spelled.iter().fold(text.to_owned(), |text, (letter, word)| text.replace(letter, word));
    text.replace(|letter: char| !(letter.is_ascii_graphic() || letter == ' '), "?")
}

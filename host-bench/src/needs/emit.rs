//! The cut scene as a Rust module for firmware: types, constants, method and step.

mod component;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use self::component::{
    Component, bridge, force_law, load, number, restitution, stop, tip_mass, unit, with_fields,
};
use super::numerics::{Control, Setting};
use super::part::Part;
use crate::method::{Failure, Method, Precision};
use crate::name::Name;
use crate::scene_file::{
    Bimorph, BumpStop, ContactSeparation, Coupling, Load, Model, Scene, Sliding, StickCharge,
    TriboelectricStart,
};
use model_core::clock::Instant;

/// Modules of the library with the names that a scene may use.
const MODULES: [(&str, &[&str]); 14] = [
    ("excitation", &["Burst", "Random", "Silence", "Sine", "SpectralDensity", "Sweep", "SweepLaw", "Tones"]),
    ("integrate", &["Adaptive", "ExponentialRadau", "FixedStep", "RungeKutta4", "TrBdf2"]),
    ("part::draw", &["CurrentDraw", "Lockout", "NoDraw", "PowerDraw", "ResistiveDraw"]),
    ("part::force_law", &["GapField", "NoForce", "TransferredCharge"]),
    ("part::friction", &["Frictionless", "PatchFriction"]),
    ("part::load", &["OpenCircuit", "Resistor", "ShortCircuit"]),
    ("part::monomorph", &["Bimorph", "Layer", "Monomorph"]),
    ("part::parasitic", &["NoParasitic", "ParasiticCapacitance"]),
    ("part::rectifier", &["FullBridge"]),
    ("part::restitution", &["ConstantRestitution", "VelocityDependentRestitution"]),
    ("part::storage", &["Capacitor", "DcBus", "StorageCapacitor"]),
    ("part::stick_charge", &["NeverSticks", "StickCharge"]),
    ("scene", &["Simulation"]),
    ("scene::rectified", &["Rectified"]),
];
/// Names that the module of each kind of scene has.
const OF_SCENE: [&str; 19] = [
    "Choices",
    "ContactSeparation",
    "DisplacementConstraint",
    "FieldLateralForce",
    "NoLateralForce",
    "NoStop",
    "NoTipMass",
    "OneWay",
    "Parameters",
    "ResidualFlexibility",
    "Resistive",
    "Restitution",
    "Sliding",
    "Start",
    "Stepper",
    "Stop",
    "TipMass",
    "TwoWay",
    "BumpStop",
];

pub(crate) struct Emission<'a> {
    /// The scene without the parts that it does not need.
    pub(crate) scene: &'a Scene,
    /// The parts that were left out.
    pub(crate) cut: &'a [Part],
    pub(crate) setting: Setting,
    pub(crate) command: &'a str,
    /// Relative accuracy of the mean power.
    pub(crate) accuracy: f64,
    /// Mean power of the full scene in W.
    pub(crate) mean_power_w: f64,
}

/// The pieces of a module that depend on the kind of scene.
struct Pieces {
    parameters: String,
    choices_type: String,
    harvester_type: String,
    /// Statements of `harvester` after the scene was built.
    build: String,
    start: String,
    start_type: String,
}

impl Emission<'_> {
    /// The module. Refuses a setting in double precision, and a scene that delivers no power.
    pub(crate) fn module(&self) -> Result<String, Failure> {
        if self.setting.precision != Precision::F32 {
            return Err(Failure::Input("--emit: f32 does not hold the accuracy".to_owned()));
        }
        if !(self.mean_power_w != 0.0) {
            return Err(Failure::Input("--emit, --core: the scene delivers no power".to_owned()));
        }
        let pieces = match &self.scene.model {
            Model::ContactSeparation(model) => self.contact_separation(model),
            Model::Sliding(model) => self.sliding(model),
            Model::BumpStop(model) => self.bump_stop(model),
        };
        let mut text = self.constants()?;
        let Pieces { parameters, choices_type, harvester_type, build, start, start_type, .. } = &pieces;
        let _ = write!(
            text,
            "
/// The parts that the scene needs.
pub type Parts = {choices_type};

/// The harvester.
pub type Model = {harvester_type};

/// Its parameters in SI units.
pub const PARAMETERS: Parameters<f32, Parts> = {parameters};

/// The harvester; `None` if a parameter is refused.
pub fn harvester() -> Option<Model> {{
{build}}}

/// Its initial values.
pub fn start() -> {start_type} {{
    {start}
}}
"
        );
        text += &component::source(&self.scene.excitation);
        Ok(format!("{}{}{text}", self.head(), self.imports(&text)))
    }

    fn head(&self) -> String {
        let names: Vec<String> = self.cut.iter().map(|part| part.name()).collect();
        let left_out = if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
        format!("// Made by `{}`.\n//\n// Left out: {left_out}.\n\n", Name::new(self.command).line())
    }

    fn imports(&self, body: &str) -> String {
        let scene = format!("scene::{}", self.scene.name().replace('-', "_"));
        let words: BTreeSet<&str> =
            body.split(|letter: char| !letter.is_alphanumeric() && letter != '_').collect();
        let modules =
            MODULES.iter().map(|(module, names)| (*module, *names)).chain([(&*scene, &OF_SCENE[..])]);
        let line = |(module, names): (&str, &[&str])| {
            let used: Vec<&str> = names.iter().copied().filter(|name| words.contains(name)).collect();
            match used.as_slice() {
                [] => None,
                [one] => Some(format!("use model_core::{module}::{one};\n")),
                several => Some(format!("use model_core::{module}::{{{}}};\n", several.join(", "))),
            }
        };
        let mut lines: Vec<String> = modules.filter_map(line).collect();
        lines.extend(words.contains("PhantomData").then(|| "use core::marker::PhantomData;\n".to_owned()));
        lines.sort();
        lines.concat()
    }

    fn constants(&self) -> Result<String, Failure> {
        let ticks = |seconds: f64| {
            let refused = || Failure::Input(format!("--emit: run: {seconds} s is too long"));
            Instant::from_seconds(seconds).map(Instant::ticks).ok_or_else(refused)
        };
        let (settle, end) = (ticks(self.scene.run.settle_s)?, ticks(self.scene.run.duration_s)?);
        Ok(format!(
            "
/// Mean power of the full scene in W, in double precision.
pub const MEAN_POWER: f32 = {};
/// Relative accuracy to which this module holds it.
pub const ACCURACY: f32 = {};
/// Start and end of the window of the mean power in ticks of the clock.
pub const WINDOW_TICKS: [u64; 2] = [{settle}, {end}];
",
            number(self.mean_power_w),
            number(self.accuracy),
        ))
    }

    fn contact_separation(&self, model: &ContactSeparation) -> Pieces {
        let from = &model.parameters;
        let parasitic = if from.parasitic_capacitance_f > 0.0 {
            with_fields("ParasiticCapacitance", &[("capacitance", number(from.parasitic_capacitance_f))])
        } else {
            unit("NoParasitic")
        };
        let choices = [
            ("load", load(self.scene.load)),
            ("restitution", restitution(&from.restitution)),
            ("force_law", force_law(from.force_law)),
            ("parasitic", parasitic),
            ("sticking", self.sticking(from.stick_charge)),
        ];
        let numbers = model_core::contact_separation_numbers!(harvester_scene::of_rows! { names from });
        self.triboelectric("ContactSeparation", &choices, &numbers, ("gap", &model.initial))
    }

    fn sliding(&self, model: &Sliding) -> Pieces {
        let from = &model.parameters;
        let coefficients = [
            ("static_active", from.static_friction_active),
            ("static_inert", from.static_friction_inert),
            ("kinetic_active", from.kinetic_friction_active),
            ("kinetic_inert", from.kinetic_friction_inert),
        ];
        let friction = if coefficients.iter().all(|(_, value)| *value == 0.0) {
            unit("Frictionless")
        } else {
            with_fields("PatchFriction", &coefficients.map(|(field, value)| (field, number(value))))
        };
        let choices = [
            ("load", load(self.scene.load)),
            ("friction", friction),
            ("force_law", force_law(from.force_law)),
            ("sticking", self.sticking(from.stick_charge)),
            ("lateral_force", unit(if from.lateral_force { "FieldLateralForce" } else { "NoLateralForce" })),
        ];
        let numbers = model_core::sliding_numbers!(harvester_scene::of_rows! { names from });
        self.triboelectric("Sliding", &choices, &numbers, ("displacement", &model.initial))
    }

    /// The behaviour in stick, or that the moving part never sticks.
    fn sticking(&self, charge: StickCharge) -> Component {
        if self.cut.contains(&Part::Sticking) {
            return unit("NeverSticks");
        }
        let value = match charge {
            StickCharge::Frozen => "StickCharge::Frozen",
            StickCharge::Relaxing => "StickCharge::Relaxing",
        };
        Component { of_type: "StickCharge".to_owned(), value: value.to_owned() }
    }

    fn triboelectric(
        &self,
        scene: &str,
        choices: &[(&str, Component)],
        numbers: &[(&str, f64)],
        (position, initial): (&str, &TriboelectricStart),
    ) -> Pieces {
        let start = [
            (position, initial.position_m),
            ("velocity", initial.velocity_m_per_s),
            ("charge", initial.charge_c),
        ];
        let choice_types: Vec<&str> = choices.iter().map(|(_, choice)| choice.of_type.as_str()).collect();
        let choices_type = format!("Choices<{}>", choice_types.join(", "));
        let (method, control_type, control) = self.stepping();
        let bridge = bridge(self.scene.load);
        let (scene_type, states, wrap) = match &bridge {
            None => (format!("{scene}<f32, Parts>"), 3, String::new()),
            Some((bridge, storage)) => (
                format!("Rectified<f32, {scene}<f32, Parts>, {storage}>"),
                4,
                format!("    let scene = Rectified::new(scene, {}).ok()?;\n", bridge.value),
            ),
        };
        let start_values: Vec<String> = start
            .iter()
            .filter_map(|(field, value)| value.map(|value| format!("{field}: Some({}), ", number(value))))
            .collect();
        let rest = if start_values.len() == start.len() { "" } else { "..Start::default() " };
        Pieces {
            parameters: parameters(numbers, &choices_value(choices)),
            choices_type,
            harvester_type: format!("Simulation<{scene_type}, {method}, {control_type}, {states}, 1>"),
            build: format!(
                "    let scene = PARAMETERS.build().ok()?;\n{wrap}    Some(Simulation::new(scene, {method}, {control}.ok()?))\n"
            ),
            start: format!("Start {{ {}{rest}}}", start_values.concat()),
            start_type: "Start<f32>".to_owned(),
        }
    }

    /// The method, and the type and value of the control of the step.
    fn stepping(&self) -> (&'static str, &'static str, String) {
        let method = match self.setting.method {
            Method::TrBdf2 => "TrBdf2",
            Method::Rk4 => "RungeKutta4",
            _ => "ExponentialRadau",
        };
        match self.setting.control {
            Control::Tolerance(tolerance) => {
                (method, "Adaptive<f32>", format!("Adaptive::new({})", number(tolerance)))
            }
            Control::FixedStep(step_s) | Control::ShortAndLong([step_s, _]) => {
                (method, "FixedStep", format!("FixedStep::of_seconds({})", number(step_s)))
            }
        }
    }

    fn bump_stop(&self, model: &BumpStop) -> Pieces {
        let from = &model.parameters;
        let circuit = circuit(self.scene.load);
        let coupling = match from.coupling {
            Coupling::TwoWay => unit("TwoWay"),
            Coupling::OneWay => unit("OneWay"),
        };
        let stop = model.stop.as_ref().map_or_else(|| unit("NoStop"), stop);
        let tip_mass = from.tip_mass.map_or_else(|| unit("NoTipMass"), |body| tip_mass(&body));
        let choices = [
            ("load", circuit),
            ("stop", stop),
            ("coupling", coupling),
            ("tip_mass", tip_mass),
            ("transducer", transducer(from.transducer)),
        ];
        let choice_types = choices.each_ref().map(|(_, choice)| choice.of_type.as_str());
        let choices_type = format!("Choices<{}>", choice_types.join(", "));
        let [beam, rod] = model.modes();
        let (short, long) = match self.setting.control {
            Control::ShortAndLong([short, long]) => (short, long),
            Control::FixedStep(step) | Control::Tolerance(step) => (step, step),
        };
        let substrate = layer(
            from.substrate_thickness_m,
            from.substrate_young_modulus_pa,
            from.substrate_density_kg_per_m3,
        );
        let piezo = layer(from.piezo_thickness_m, from.piezo_young_modulus_pa, from.piezo_density_kg_per_m3);
        let choices = choices_value(&choices);
        let numbers = [
            ("beam_length", from.beam_length_m),
            ("beam_width", from.beam_width_m),
            ("piezo_d31", from.piezo_d31_m_per_v),
            ("piezo_permittivity", from.piezo_permittivity_f_per_m),
            ("damping_ratio", from.damping_ratio),
        ];
        let layers = format!("    substrate: {substrate},\n    piezo: {piezo},\n{choices}");
        let initial = &model.initial;
        Pieces {
            parameters: parameters(&numbers, &layers),
            choices_type,
            harvester_type: format!("Stepper<f32, Parts, {beam}, {rod}>"),
            build: format!(
                "    let scene = PARAMETERS.build::<{beam}, {rod}>().ok()?;\n    Stepper::new(scene, {}, {}).ok()\n",
                number(short),
                number(long)
            ),
            start: format!(
                "Start {{ beam: [{}], rod: [{}], voltage: {} }}",
                pairs(&initial.modal_displacement, &initial.modal_velocity),
                pairs(&initial.rod_modal_displacement, &initial.rod_modal_velocity),
                number(initial.voltage_v)
            ),
            start_type: format!("Start<f32, {beam}, {rod}>"),
        }
    }
}

/// The circuit at the terminals of a piezoelectric layer.
fn circuit(of: Load) -> Component {
    if let Some((bridge, _)) = bridge(of) {
        return bridge;
    }
    let Component { of_type, value } = load(of);
    Component { of_type: format!("Resistive<{of_type}>"), value: format!("Resistive({value})") }
}

fn transducer(of: Option<Bimorph>) -> Component {
    match of {
        None => unit("Monomorph"),
        Some(Bimorph::Series) => Component { value: "Bimorph::Series".to_owned(), ..unit("Bimorph") },
        Some(Bimorph::Parallel) => Component { value: "Bimorph::Parallel".to_owned(), ..unit("Bimorph") },
    }
}

/// A layer of the beam as Rust source.
fn layer(thickness: f64, young_modulus: f64, density: f64) -> String {
    let [thickness, young_modulus, density] = [thickness, young_modulus, density].map(number);
    format!("Layer {{ thickness: {thickness}, young_modulus: {young_modulus}, density: {density} }}")
}

/// Displacement and velocity of each mode at the start as Rust source.
fn pairs(displacements: &[f64], velocities: &[f64]) -> String {
    let pairs = displacements.iter().zip(velocities);
    let pairs: Vec<String> = pairs.map(|(x, v)| format!("[{}, {}]", number(*x), number(*v))).collect();
    pairs.join(", ")
}

/// The field `choices` of parameters.
fn choices_value(choices: &[(&str, Component)]) -> String {
    let fields = choices.iter().map(|(field, choice)| format!("        {field}: {},\n", choice.value));
    format!("    choices: Choices {{\n{}    }},\n", fields.collect::<String>())
}

fn parameters(numbers: &[(&str, f64)], rest: &str) -> String {
    let fields = numbers.iter().map(|(field, value)| format!("    {field}: {},\n", number(*value)));
    format!("Parameters {{\n{}{rest}}}", fields.collect::<String>())
}

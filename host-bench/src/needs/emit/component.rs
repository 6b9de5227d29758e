//! The components of a scene as Rust source.

use crate::scene_file::{
    Burst, BurstShape, Contact, Draw, Excitation, ForceLaw, Load, Lockout, Random, Restitution,
    StopParameters, Sweep, TipMassParameters, Tone,
};

/// A component: its type and its value, as Rust source.
pub(super) struct Component {
    pub(super) of_type: String,
    pub(super) value: String,
}

pub(super) fn unit(name: &str) -> Component {
    Component { of_type: name.to_owned(), value: name.to_owned() }
}

/// A struct with one type parameter for its numbers.
pub(super) fn with_fields(name: &str, fields: &[(&str, String)]) -> Component {
    let fields: Vec<String> = fields.iter().map(|(field, value)| format!("{field}: {value}")).collect();
    Component { of_type: format!("{name}<f32>"), value: format!("{name} {{ {} }}", fields.join(", ")) }
}

pub(super) fn number(value: f64) -> String {
    let single = value as f32;
    if single.is_finite() { format!("{single:?}") } else { "f32::INFINITY".to_owned() }
}

/// A resistive load; the open circuit in front of a bridge.
pub(super) fn load(load: Load) -> Component {
    match load.resistance_ohm() {
        0.0 => unit("ShortCircuit"),
        f64::INFINITY => unit("OpenCircuit"),
        resistance => with_fields("Resistor", &[("resistance", number(resistance))]),
    }
}

pub(super) fn restitution(restitution: &Restitution) -> Component {
    match *restitution {
        Restitution::Constant { coefficient } => {
            with_fields("ConstantRestitution", &[("coefficient", number(coefficient))])
        }
        Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s } => with_fields(
            "VelocityDependentRestitution",
            &[
                ("at_rest", number(at_rest)),
                ("at_speed", number(at_speed)),
                ("reference_speed", number(reference_speed_m_per_s)),
                ("mathematics", "PhantomData".to_owned()),
            ],
        ),
    }
}

pub(super) fn force_law(law: ForceLaw) -> Component {
    unit(match law {
        ForceLaw::TransferredCharge => "TransferredCharge",
        ForceLaw::GapField => "GapField",
        ForceLaw::None => "NoForce",
    })
}

pub(super) fn stop(stop: &StopParameters) -> Component {
    let contact = match stop.contact {
        Contact::ResidualFlexibility => unit("ResidualFlexibility"),
        Contact::DisplacementConstraint => unit("DisplacementConstraint"),
        Contact::Restitution => {
            with_fields("Restitution", &[("coefficient", number(stop.restitution.unwrap_or(1.0)))])
        }
    };
    let fields = [
        ("length", stop.length_m),
        ("section", stop.width_m * stop.thickness_m),
        ("young_modulus", stop.young_modulus_pa),
        ("density", stop.density_kg_per_m3),
        ("position", stop.position_m),
        ("gap", stop.gap_m),
        ("contact_compliance", stop.contact_compliance_m_per_n),
    ];
    let fields = fields.map(|(field, value)| (field, number(value)));
    let fields = [fields.as_slice(), &[("contact", contact.value)]].concat();
    Component { of_type: format!("Stop<f32, {}>", contact.of_type), ..with_fields("Stop", &fields) }
}

pub(super) fn tip_mass(body: &TipMassParameters) -> Component {
    let fields = model_core::tip_mass_numbers!(harvester_scene::of_rows! { names body });
    with_fields("TipMass", &fields.map(|(field, value)| (field, number(value))))
}

/// The bridge, and the type of its storage; `None` where the load is a resistor.
pub(super) fn bridge(load: Load) -> Option<(Component, String)> {
    let (storage, drop) = match load {
        Load::Resistor { .. } => return None,
        Load::DcBus { voltage_v, diode_drop_v } => {
            (with_fields("DcBus", &[("voltage", number(voltage_v))]), diode_drop_v)
        }
        Load::RectifiedStore(store) => {
            let capacitor = with_fields(
                "Capacitor",
                &[
                    ("capacitance", number(store.capacitance_f)),
                    ("leakage_resistance", number(store.leakage_ohm)),
                ],
            );
            let draw = draw(store.draw);
            let value = with_fields(
                "StorageCapacitor",
                &[
                    ("capacitor", capacitor.value),
                    ("initial_voltage", number(store.initial_v)),
                    ("draw", draw.value),
                ],
            );
            let of_type = format!("StorageCapacitor<f32, {}>", draw.of_type);
            (Component { of_type, ..value }, store.diode_drop_v)
        }
    };
    let value = with_fields("FullBridge", &[("diode_drop", number(drop)), ("storage", storage.value)]);
    let of_type = format!("FullBridge<f32, {}>", storage.of_type);
    Some((Component { of_type, ..value }, storage.of_type))
}

fn draw(draw: Draw) -> Component {
    let thresholds = |lockout: Lockout| {
        let fields = [("turn_on", number(lockout.turn_on_v)), ("turn_off", number(lockout.turn_off_v))];
        with_fields("Lockout", &fields).value
    };
    match draw {
        Draw::None => unit("NoDraw"),
        Draw::Resistor { resistance_ohm, lockout } => {
            let lockout =
                lockout.map_or("None".to_owned(), |lockout| format!("Some({})", thresholds(lockout)));
            with_fields("ResistiveDraw", &[("resistance", number(resistance_ohm)), ("lockout", lockout)])
        }
        Draw::Current { current_a, lockout } => {
            with_fields("CurrentDraw", &[("current", number(current_a)), ("lockout", thresholds(lockout))])
        }
        Draw::Power { power_w, lockout } => {
            with_fields("PowerDraw", &[("power", number(power_w)), ("lockout", thresholds(lockout))])
        }
    }
}

/// The function `excitation` and a test of the mean power; nothing for a trace, which stays in its file.
pub(super) fn source(excitation: &Excitation) -> String {
    function(excitation).map_or_else(String::new, |function| format!("{function}{TEST}"))
}

fn function(excitation: &Excitation) -> Option<String> {
    let (of_type, body) = match excitation {
        Excitation::Sine(tone) => ("Sine<f32>".to_owned(), format!("    Sine::new({}).ok()\n", sine(tone))),
        Excitation::Sines(tones) => (format!("Tones<f32, {}>", tones.len()), sum(tones)),
        Excitation::Burst(given) => ("Burst<f32>".to_owned(), burst(given)),
        Excitation::Sweep(given) => ("Sweep<f32>".to_owned(), sweep(given)),
        Excitation::Random(given) => (format!("Random<f32, {}>", given.lines), random(given)),
        Excitation::Silence => ("Silence".to_owned(), "    Some(Silence)\n".to_owned()),
        Excitation::File(_) => return None,
    };
    Some(format!(
        "
/// The base acceleration of the scene; `None` if it is refused.
pub fn excitation() -> Option<{of_type}> {{
{body}}}
"
    ))
}

/// The arguments of `Sine::new`.
fn sine(tone: &Tone) -> String {
    [tone.amplitude_m_per_s2, tone.frequency_hz, tone.phase_rad].map(number).join(", ")
}

fn sum(tones: &[Tone]) -> String {
    let push = |tone| format!("    tones.push(Sine::new({}).ok()?).ok()?;\n", sine(tone));
    let pushed: String = tones.iter().map(push).collect();
    format!("    let mut tones = Tones::new();\n{pushed}    Some(tones)\n")
}

fn burst(given: &Burst) -> String {
    let amplitude = number(given.amplitude_m_per_s2);
    let once = match given.shape {
        BurstShape::HalfSine { duration_s } => format!("half_sine({amplitude}, {})", number(duration_s)),
        BurstShape::Cycles { frequency_hz, cycles } => {
            format!("cycles({amplitude}, {}, {cycles})", number(frequency_hz))
        }
    };
    let start = number(given.start_s);
    let again = given.period_s.map_or_else(String::new, |period| format!("?.every({})", number(period)));
    // One `?` for each fallible call: the function returns an option.
    let chain = format!("Burst::{once}?.starting_at({start}){again}").replace('?', ".ok()?");
    format!("    {chain}.ok()\n")
}

fn sweep(given: &Sweep) -> String {
    let law = if given.logarithmic { "Logarithmic" } else { "Linear" };
    let [amplitude, from, to, seconds, phase] =
        [given.amplitude_m_per_s2, given.from_hz, given.to_hz, given.sweep_s, given.phase_rad].map(number);
    format!("    Sweep::new({amplitude}, [{from}, {to}], {seconds}, SweepLaw::{law}, {phase}).ok()\n")
}

fn random(given: &Random) -> String {
    let points: Vec<String> =
        given.density.iter().map(|point| format!("[{}]", point.map(number).join(", "))).collect();
    format!(
        "    // Frequency in Hz and one-sided spectral density in (m/s²)²/Hz.
    let density = SpectralDensity::new(&[{}]).ok()?;
    Random::new(&density, {}, {}).ok()
",
        points.join(", "),
        given.lines,
        given.seed
    )
}

const TEST: &str = "
#[cfg(test)]
mod tests {
    use model_core::clock::{Instant, TICKS_PER_SECOND};
    use model_core::energy::PowerMeter;
    use model_core::scene::Harvester;

    use super::{ACCURACY, MEAN_POWER, WINDOW_TICKS, excitation, harvester, start};

    #[test]
    fn the_mean_power_is_that_of_the_full_scene() {
        let (Some(harvester), Some(excitation)) = (harvester(), excitation()) else { panic!(\"refused\") };
        let mut state = harvester.start(&start(), &excitation).expect(\"starts\");
        let mut meter = PowerMeter::new();
        for ticks in WINDOW_TICKS {
            meter = PowerMeter::new();
            let until = Instant::from_ticks(ticks);
            let advance = harvester.advance(&mut state, &excitation, until, u32::MAX, &mut meter);
            assert!(advance.is_ok());
        }
        let [settled, end] = WINDOW_TICKS;
        let seconds = (end - settled) as f32 / TICKS_PER_SECOND as f32;
        let change = meter.delivered_energy() / seconds / MEAN_POWER - 1.0;
        assert!(change.abs() <= ACCURACY, \"{change}\");
    }
}
";

#[cfg(test)]
mod tests;

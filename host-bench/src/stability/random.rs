//! Random scenes: over the whole range of the bounds, and of stated features. A case follows from a seed and its number alone.

mod feature;

pub use self::feature::{Source, draw_varied};
use super::Case;
use super::grid::FORCE_LAWS;
use crate::method::Precision;
use crate::scene_file::key::Value;
use crate::scene_file::{number_at, rows_of, shipped};

/// A shipped scene, one of its tables, and the keys of it that are drawn about their values.
type Drawn = [&'static str; 3];

const CONTACT_SEPARATION: Drawn = [
    "contact-separation",
    "parameters",
    "mass_kg stiffness_n_per_m initial_gap_m electrode_area_m2 dielectric_thickness_m relative_permittivity \
     charge_density_c_per_m2",
];
const SLIDING: Drawn = [
    "sliding",
    "parameters",
    "beam_length_m beam_width_m beam_thickness_m young_modulus_pa density_kg_per_m3 slider_mass_kg patch_radius_m \
     dielectric_thickness_m relative_permittivity charge_density_c_per_m2",
];
const BUMP_STOP: Drawn = [
    "bump-stop",
    "parameters",
    "beam_length_m beam_width_m substrate_thickness_m substrate_young_modulus_pa substrate_density_kg_per_m3 \
     piezo_thickness_m piezo_young_modulus_pa piezo_d31_m_per_v piezo_permittivity_f_per_m",
];
const STOP: Drawn = ["bump-stop", "stop", "length_m width_m thickness_m young_modulus_pa density_kg_per_m3"];
const BUMP_STOP_SCENES: [&str; 4] = ["bump-stop", "bump-stop-tip", "bump-stop-mid-span", "bump-stop-none"];
/// Decades up to which the dimensions and materials of a scene are changed.
const SPREADS: [f64; 5] = [0.0, 0.0, 0.2, 0.5, 1.5];

/// The case of a number under a seed.
pub fn draw(seed: u64, number: u64) -> Case {
    let mut source = Source::new(seed, number);
    let kind = source.uniform(0.0, 1.0);
    let drawing = Drawing { source, changes: Vec::new() };
    match kind {
        ..0.4 => drawing.contact_separation(),
        ..0.7 => drawing.sliding(),
        _ => drawing.bump_stop(),
    }
}

struct Drawing {
    source: Source,
    changes: Vec<(String, String)>,
}

impl Drawing {
    fn set(&mut self, key: &str, value: impl Into<String>) {
        self.changes.push((key.to_owned(), value.into()));
    }

    fn set_number(&mut self, key: &str, value: f64) {
        self.set(key, text(value));
    }

    fn case(mut self, scene: &'static str) -> Case {
        let precision = self.source.one_of([Precision::F32, Precision::F64]);
        Case { scene, changes: self.changes, step_s: None, precision }
    }

    fn contact_separation(mut self) -> Case {
        self.spread(CONTACT_SEPARATION);
        self.triboelectric();
        let restitution = if self.source.chance(0.5) {
            let extremes = [0.0, 0.99, 1.0, self.source.uniform(0.0, 1.0), self.source.uniform(0.0, 1.0)];
            format!("{{kind=\"constant\",coefficient={}}}", text(self.source.one_of(extremes)))
        } else {
            let [at_rest, at_speed] = [(); 2].map(|()| text(self.source.uniform(0.0, 1.0)));
            let speed = text(self.source.logarithmic(1e-4, 1e2));
            format!(
                "{{kind=\"velocity-dependent\",at_rest={at_rest},at_speed={at_speed},reference_speed_m_per_s={speed}}}"
            )
        };
        self.set("parameters.restitution", restitution);
        if self.source.chance(0.6) {
            let parasitic = self.source.logarithmic(1e-14, 1e-8);
            self.set_number("parameters.parasitic_capacitance_f", parasitic);
        }
        if self.source.chance(0.3) {
            let [gap, velocity] = [self.source.logarithmic(1e-7, 3e-2), self.source.signed(1e-5, 10.0)];
            self.set_number("initial.gap_m", gap);
            self.set_number("initial.velocity_m_per_s", velocity);
        }
        self.start_charge();
        self.load();
        self.excitation(20.0, [1e-3, 1e3]);
        self.case("contact-separation")
    }

    fn sliding(mut self) -> Case {
        self.spread(SLIDING);
        self.triboelectric();
        for patch in ["active", "inert"] {
            let kinetic = self.source.logarithmic(1e-4, 3.0);
            let above = 1.0 + self.source.uniform(0.0, 1.0);
            let above = self.source.one_of([1.0, above]);
            self.set_number(&format!("parameters.kinetic_friction_{patch}"), kinetic);
            // Not below the kinetic friction where the last digit of the two is rounded.
            self.set_number(&format!("parameters.static_friction_{patch}"), rounded(kinetic) * above * 1.001);
        }
        let lateral = self.source.one_of(["true", "false"]);
        self.set("parameters.lateral_force", lateral);
        if self.source.chance(0.3) {
            let [displacement, velocity] = [self.source.signed(1e-7, 3e-2), self.source.signed(1e-5, 10.0)];
            self.set_number("initial.displacement_m", displacement);
            self.set_number("initial.velocity_m_per_s", velocity);
        }
        self.start_charge();
        self.load();
        self.excitation(18.373, [1e-2, 1e3]);
        self.case("sliding")
    }

    fn bump_stop(mut self) -> Case {
        let scene = self.source.one_of(BUMP_STOP_SCENES);
        self.spread(BUMP_STOP);
        let beam_modes = self.source.one_of([1, 2, 3, 4, 4, 7, 10, 20]);
        self.set("parameters.beam_modes", beam_modes.to_string());
        let damping = self.source.logarithmic(1e-4, 0.9);
        self.set_number("parameters.damping_ratio", damping);
        let coupling = self.source.one_of(["two-way", "two-way", "one-way"]);
        self.set("parameters.coupling", coupling);
        if scene != "bump-stop-none" {
            self.stop();
        }
        if self.source.chance(0.3) {
            let voltage = self.source.signed(1e-6, 1e4);
            self.set_number("initial.voltage_v", voltage);
        }
        self.load();
        self.excitation(240.0, [1e-3, 1e3]);
        self.case(scene)
    }

    fn stop(&mut self) {
        self.spread(STOP);
        let gap = self.source.logarithmic(1e-8, 1e-3);
        let gap = self.source.one_of([0.0, gap]);
        self.set_number("stop.gap_m", gap);
        let rod_modes = self.source.one_of([0, 1, 1, 2, 2, 5, 10, 20]);
        self.set("stop.rod_modes", rod_modes.to_string());
        match self.source.uniform(0.0, 1.0) {
            ..0.25 => {
                let restitution = self.source.uniform(0.0, 1.0);
                self.set("stop.contact", "restitution");
                self.set_number("stop.restitution", restitution);
            }
            ..0.35 => self.set("stop.contact", "displacement-constraint"),
            ..0.6 => {
                let compliance = self.source.logarithmic(1e-9, 1e-2);
                self.set_number("stop.contact_compliance_m_per_n", compliance);
            }
            _ => {}
        }
    }

    /// What both triboelectric scenes have.
    fn triboelectric(&mut self) {
        let damping = self.source.logarithmic(1e-4, 10.0);
        let [charge, field] = FORCE_LAWS;
        let law = self.source.one_of([charge, field, charge, field, "none"]);
        let charge = self.source.one_of(["frozen", "relaxing"]);
        self.set_number("parameters.damping_ratio", damping);
        self.set("parameters.force_law", law);
        self.set("parameters.stick_charge", charge);
    }

    fn start_charge(&mut self) {
        if self.source.chance(0.3) {
            let charge = self.source.signed(1e-14, 1e-6);
            self.set_number("initial.charge_c", charge);
        }
    }

    /// Multiplies each number of a table by a power of ten up to the spread of the case.
    fn spread(&mut self, drawn: Drawn) {
        let spread = self.source.one_of(SPREADS);
        if spread > 0.0 {
            self.multiply(drawn, spread);
        }
    }

    /// Multiplies each number of a table by a power of ten up to `spread`.
    fn multiply(&mut self, [scene, table, keys]: Drawn, spread: f64) {
        for key in keys.split(' ').map(|key| format!("{table}.{key}")) {
            let factor = 10.0_f64.powf(self.source.uniform(-spread, spread));
            let value = number_at(&shipped(scene), &[], &key);
            // A scene that cannot be read is refused where the case is run.
            if let (Ok(Some(value)), Some(Value::Number(bounds))) =
                (value, rows_of(&key).first().map(|row| row.value))
            {
                self.set_number(&key, (value * factor).clamp(bounds.lowest, bounds.highest));
            }
        }
    }

    fn load(&mut self) {
        match self.source.uniform(0.0, 1.0) {
            ..0.02 => self.set("load.resistance_ohm", "0"),
            ..0.5 => {
                let resistance = self.source.logarithmic(1e-3, 1e12);
                self.set_number("load.resistance_ohm", resistance);
            }
            ..0.8 => self.store(),
            _ => {
                let voltage = text(self.source.logarithmic(1e-3, 1e3));
                let drop = text(self.source.one_of([0.0, 0.3]));
                self.set("load", format!("{{kind=\"dc-bus\",voltage_v={voltage},diode_drop_v={drop}}}"));
            }
        }
    }

    fn store(&mut self) {
        let capacitance = text(self.source.logarithmic(1e-12, 1e-3));
        let initial = self.source.logarithmic(1e-3, 1e2);
        let initial = text(self.source.one_of([0.0, initial]));
        let drop = text(self.source.one_of([0.0, 0.3]));
        let leakage = match self.source.one_of([true, false]) {
            true => "inf".to_owned(),
            false => text(self.source.logarithmic(1e3, 1e12)),
        };
        let draw = match self.source.uniform(0.0, 1.0) {
            ..0.6 => String::new(),
            ..0.75 => {
                let resistance = text(self.source.logarithmic(1e3, 1e12));
                format!(",draw={{kind=\"resistor\",value={resistance}}}")
            }
            kind => {
                let kind = if kind < 0.9 { "power" } else { "current" };
                let value = text(self.source.logarithmic(1e-12, 1e-3));
                let on = self.source.logarithmic(1e-2, 1e2);
                let off = text(on * self.source.uniform(0.3, 0.99));
                let on = text(on);
                format!(",draw={{kind=\"{kind}\",value={value},turn_on_v={on},turn_off_v={off}}}")
            }
        };
        self.set(
            "load",
            format!(
                "{{kind=\"rectified-store\",capacitance_f={capacitance},initial_v={initial},diode_drop_v={drop},\
                 leakage_ohm={leakage}{draw}}}"
            ),
        );
    }

    /// What shakes the base, and 10 to 20 of its periods, about a harvester of this natural frequency in Hz in the
    /// shipped scene. Accelerations are drawn within `range`, in m/s².
    fn excitation(&mut self, natural_hz: f64, range: [f64; 2]) {
        let near = natural_hz * self.source.logarithmic(0.3, 3.0);
        let any = self.source.logarithmic(natural_hz / 20.0, 1e5);
        let frequency = self.source.one_of([near, near, any]);
        let periods = self.source.uniform(10.0, 20.0);
        let at_least = self.source.one_of([0.0, 3.0 / natural_hz]);
        let most_s = 30.0 / natural_hz;
        let duration = (periods / frequency).max(at_least).min(most_s);
        let amplitude = text(self.source.logarithmic(range[0], range[1]));
        match self.source.uniform(0.0, 1.0) {
            ..0.55 => {
                let phase = text(self.source.uniform(-3.0, 3.0));
                let frequency = text(frequency);
                self.set(
                    "excitation",
                    format!("{{kind=\"sine\",amplitude_m_per_s2={amplitude},frequency_hz={frequency},phase_rad={phase}}}"),
                );
            }
            ..0.7 => {
                let tones: Vec<String> = [frequency, frequency * self.source.logarithmic(0.1, 10.0)]
                    .map(|frequency| {
                        format!("{{amplitude_m_per_s2={amplitude},frequency_hz={}}}", text(frequency))
                    })
                    .to_vec();
                self.set("excitation", format!("{{kind=\"sines\",tones=[{}]}}", tones.join(",")));
            }
            ..0.9 => {
                let rate = text(self.source.logarithmic(100.0, 1e5));
                self.set(
                    "excitation",
                    format!(
                        "{{kind=\"file\",path=\"noise.csv\",column=1,rate_hz={rate},scale_m_per_s2={amplitude},repeat=true}}"
                    ),
                );
            }
            _ => self.set("excitation", "{kind=\"silence\"}"),
        }
        let settle = duration * self.source.one_of([0.0, 0.3]);
        self.set("run", format!("{{duration_s={},settle_s={}}}", text(duration), text(settle)));
    }
}

/// A number in four digits, as a scene file has it.
fn text(value: f64) -> String {
    format!("{value:.3e}")
}

/// The value of [`text`].
fn rounded(value: f64) -> f64 {
    text(value).parse().unwrap_or(value)
}

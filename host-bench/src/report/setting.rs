//! The parameters of a scene in a few words, for the title of a picture; keys as titles of axes; numbers with a prefix of their unit.

use super::chart::Axis;
use super::svg::decimal;
use crate::outcome::Margins;
use crate::scene_file::{Excitation, Load, Scene, rows_of};

/// Prefixes of units and their powers of a thousand.
const PREFIXES: [(&str, i32); 9] =
    [("p", -4), ("n", -3), ("µ", -2), ("m", -1), ("", 0), ("k", 1), ("M", 2), ("G", 3), ("T", 4)];

/// The prefix of a unit, and the factor to it, with which the magnitude is from 1 to 1000.
pub(crate) fn prefix(magnitude: f64) -> (&'static str, f64) {
    if !(magnitude > 0.0 && magnitude.is_finite()) {
        return ("", 1.0);
    }
    // A magnitude that is a thousand but for rounding has the next prefix.
    let power = ((magnitude.log10() + 1e-9) / 3.0).floor().clamp(-4.0, 4.0) as i32;
    let found = PREFIXES.iter().find(|(_, other)| *other == power);
    found.map_or(("", 1.0), |(name, power)| (*name, 1000f64.powi(-power)))
}

/// A quantity with the prefix of its unit for the largest magnitude of its values, and the factor to it; without a unit neither.
pub(crate) fn scaled(word: &str, unit: &str, values: impl Iterator<Item = f64>) -> (String, f64) {
    let largest =
        values.filter(|value| value.is_finite()).fold(0.0, |most: f64, value| most.max(value.abs()));
    let (prefix, factor) = prefix(largest);
    if unit.is_empty() { (word.to_owned(), 1.0) } else { (format!("{word} [{prefix}{unit}]"), factor) }
}

/// A value with its unit, such as 100 MΩ; a value without a magnitude has the unit alone.
pub(crate) fn with_unit(value: f64, unit: &str) -> String {
    let (prefix, factor) = prefix(value.abs());
    format!("{} {prefix}{unit}", decimal(value * factor, 4))
}

/// The axis of a key between two values, and the factor to the unit that it shows. A logarithmic one has powers of ten of the key's own.
pub(crate) fn axis_of(key: &str, is_logarithmic: bool, ends: [f64; 2]) -> (Axis, f64) {
    let (words, unit) = words_and_unit(key);
    let has_prefix = !is_logarithmic && ["m", "s", "V", "A", "F", "Ω", "Hz"].contains(&unit.as_str());
    let (title, factor) =
        if has_prefix { scaled(&words, &unit, ends.into_iter()) } else { (label(key), 1.0) };
    (Axis::scaled(is_logarithmic, title, ends.map(|end| factor * end)), factor)
}

/// Values with their unit and as many digits, from three on, as leave each within a tenth of its distance to the next one.
pub(crate) fn distinct_labels(values: &[f64], unit: &str) -> Vec<String> {
    let text = |value: &f64, digits: usize| {
        let (text, shown) = rounded(*value, unit, digits);
        let distances = values.iter().map(|other| (other - value).abs()).filter(|distance| *distance > 0.0);
        (text, (shown - value).abs() > 0.1 * distances.fold(f64::INFINITY, f64::min))
    };
    let texts = |digits: usize| values.iter().map(|value| text(value, digits)).unzip();
    let is_near = |(_, off): &(Vec<String>, Vec<bool>)| !off.contains(&true);
    (3..17).map(texts).find(is_near).unwrap_or_else(|| texts(17)).0
}

/// A value that a user gave, with its unit and all its digits.
pub(crate) fn exact_label(value: f64, unit: &str) -> String {
    rounded(value, unit, 15).0
}

/// A value with so many digits and its unit, and the value that this text has.
fn rounded(value: f64, unit: &str, digits: usize) -> (String, f64) {
    // The prefix of a power, or of a kilogram, would be that of another unit.
    let has_prefix =
        !unit.is_empty() && !["m²", "m³", "kg", "g", "s²"].iter().any(|other| unit.starts_with(other));
    let (prefix, factor) = if has_prefix { prefix(value.abs()) } else { ("", 1.0) };
    let rounded: f64 = format!("{:.*e}", digits - 1, value * factor).parse().unwrap_or(value * factor);
    let plain = rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs());
    let number = if plain { rounded.to_string() } else { format!("{rounded:e}") };
    (format!("{number} {prefix}{unit}").trim_end().to_owned(), rounded / factor)
}

/// The smallest of some margins to limits of a model by their names, for the title of a picture after other text; empty for none.
pub(crate) fn margin<'a>(all: impl IntoIterator<Item = (&'a str, Option<f64>)>) -> String {
    let known = all.into_iter().filter_map(|(name, margin)| Some((margin?, name)));
    let smallest = known.min_by(|one, other| one.0.total_cmp(&other.0));
    smallest.map_or_else(String::new, |(margin, name)| {
        format!("; smallest margin to a limit {margin:.3} ({name})")
    })
}

/// The margins of a run by their names.
pub(crate) fn named(margins: &Margins) -> impl Iterator<Item = (&'static str, Option<f64>)> {
    margins.limits.iter().map(|limit| (limit.name, limit.margin))
}

/// The parameters of a scene that a picture should name, without those of these keys.
pub(crate) fn setting(scene: &Scene, without: &[&str]) -> String {
    let mut parts: Vec<(&str, String)> = Vec::new();
    let stop = scene.bump_stop().ok().and_then(|model| model.stop.as_ref());
    parts.push(match (scene.model.summary().charge_density_c_per_m2, stop) {
        (Some(density), _) => ("parameters.charge_density_c_per_m2", with_unit(density, "C/m²")),
        (None, Some(stop)) => ("stop.gap_m", format!("gap {}", with_unit(stop.gap_m, "m"))),
        (None, None) => ("stop", "no stop".to_owned()),
    });
    parts.push(match scene.load {
        Load::Resistor { resistance_ohm } if resistance_ohm.is_infinite() => {
            ("load.resistance_ohm", "open circuit".to_owned())
        }
        Load::Resistor { resistance_ohm } => ("load.resistance_ohm", with_unit(resistance_ohm, "Ω")),
        Load::RectifiedStore(store) => {
            ("load.capacitance_f", format!("bridge into {}", with_unit(store.capacitance_f, "F")))
        }
        Load::DcBus { voltage_v, .. } => ("load.voltage_v", format!("bus of {}", with_unit(voltage_v, "V"))),
    });
    let amplitude = |value: f64| ("excitation.amplitude", format!("{} m/s²", decimal(value, 4)));
    match &scene.excitation {
        Excitation::Sine(tone) => {
            parts.push(amplitude(tone.amplitude_m_per_s2));
            parts.push(("excitation.frequency_hz", format!("{} Hz", decimal(tone.frequency_hz, 4))));
        }
        Excitation::Sines(tones) => parts.push(("excitation", format!("{} sines", tones.len()))),
        Excitation::File(_) => parts.push(("excitation", "recorded base".to_owned())),
        Excitation::Burst(burst) => parts.push(amplitude(burst.amplitude_m_per_s2)),
        Excitation::Sweep(sweep) => {
            parts.push(amplitude(sweep.amplitude_m_per_s2));
            let span = format!("{} to {} Hz", decimal(sweep.from_hz, 4), decimal(sweep.to_hz, 4));
            parts.push(("excitation.from_hz", span));
        }
        Excitation::Random(random) => {
            parts.push(("excitation", format!("random, {} m/s² RMS", decimal(random.rms_m_per_s2(), 4))));
        }
        Excitation::Silence => parts.push(("excitation", "base at rest".to_owned())),
    }
    let shown = parts.iter().filter(|(key, _)| !without.iter().any(|other| other.starts_with(key)));
    shown.map(|(_, text)| text.as_str()).collect::<Vec<_>>().join(", ")
}

/// A [`label`] as its words and its unit, which may be empty.
pub(crate) fn words_and_unit(key: &str) -> (String, String) {
    let label = label(key);
    let parts = label.strip_suffix(']').and_then(|text| text.split_once(" ["));
    parts.map_or_else(|| (label.clone(), String::new()), |(words, unit)| (words.to_owned(), unit.to_owned()))
}

/// Table whose name says nothing of its keys.
const PLAIN: &str = "parameters";

/// A key such as `load.resistance_ohm` in words with its unit: `load resistance [Ω]`. The key itself where it has no unit of its own.
pub(crate) fn label(key: &str) -> String {
    let rows = rows_of(key);
    // A key whose unit depends on the kind of its table has none.
    let Some(unit) = rows.first().map(|row| row.unit).filter(|unit| rows.iter().all(|row| row.unit == *unit))
    else {
        return key.to_owned();
    };
    let words: Vec<&str> =
        key.split('.').filter(|part| *part != PLAIN && part.parse::<usize>().is_err()).collect();
    let words = words.join(" ");
    let words = words.strip_suffix(&format!("_{}", written(unit))).unwrap_or(&words).replace('_', " ");
    if unit.is_empty() || unit == "1" { words } else { format!("{words} [{unit}]") }
}

/// A number of a result such as `mean_power_w`, or a column of a recording, in words, and its unit; empty where it has none.
pub(crate) fn number_and_unit(name: &str) -> (String, &'static str) {
    let units = ["m/s²", "m/s", "1/m", "Hz", "Pa", "W", "V", "J", "A", "N", "C", "F", "Ω", "m", "s"];
    let mut found = units.iter().filter_map(|unit| {
        let end = format!("_{}", written(unit));
        Some((name.strip_suffix(end.replace("_1_per", "_per").as_str())?, *unit))
    });
    let (words, unit) = found.next().unwrap_or((name, ""));
    (words.replace('_', " "), unit)
}

/// A unit as the name of a key ends with it: `m_per_s2` for m/s².
fn written(unit: &str) -> String {
    let mut text = String::new();
    for letter in unit.to_lowercase().chars() {
        match letter {
            '/' => text.push_str("_per_"),
            '²' => text.push('2'),
            '³' => text.push('3'),
            // The lower case of the ohm sign.
            'ω' => text.push_str("ohm"),
            other => text.push(other),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file;

    #[test]
    fn a_unit_has_the_prefix_of_its_magnitude() {
        for (value, expected) in [
            (1.17487e-5, "11.7487 µW"),
            (0.0, "0 W"),
            (1e-3, "1 mW"),
            (999.0, "999 W"),
            (-2.5e3, "-2.5 kW"),
            (1e-15, "0.001 pW"),
        ] {
            assert_eq!(with_unit(value, "W"), expected);
        }
        assert_eq!(with_unit(1e8, "Ω"), "100 MΩ");
    }

    #[test]
    fn labels_of_different_values_differ() {
        assert_eq!(distinct_labels(&[0.0325, 0.033, 0.0335], "m"), ["32.5 mm", "33 mm", "33.5 mm"]);
        assert_eq!(distinct_labels(&[19.0, 19.25, 19.5], "Hz"), ["19 Hz", "19.25 Hz", "19.5 Hz"]);
        assert_eq!(distinct_labels(&[1.0, 1.00001, 1.00001], "Hz"), ["1 Hz", "1.00001 Hz", "1.00001 Hz"]);
        assert_eq!(distinct_labels(&[1e3, 1e6, 0.0, f64::INFINITY], "Ω"), ["1 kΩ", "1 MΩ", "0 Ω", "inf Ω"]);
        assert_eq!(distinct_labels(&[2e-3, 4e-8], "kg"), ["0.002 kg", "4e-8 kg"]);
        assert_eq!(distinct_labels(&[0.5], ""), ["0.5"]);
        let exact = [(12345.0, ""), (19.37, "Hz"), (12_345_678.0, "Ω"), (1e-5, "m"), (0.1 + 0.2, "V")];
        let exact = exact.map(|(value, unit)| exact_label(value, unit));
        assert_eq!(exact, ["12345", "19.37 Hz", "12.345678 MΩ", "10 µm", "300 mV"]);
        assert_eq!(words_and_unit("parameters.beam_length_m"), ("beam length".to_owned(), "m".to_owned()));
        for (name, expected) in [
            ("mean_power_w", ("mean power", "W")),
            ("max_impact_speed_m_per_s", ("max impact speed", "m/s")),
            ("impacts", ("impacts", "")),
        ] {
            assert_eq!(number_and_unit(name), (expected.0.to_owned(), expected.1));
        }
        assert_eq!(words_and_unit("parameters.damping_ratio"), ("damping ratio".to_owned(), String::new()));
    }

    #[test]
    fn a_title_names_the_parameters_that_are_not_on_an_axis() {
        let read = |name: &str, sets: &[(&str, &str)]| scene_file::read_shipped(name, sets).expect("valid");
        let scene = read("contact-separation-passive", &[]);
        assert_eq!(setting(&scene, &[]), "50 µC/m², 100 MΩ, 1.962 m/s², 20.5 Hz");
        assert_eq!(setting(&scene, &["excitation.frequency_hz"]), "50 µC/m², 100 MΩ, 1.962 m/s²");
        assert_eq!(setting(&scene, &["excitation.amplitude_g", "load.resistance_ohm"]), "50 µC/m², 20.5 Hz");
        assert_eq!(setting(&read("bump-stop", &[]), &[]), "gap 10 µm, 1 MΩ, 20 m/s², 220 Hz");
        assert_eq!(
            setting(&read("bump-stop-none", &[("load.resistance_ohm", "inf")]), &[]),
            "no stop, open circuit, 20 m/s², 220 Hz"
        );
    }

    #[test]
    fn a_key_is_words_and_a_unit() {
        for (key, expected) in [
            ("load.resistance_ohm", "load resistance [Ω]"),
            ("excitation.frequency_hz", "excitation frequency [Hz]"),
            ("excitation.amplitude_m_per_s2", "excitation amplitude [m/s²]"),
            ("excitation.tones.0.frequency_hz", "excitation tones frequency [Hz]"),
            ("parameters.charge_density_c_per_m2", "charge density [C/m²]"),
            ("parameters.damping_ratio", "damping ratio"),
            ("parameters.restitution.coefficient", "restitution coefficient"),
            ("stop.contact_compliance_m_per_n", "stop contact compliance [m/N]"),
            // In ohms, amperes or watts.
            ("load.draw.value", "load.draw.value"),
            ("no.key", "no.key"),
        ] {
            assert_eq!(label(key), expected);
        }
    }
}

//! A key of a scene as the title of an axis.

use crate::scene_file::unit_of;

/// Table whose name says nothing of its keys.
const PLAIN: &str = "parameters";

/// A key such as `load.resistance_ohm` in words with its unit: `load resistance [Ω]`. The key itself where it has no unit of
/// its own.
pub(crate) fn label(key: &str) -> String {
    let Some(unit) = unit_of(key) else { return key.to_owned() };
    let words: Vec<&str> =
        key.split('.').filter(|part| *part != PLAIN && part.parse::<usize>().is_err()).collect();
    let words = words.join(" ");
    let words = words.strip_suffix(&format!("_{}", written(unit))).unwrap_or(&words).replace('_', " ");
    if unit.is_empty() || unit == "1" { words } else { format!("{words} [{unit}]") }
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

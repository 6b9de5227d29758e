//! Metamorphic twins of a run: numbers that do not change where a scene is stated in other units, or where its window is split.

use toml_edit::{DocumentMut, Value};

use super::Case;
use crate::fit::fitted_scene;
use crate::method::Options;
use crate::run::run_scene;
use crate::scene_file::{Override, Scene, shipped};

/// Power of a [`rescaled`] case over that of the case.
pub(super) const POWER: f64 = 8.0;

/// The same case with masses and lengths in a quarter of their units, times in half, and charges in an eighth. The numbers of
/// gravity and of the permittivity of a vacuum, which are no keys, are the same in these units.
///
/// `None` if the case has a text that is not TOML.
pub(super) fn rescaled(case: &Case) -> Option<Case> {
    let changes = case.changes.iter().map(|(key, text)| Override::new(key, text));
    let text = fitted_scene(&shipped(case.scene), &changes.collect::<Vec<_>>(), &[], false).ok()?;
    let document: DocumentMut = text.parse().ok()?;
    let tables = document.iter().filter(|(key, _)| *key != "scene");
    let changes = tables.filter_map(|(key, item)| {
        let mut value = item.clone().into_value().ok()?;
        rescale(key, &mut value);
        Some((key.to_owned(), value.to_string().trim().to_owned()))
    });
    Some(Case { changes: changes.collect(), step_s: case.step_s.map(|step_s| 2.0 * step_s), ..case.clone() })
}

/// Multiplies each number in a value at `key` by the factor of its unit.
fn rescale(key: &str, value: &mut Value) {
    let kind = value.as_inline_table().and_then(|table| table.get("kind")?.as_str()).map(str::to_owned);
    match value {
        Value::InlineTable(table) => {
            for (name, inner) in table.iter_mut() {
                // The unit of the value of a draw is that of its kind.
                let name = match (name.get(), kind.as_deref()) {
                    ("value", Some("resistor")) => "value_ohm",
                    ("value", Some("power")) => "value_w",
                    ("value", Some("current")) => "value_a",
                    (name, _) => name,
                }
                .to_owned();
                rescale(&name, inner);
            }
        }
        Value::Array(list) if key.starts_with("spectral_density") => {
            for point in list.iter_mut().filter_map(Value::as_array_mut) {
                for (index, factor) in [0.5, 2.0].into_iter().enumerate() {
                    point.get_mut(index).into_iter().for_each(|number| multiply(number, factor));
                }
            }
        }
        Value::Array(list) => list.iter_mut().for_each(|inner| rescale(key, inner)),
        number => multiply(number, factor(key)),
    }
}

fn multiply(value: &mut Value, factor: f64) {
    let number = value.as_float().or(value.as_integer().map(|whole| whole as f64));
    if factor != 1.0
        && let Some(number) = number
    {
        *value = Value::from(number * factor);
    }
}

/// The new number of a quantity over its old one, by the unit that ends its key. Longer units stand first.
fn factor(key: &str) -> f64 {
    let units = [
        ("_kg_per_m3", 1.0 / 16.0),
        ("_kg_m2", 64.0),
        ("_kg", 4.0),
        ("_m_per_s2", 1.0),
        ("_m_per_s", 2.0),
        ("_n_per_m", 1.0),
        ("_m_per_n", 1.0),
        ("_m_per_v", 2.0),
        ("_f_per_m", 1.0),
        ("_c_per_m2", 0.5),
        ("_m2", 16.0),
        ("_m", 4.0),
        ("_pa", 0.25),
        ("_hz", 0.5),
        ("_s", 2.0),
        ("_c", 8.0),
        ("_f", 4.0),
        ("_v", 2.0),
        ("_ohm", 0.5),
        ("_w", POWER),
        ("_a", 4.0),
    ];
    units.into_iter().find(|(unit, _)| key.ends_with(unit)).map_or(1.0, |(_, factor)| factor)
}

/// The relative error of the sum of the energies delivered in both halves of the window of a scene, in which a run by the
/// same options delivered `energy_j`; `None` if a half cannot be run.
pub(super) fn split_error(scene: &Scene, options: &Options, energy_j: f64) -> Option<f64> {
    let [first, second] =
        halves(scene).map(|half| run_scene(&half, options).ok().and_then(|run| run.delivered_energy_j));
    Some(((first? + second? - energy_j) / energy_j).abs())
}

/// The scene over the first and over the second half of its window.
pub(super) fn halves(scene: &Scene) -> [Scene; 2] {
    let run = scene.run;
    let middle_s = 0.5 * (run.settle_s + run.duration_s);
    [(run.settle_s, middle_s), (middle_s, run.duration_s)].map(|(settle_s, duration_s)| {
        let mut half = scene.clone();
        (half.run.settle_s, half.run.duration_s) = (settle_s, duration_s);
        half
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Precision;
    use crate::stability::draw_varied;

    #[test]
    fn numbers_are_rescaled_by_their_units_and_so_is_the_power() {
        let changes = ["load={kind=\"dc-bus\",voltage_v=2,diode_drop_v=0.3}", "initial.velocity_m_per_s=0.1"];
        for (scene, changes) in [("contact-separation", &changes[..]), ("sliding", &[]), ("bump-stop", &[])] {
            let run = if scene == "bump-stop" { "run.duration_s=0.01" } else { "run.duration_s=0.5" };
            let changes = [changes, &[run, "run.settle_s=0"]].concat();
            let case = Case::of(scene, &changes, Precision::F64);
            let twin = rescaled(&case).expect("a twin");
            let [one, two] = [&case, &twin].map(|case| case.read().expect("a scene"));
            assert_eq!(two.run.duration_s, 2.0 * one.run.duration_s);
            let power = |scene: &Scene, step_s: f64| {
                let options = Options { step_s: Some(step_s), ..case.options() };
                run_scene(scene, &options).expect("a run").mean_power_w.expect("a power")
            };
            // Instants of events are rounded to ticks, which are not rescaled.
            let step_s = 2.0_f64.powi(-18);
            let [one, two] = [power(&one, step_s), power(&two, 2.0 * step_s)];
            assert!((two / (POWER * one) - 1.0).abs() < 1e-6, "{scene}: {one} {two}");
        }
    }

    /// A case of each excitation of the features, of the scene whose runs are short.
    #[test]
    fn the_power_of_a_featured_case_is_rescaled() {
        for kind in ["random", "sines", "sweep", "bursts"] {
            let is_of = |case: &Case| {
                let is_short = case.scene == "contact-separation" && case.precision == Precision::F64;
                let has = |(key, text): &(String, String)| key == "excitation" && text.contains(kind);
                is_short && case.changes.len() < 6 && case.changes.iter().any(has)
            };
            let case = (0..).map(|number| draw_varied(5, number)).find(is_of).expect("one of many");
            let power = |case: &Case| {
                let scene = case.read().expect("a scene");
                run_scene(&scene, &case.options()).expect("a run").mean_power_w.expect("a power")
            };
            let [one, two] = [power(&case), power(&rescaled(&case).expect("a twin"))];
            assert!(one > 0.0 && (two / (POWER * one) - 1.0).abs() < 1e-3, "{kind}: {one} {two} {case:?}");
        }
    }

    #[test]
    fn every_varied_case_is_read_and_has_a_twin() {
        let of = |number| draw_varied(5, number);
        let refused = (0..200).filter(|&number| of(number).read().is_err()).count();
        let without = (0..200).filter(|&number| {
            of(number).read().is_ok() && rescaled(&of(number)).is_none_or(|twin| twin.read().is_err())
        });
        assert!(refused < 30, "{refused}");
        let without: Vec<u64> = without.collect();
        // A natural frequency or a mass at the edge of its bounds is beyond it in the other units.
        assert!(without.len() < 12, "{without:?}");
    }
}

//! The grids of stiff and extreme scenes.

mod bump_stop;
mod contact_separation;
mod sliding;

use std::collections::BTreeSet;

use super::Case;
use crate::command::SHIPPED_SCENES;
use crate::method::Precision;

/// Which cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Extent {
    /// All.
    #[default]
    Whole,
    /// Fewer values of each quantity.
    Coarse,
}

impl Extent {
    /// These values, or every `stride`-th of them from the first on.
    fn thinned<T: Copy>(self, values: &[T], stride: usize) -> Vec<T> {
        let stride = if self == Self::Whole { 1 } else { stride };
        values.iter().copied().step_by(stride).collect()
    }
}

/// Of which scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// Contact-separation.
    ContactSeparation,
    /// Sliding.
    Sliding,
    /// Bump-stop.
    BumpStop,
}

impl Kind {
    /// The name of its shipped scene, without ending.
    pub fn scene(self) -> &'static str {
        SHIPPED_SCENES[self as usize]
    }
}

/// The cases of a scene, each in both precisions, one after the other.
pub fn grid(kind: Kind, extent: Extent) -> Vec<Case> {
    let settings = match kind {
        Kind::ContactSeparation => contact_separation::settings(extent),
        Kind::Sliding => sliding::settings(extent),
        Kind::BumpStop => bump_stop::settings(extent),
    };
    // A value of one list may be the middle of another.
    let mut known = BTreeSet::new();
    let distinct = settings.into_iter().filter(|setting| known.insert(setting.arguments()));
    let both =
        |case: Case| [Precision::F32, Precision::F64].map(|precision| Case { precision, ..case.clone() });
    distinct.flat_map(both).collect()
}

/// The shipped scene as a case; its precision is that of no run.
fn shipped(kind: Kind) -> Case {
    Case::of(kind.scene(), &[], Precision::F64)
}

/// Small storages behind the bridge that discharge between two charges, and one of a usual size.
const STORES: [&str; 10] = [
    "capacitance_f=1e-9,leakage_ohm=inf,draw={kind=\"resistor\",value=1e4}",
    "capacitance_f=1e-11,leakage_ohm=inf,draw={kind=\"resistor\",value=1e6}",
    "capacitance_f=1e-12,leakage_ohm=inf,draw={kind=\"resistor\",value=1e4}",
    "capacitance_f=1e-12,leakage_ohm=1e6",
    "capacitance_f=1e-11,leakage_ohm=1e9",
    "capacitance_f=1e-11,leakage_ohm=1e4,draw={kind=\"power\",value=1e-9,turn_on_v=1,turn_off_v=0.5}",
    "capacitance_f=5e-12,leakage_ohm=inf,draw={kind=\"resistor\",value=1e9}",
    "capacitance_f=1e-6,leakage_ohm=1e9,draw={kind=\"power\",value=1e-6,turn_on_v=1,turn_off_v=0.5}",
    "capacitance_f=1e-9,leakage_ohm=inf,draw={kind=\"current\",value=1e-8,turn_on_v=1,turn_off_v=0.5}",
    "capacitance_f=1e-11,leakage_ohm=1e9,draw={kind=\"current\",value=1e-6,turn_on_v=0.6,turn_off_v=0.5}",
];

/// Force laws of the triboelectric grids.
pub(super) const FORCE_LAWS: [&str; 2] = ["transferred-charge", "gap-field"];
/// The law without a force: the motion does not depend on the circuit, so that few cases show it.
const NO_FORCE: &str = "none";

/// Each case with each of these values of a key; the first key varies slowest.
fn each_number(cases: &[Case], key: &str, values: &[f64]) -> Vec<Case> {
    cases.iter().flat_map(|case| values.iter().map(|value| case.clone().with_number(key, *value))).collect()
}

/// Each case with each of these words of a key.
fn each_word(cases: &[Case], key: &str, words: &[&str]) -> Vec<Case> {
    cases.iter().flat_map(|case| words.iter().map(|word| case.clone().with(key, word))).collect()
}

/// Each case under both force laws.
fn each_law(cases: &[Case]) -> Vec<Case> {
    each_word(cases, "parameters.force_law", &FORCE_LAWS)
}

/// Charges at the start that small loads take up within nanoseconds, in a triboelectric scene.
fn start_charges(base: &Case) -> Vec<Case> {
    let charged = each_number(std::slice::from_ref(base), "initial.charge_c", &[1e-8, -1e-9]);
    let cases = each_law(&each_number(&charged, "load.resistance_ohm", &[0.1, 10.0, 1e3, 1e6]));
    // The charge is delivered at the start, which the window contains.
    each_word(&cases, "run", &["{duration_periods=16,settle_periods=0}"])
}

/// The scene with each of these storages, with and without a start voltage.
fn stores(base: &Case) -> Vec<Case> {
    let of = |store: &str, drop: f64, initial: f64| {
        let load = format!("{{kind=\"rectified-store\",diode_drop_v={drop},initial_v={initial},{store}}}");
        base.clone().with("load", load)
    };
    STORES.iter().flat_map(|store| [of(store, 0.3, 0.0), of(store, 0.0, 1.0)]).collect()
}

/// The excitation by the shipped trace at a rate in Hz.
fn noise(base: &Case, rate_hz: f64, scale_m_per_s2: f64) -> Case {
    let trace = format!(
        "{{kind=\"file\",path=\"noise.csv\",column=1,rate_hz={rate_hz:e},scale_m_per_s2={scale_m_per_s2:e},repeat=true}}"
    );
    base.clone().with("excitation", trace)
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum as _;

    use super::*;

    fn all(extent: Extent) -> Vec<Case> {
        Kind::value_variants().iter().flat_map(|kind| grid(*kind, extent)).collect()
    }

    #[test]
    fn every_case_is_read_and_comes_in_both_precisions_once() {
        let cases = all(Extent::Coarse);
        for pair in cases.chunks(2) {
            let [single, double] = pair else { panic!("an odd number of cases") };
            assert!(single.is_twin_of(double), "{}", single.arguments());
            assert_eq!([single.precision, double.precision], [Precision::F32, Precision::F64]);
            assert!(single.read().is_ok(), "{:?}: {}", single.read(), single.arguments());
        }
        let different: BTreeSet<String> = cases.iter().map(Case::arguments).collect();
        assert_eq!(different.len(), cases.len());
    }

    #[test]
    fn the_coarse_grid_is_a_part_of_the_whole() {
        let whole: BTreeSet<String> = all(Extent::Whole).iter().map(Case::arguments).collect();
        let coarse = all(Extent::Coarse);
        let outside: Vec<String> =
            coarse.iter().map(Case::arguments).filter(|arguments| !whole.contains(arguments)).collect();
        assert_eq!(outside, Vec::<String>::new());
        assert!(whole.len() > 3 * coarse.len(), "{} of {}", coarse.len(), whole.len());
    }
}

//! Scene files: TOML with SI values in named fields, read into plain checked numbers.
//!
//! Every key must be known, every number within its bounds; what is wrong is reported in one line with file, line, key, value and
//! bound. Overrides (`--set a.b=c`) are put into the document before it is read, so they meet the same checks.

mod bump_stop;
mod contact_separation;
mod document;
mod excitation;
mod fit;
pub mod key;
mod limits;
mod load;
pub mod modes;
mod node;
mod overrides;
mod run_span;
mod scene;
mod section;
mod sliding;
mod template;
mod trace;
mod triboelectric;

use std::io;
use std::path::{Path, PathBuf};

use self::document::Document;
pub use self::document::{SceneError, nearest};
pub use self::fit::Fit;
use self::key::{Key, Kind, Table, Value, other};
pub(crate) use self::limits::of_name as limit_of_name;
pub use self::limits::{breakdown_voltage_v, fringing};
pub use self::overrides::{Override, contains, finite_number_in, finite_number_of, replaces};
pub use self::scene::*;
use self::section::{Reader, Section};
pub use self::template::{TEMPLATES, template};
pub use self::trace::number::{Delimiter, Numbers};
pub use self::trace::resample;
/// Acceleration of gravity in m/s²: the factor of `amplitude_g`.
pub use model_core::part::GRAVITY;

/// All keys of a scene file.
pub static KEYS: Table = Table {
    selector: "scene",
    kinds: &[&contact_separation::KIND, &sliding::KIND, &bump_stop::KIND],
    keys: &[
        other("load", Value::Table(&load::TABLE), "What is connected to the harvester"),
        other("excitation", Value::Table(&excitation::TABLE), "The acceleration of the base"),
        other("run", Value::Table(&run_span::TABLE), "How long to simulate, and from when to measure"),
        other("node", Value::Table(&node::TABLE), "A sensor node, for the command budget").or_said("none"),
        other("fit", Value::Table(&fit::TABLE), "Measurements and free keys, for the command fit")
            .or_said("none"),
    ],
};

/// What is said of any harvester. Its coordinate is the gap, or the displacement of the slider or the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// The name that a scene file gives the scene.
    pub name: &'static str,
    /// Coordinate at rest in m.
    pub rest_m: f64,
    /// Length in m of a motion: the initial gap, the radius of a patch, or the gap to the stop; 0 without a stop.
    pub length_m: f64,
    /// Least and largest coordinate in m of a start.
    pub range_m: [f64; 2],
    /// Coordinate in m, velocity in m/s, charge in C at the start where given; `None` for bump-stop, which has modes.
    pub start: Option<[Option<f64>; 3]>,
    /// Key of the coordinate at the start.
    pub start_key: &'static str,
    /// What the natural frequency depends on.
    pub frequency_keys: &'static str,
    /// Damping ratio of each mode.
    pub damping_ratio: f64,
    /// Tribo-charge density in C/m²; `None` for a piezoelectric harvester.
    pub charge_density_c_per_m2: Option<f64>,
    /// A value of a key that does not conserve the energy, and the one that does; `None` where it is conserved.
    pub not_conserved: Option<[&'static str; 2]>,
}

/// What the natural frequency of a beam depends on.
const BEAM_KEYS: &str = "the beam's dimensions, density and young_modulus_pa";

/// Reads and checks a scene file, with `overrides` put in first, in their order.
///
/// # Errors
/// The first thing that is wrong, in one line.
pub fn read(file: &Path, overrides: &[Override]) -> Result<Scene, SceneError> {
    read_all(file, overrides, &|_| 1.0).map(|(scene, ..)| scene)
}

/// As [`read`], for a file that has a node.
///
/// # Errors
/// As [`read`], and if there is no `[node]`.
pub fn read_with_node(file: &Path, overrides: &[Override]) -> Result<(Scene, Node), SceneError> {
    let (scene, node, _) = read_all(file, overrides, &|_| 1.0)?;
    let absent = || SceneError::of_absent(file, "node", "is missing; must be a table");
    node.map(|node| (scene, node)).ok_or_else(absent)
}

/// As [`read`], with what the file says about a fit.
///
/// # Errors
/// As [`read`].
pub fn read_with_fit(file: &Path, overrides: &[Override]) -> Result<(Scene, Fit), SceneError> {
    read_all(file, overrides, &|_| 1.0).map(|(scene, _, fit)| (scene, fit))
}

/// The number at a key of a scene file, such as `load.resistance_ohm`; `None` if the key is not there.
///
/// # Errors
/// If the file cannot be read, or the key leads to something else than a number.
pub fn number_at(file: &Path, overrides: &[Override], key: &str) -> Result<Option<f64>, SceneError> {
    let document = Document::read(file, overrides)?;
    match document.at(key) {
        None => Ok(None),
        Some(node) => {
            let refused = || SceneError::of_value(file, key, node, "must be a number");
            node.content.number().map(Some).ok_or_else(refused)
        }
    }
}

/// The rows of a key such as `load.resistance_ohm`, one for each kind of its table that has it.
pub fn rows_of(key: &str) -> Vec<&'static Key> {
    let mut rows = Vec::new();
    add_rows(&KEYS, key, &mut rows);
    rows
}

fn add_rows(table: &'static Table, key: &str, rows: &mut Vec<&'static Key>) {
    let (name, rest) = key.split_once('.').map_or((key, None), |(name, rest)| (name, Some(rest)));
    let of_kinds = table.kinds.iter().flat_map(|kind| kind.keys);
    for key in of_kinds.chain(table.keys).filter(|key| key.name == name) {
        match (key.value, rest) {
            (_, None) => rows.push(key),
            (Value::Table(inner), Some(rest)) => add_rows(inner, rest, rows),
            // A number stands before the key of one of several tables.
            (Value::Tables(inner), Some(rest)) => {
                add_rows(inner, rest.split_once('.').map_or("", |(_, rest)| rest), rows);
            }
            _ => {}
        }
    }
}

/// The files that are read for a scene: the scene file, and the recording that it names.
///
/// # Errors
/// If the scene file cannot be read, or has no `[excitation]`.
pub fn files(file: &Path, overrides: &[Override]) -> Result<Vec<PathBuf>, SceneError> {
    let document = Document::read(file, overrides)?;
    let recording = trace::path(&mut Section::root(&document, &KEYS).table("excitation")?);
    Ok(std::iter::once(file.to_owned()).chain(recording).collect())
}

/// The file as JSON, unchecked; infinity is the largest number, which JSON has in its place.
///
/// # Errors
/// If the file cannot be read or is not TOML.
#[cfg(test)]
pub(crate) fn as_json(file: &Path, overrides: &[Override]) -> Result<serde_json::Value, SceneError> {
    Document::read(file, overrides).map(|document| document.content.as_json())
}

macro_rules! texts {
    ($($name:literal)*) => { [$(($name, include_str!(concat!("../", $name, ".toml")))),*] };
}

/// Name and text of the scene files of this package.
const SHIPPED: [(&str, &str); 17] = texts![
    "bimorph-erturk-inman" "bump-stop" "bump-stop-below-resonance" "bump-stop-below-resonance-charging"
    "bump-stop-below-resonance-mid-span" "bump-stop-below-resonance-none" "bump-stop-mid-span" "bump-stop-none" "bump-stop-tip"
    "bump-stop-tip-mass" "contact-separation" "contact-separation-hosseini" "contact-separation-passive"
    "contact-separation-truck" "node" "rectified" "sliding"
];

/// The path of a scene file in `host-bench/scenes`, by its name without ending. [`read`] has its text where there is no file,
/// as of a program that is installed.
pub fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name).with_extension("toml")
}

/// The text of a path of [`shipped`], as it was when this was built.
pub(crate) fn shipped_text(file: &Path) -> Option<&'static str> {
    SHIPPED.iter().find(|(name, _)| shipped(name) == file).map(|(_, text)| *text)
}

/// The text of a path of [`shipped`] in place of the error that there is no such file.
///
/// # Errors
/// Any other error.
pub fn shipped_instead(file: &Path, error: io::Error) -> io::Result<String> {
    let is_absent = error.kind() == io::ErrorKind::NotFound;
    shipped_text(file).filter(|_| is_absent).map(str::to_owned).ok_or(error)
}

/// The scene of a file in `host-bench/scenes` by its name without ending, with these keys changed.
///
/// # Errors
/// As [`read`].
pub fn read_shipped(name: &str, changes: &[(&str, &str)]) -> Result<Scene, SceneError> {
    read_scaled(name, changes, &|_| 1.0)
}

/// As [`read_shipped`], each number of the changed file times the factor of its key.
///
/// # Errors
/// As [`read`].
pub fn read_scaled(
    name: &str,
    changes: &[(&str, &str)],
    factor: &dyn Fn(&str) -> f64,
) -> Result<Scene, SceneError> {
    let overrides: Vec<Override> = changes.iter().map(|(key, value)| Override::new(key, value)).collect();
    read_all(&shipped(name), &overrides, factor).map(|(scene, ..)| scene)
}

type Read = (Scene, Option<Node>, Fit);

fn read_all(file: &Path, overrides: &[Override], factor: &dyn Fn(&str) -> f64) -> Result<Read, SceneError> {
    let mut document = Document::read(file, overrides)?;
    document.content.scale("", factor);
    let mut root = Section::root(&document, &KEYS);
    let scenes: [(&Kind, Reader<Model>); 3] = [
        (&contact_separation::KIND, |root| contact_separation::model(root).map(Model::from)),
        (&sliding::KIND, |root| sliding::model(root).map(Model::from)),
        (&bump_stop::KIND, |root| bump_stop::model(root).map(Model::from)),
    ];
    let model = root.kind(&scenes)?(&mut root)?;
    let (load, part) = load::load(root.table("load")?)?;
    let excitation = excitation::excitation(root.table("excitation")?)?;
    let run = run_span::run_span(root.table("run")?, &excitation)?;
    let limits = limits::limits(root.optional_table("limits")?.unwrap_or_else(|| root.empty("limits")))?;
    let node = root.optional_table("node")?.map(|section| node::node(section, load, part)).transpose()?;
    let fit = root.optional_table("fit")?.map(fit::fit).transpose()?.unwrap_or_default();
    root.finish()?;
    Ok((Scene { file: file.to_owned(), model, load, excitation, run, limits }, node, fit))
}

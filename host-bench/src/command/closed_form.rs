//! `closed-form`: mean power of a beam without a trajectory.

use std::path::PathBuf;

use serde_json::json;

use super::storage_voltage::StorageVoltage;
use super::{NODE, Unused, check_overrides, print};
use crate::closed_form::estimate;
use crate::method::{Failure, Precision};
use crate::outcome::{Format, fields, text};
use crate::scene_file::{self, Override};

/// Keys that a closed form does not use.
const UNUSED: [Unused; 4] = [
    NODE,
    ("excitation.phase_rad", "a closed form is that of the steady motion"),
    ("run", "a closed form is that of the steady motion"),
    ("initial", "a closed form is that of the steady motion"),
];

#[derive(Debug, Clone, clap::Args)]
pub struct ClosedFormArguments {
    /// Scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Precision of the closed form
    #[arg(long, value_enum, default_value = "f64")]
    precision: Precision,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Another value for a key of the scene, such as load.resistance_ohm=1e6; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
    #[command(flatten)]
    storage_voltage: StorageVoltage,
}

/// Prints the closed form of the scene.
pub fn run(arguments: &ClosedFormArguments) -> Result<(), Failure> {
    let mut scene = scene_file::read(&arguments.scene, &arguments.overrides)?;
    check_overrides(&arguments.overrides, &arguments.storage_voltage.unused(&UNUSED))?;
    arguments.storage_voltage.hold(&mut scene)?;
    let found = estimate(&scene, arguments.precision)?;
    let mut named = fields(&json!({ "scene": scene.name() }));
    named.extend(found.fields());
    print(&text(&named, arguments.format))
}

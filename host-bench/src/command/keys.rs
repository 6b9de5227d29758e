//! `keys` and `new`: what a scene file may say, and a template of one.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;

use super::files::Outputs;
use super::{json_text, note, print};
use crate::method::Failure;
use crate::outcome::{WIDTH, folded};
use crate::rows::Rows;
use crate::scene_file::{TEMPLATES, template};
use harvester_scene::keys;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum KeysFormat {
    /// Text for people.
    #[default]
    Table,
    /// A row for each key, as in docs/keys.csv.
    Csv,
    /// A list of objects, one for each key.
    Json,
    /// JSON Schema (draft 7) of all scene files, for editors.
    Schema,
}

#[derive(Debug, Clone, clap::Args)]
pub struct KeysArguments {
    /// Only the keys of this scene
    #[arg(value_name = "SCENE", value_parser = PossibleValuesParser::new(keys::scenes()))]
    scene: Option<String>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: KeysFormat,
}

pub(super) fn run(arguments: &KeysArguments) -> Result<(), Failure> {
    let scene = arguments.scene.as_deref();
    match arguments.format {
        KeysFormat::Table => print(&keys::text(scene)),
        KeysFormat::Csv => print(&Rows::of(&keys::rows(scene)).csv().replace('`', "").replace(",'-", ",-")),
        KeysFormat::Json => print(&json_text(&keys::rows(scene))?),
        KeysFormat::Schema if scene.is_some() => {
            Err(Failure::Input("--format schema: is of all scenes, must be without SCENE".to_owned()))
        }
        KeysFormat::Schema => print(&format!("{:#}\n", keys::schema())),
    }
}

#[derive(Debug, Clone, clap::Args)]
pub struct NewArguments {
    /// Which scene
    #[arg(value_name = "SCENE", value_parser = PossibleValuesParser::new(TEMPLATES))]
    scene: String,
    /// Write the template to this file, which must not exist; without it: to standard output
    #[arg(long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
}

/// A line of a template with its comment folded, below its value where that is long.
fn narrow(line: &str) -> String {
    let Some((value, comment)) = line.split_once("  # ").filter(|_| line.chars().count() > WIDTH) else {
        return line.to_owned();
    };
    let value = value.trim_end();
    let comment = folded(&format!("{:42}# {comment}", ""), 44);
    let comment = comment.replace(&format!("\n{:44}", ""), &format!("\n{:42}# ", ""));
    match value.chars().count() {
        ..=40 => format!("{value:<42}{}", comment.trim_start()),
        _ if value.contains(" = [") => folded(value, 4) + "\n" + &comment,
        _ => format!("{value}\n{comment}"),
    }
}

pub(super) fn new(arguments: &NewArguments) -> Result<(), Failure> {
    let text = template(&arguments.scene)
        .ok_or_else(|| Failure::Input(format!("{}: has no template", arguments.scene)))?;
    let text: String = text.lines().map(|line| narrow(line) + "\n").collect();
    let Some(file) = &arguments.output else { return print(&text) };
    if file.symlink_metadata().is_ok() {
        return Err(Failure::Input(format!("--output {}: exists, must be a new file", file.display())));
    }
    let outputs = Outputs::of_shipped([]);
    outputs.check("--output", file)?;
    outputs.write(file, &text)?;
    // The table [node] is of `budget`.
    let command = if arguments.scene == "node" { "budget" } else { "run" };
    note(&format!("{}: a scene for `{command} {0}`; all keys: `keys`", file.display()));
    Ok(())
}

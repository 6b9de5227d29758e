//! `export`: a scene for other programs.

use std::path::{Path, PathBuf};

use super::files::Outputs;
use super::{NODE, check_overrides, note, set_option};
use crate::export::Netlist;
use crate::input::STANDARD;
use crate::method::Failure;
use crate::name::Name;
use crate::scene_file::{self, Override};

#[derive(Debug, Clone, clap::Args)]
pub struct ExportArguments {
    /// Scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Write the harvester as a subcircuit of SPICE to this file: two terminals and a pin of the base acceleration
    #[arg(long, value_name = "FILE.cir")]
    spice: PathBuf,
    /// Write a deck that runs the subcircuit with load, excitation and window of the scene to this file, in the same
    /// folder
    #[arg(long, value_name = "FILE.cir")]
    deck: Option<PathBuf>,
    /// Another value for a key of the scene, such as load.resistance_ohm=1e6; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
}

/// Writes the netlist of the scene.
///
/// # Errors
/// If the scene is one that no netlist has, or a file cannot be written.
pub fn run(arguments: &ExportArguments) -> Result<(), Failure> {
    let ExportArguments { scene: file, spice, deck, overrides } = arguments;
    let scene = scene_file::read(file, overrides)?;
    check_overrides(overrides, &[NODE])?;
    let outputs = Outputs::of(file, overrides)?;
    outputs.check("--spice", spice)?;
    if let Some(deck) = deck {
        if spice == Path::new(STANDARD) || spice.parent() != deck.parent() {
            let text = format!("--deck {}: must be in the folder of the file of --spice", deck.display());
            return Err(Failure::Input(text));
        }
        outputs.check("--deck", deck)?;
    }
    let netlist = Netlist::new(&scene)?;
    let sets: String = overrides.iter().map(set_option).collect();
    let [named, target] = [file, spice].map(|file| Name::of_file(file).shell());
    let text =
        netlist.subcircuit(&scene, overrides, &format!("host-bench export {named}{sets} --spice {target}"));
    let runs =
        deck.as_ref().map(|deck| Ok::<_, Failure>((deck, netlist.deck(&scene, spice)?))).transpose()?;
    outputs.write(spice, text)?;
    if let Some((deck, text)) = runs {
        outputs.write(deck, text)?;
        note(&format!("{0}: ngspice -b {0} prints its mean power", deck.display()));
    }
    Ok(())
}

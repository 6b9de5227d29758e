//! `export`: a scene for other programs.

use std::fs;
use std::path::{Path, PathBuf};

use super::files::Outputs;
use super::{FileArguments, NODE, check_overrides, note, set_option};
use crate::embedded;
use crate::export::{self, Netlist};
use crate::input::STANDARD;
use crate::method::Failure;
use crate::name::Name;
use crate::on_target::build::cargo;
use crate::scene_file;

#[derive(Debug, Clone, clap::Args)]
pub struct ExportArguments {
    #[command(flatten)]
    scene: FileArguments,
    /// Write the harvester as a subcircuit of SPICE to this file: two terminals and a pin of the base acceleration
    #[arg(long, value_name = "FILE.cir", required_unless_present = "fmu")]
    spice: Option<PathBuf>,
    /// Write a deck that runs the subcircuit with load, excitation and window of the scene to this file, in the same folder
    #[arg(long, value_name = "FILE.cir", requires = "spice")]
    deck: Option<PathBuf>,
    /// Write the harvester as an FMU of FMI 3.0 for co-simulation on x86-64 Linux to this file
    #[arg(long, value_name = "FILE.fmu", conflicts_with = "spice")]
    fmu: Option<PathBuf>,
    /// Shared library of the FMU: the package harvester-fmu, which is built by cargo where none is given
    #[arg(long, value_name = "FILE.so", requires = "fmu")]
    library: Option<PathBuf>,
}

pub(super) fn run(arguments: &ExportArguments) -> Result<(), Failure> {
    let ExportArguments { scene, spice, deck, fmu, library } = arguments;
    let FileArguments { scene: file, overrides } = scene;
    let scene = scene_file::read(file, overrides)?;
    check_overrides(overrides, &[NODE])?;
    let outputs = Outputs::of(file, overrides)?;
    if let Some(fmu) = fmu {
        let outputs = outputs.and(library.as_slice());
        outputs.check("--fmu", fmu)?;
        // Refuses the scene before the library is built.
        embedded::variables(&scene)?;
        outputs.write(fmu, export::fmu(&scene, overrides, &bytes(library.as_deref())?)?)?;
        return outputs.ended();
    }
    let Some(spice) = spice else { return Ok(()) };
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
    outputs.ended()
}

/// The shared library of an FMU, from a file or built by cargo. With the package of this command, whose build of the core serves.
fn bytes(library: Option<&Path>) -> Result<Vec<u8>, Failure> {
    let file = match library {
        Some(file) => file.to_owned(),
        None if cfg!(all(target_os = "linux", target_arch = "x86_64")) => {
            let packages = ["build", "--release", "--package", "harvester-fmu", "--package", "host-bench"];
            let failed = |reason| Failure::Input(format!("--fmu without --library: {reason}"));
            cargo(&packages, "").map_err(failed)?.join("release/libharvester_fmu.so")
        }
        None => return Err(Failure::Input("--library: must be given on this system".to_owned())),
    };
    fs::read(&file).map_err(|error| Failure::Input(format!("--library {}: {error}", file.display())))
}

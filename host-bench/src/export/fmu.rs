//! Scenes as FMUs of FMI 3.0 for co-simulation: a ZIP archive of a description, the library and the scene.

use std::fmt::Write as _;

use model_core::snapshot::Fingerprint;
use toml_edit::{DocumentMut, Item, Table, value};

use crate::embedded::{self, Variable, fingerprint};
use crate::fit::fitted_scene;
use crate::method::Failure;
use crate::name::Name;
use crate::scene_file::{Override, Scene};

/// Name of the library, which is the same for all scenes.
const LIBRARY: &str = "harvester_fmu";
/// Communication steps of the default experiment in a period of the excitation: a held sine then gives 8·10⁻⁵ less power.
const STEPS_PER_PERIOD: f64 = 200.0;
/// The units of the variables.
const UNITS: &str = r#"
    <Unit name="s"><BaseUnit s="1"/></Unit>
    <Unit name="m"><BaseUnit m="1"/></Unit>
    <Unit name="m/s2"><BaseUnit m="1" s="-2"/></Unit>
    <Unit name="A"><BaseUnit A="1"/></Unit>
    <Unit name="V"><BaseUnit kg="1" m="2" s="-3" A="-1"/></Unit>
    <Unit name="Ohm"><BaseUnit kg="1" m="2" s="-3" A="-2"/></Unit>
    <Unit name="W"><BaseUnit kg="1" m="2" s="-3"/></Unit>
    <Unit name="J"><BaseUnit kg="1" m="2" s="-2"/></Unit>
"#;

/// The file of the FMU of a scene; `library` is the shared library of the package `harvester-fmu`. Refuses a load without an input.
pub(crate) fn fmu(scene: &Scene, overrides: &[Override], library: &[u8]) -> Result<Vec<u8>, Failure> {
    let variables = embedded::variables(scene)?;
    let description = description(scene, &variables, fingerprint(scene)?);
    let resource = resource(scene, overrides)?;
    Ok(archive(&[
        ("modelDescription.xml", description.as_bytes()),
        (&format!("binaries/x86_64-linux/{LIBRARY}.so"), library),
        ("resources/scene.toml", resource.as_bytes()),
    ]))
}

/// The scene with the overrides, at rest: the acceleration is an input, and a recording would be another file.
fn resource(scene: &Scene, overrides: &[Override]) -> Result<String, Failure> {
    let text = fitted_scene(&scene.file, overrides, &[], false)?;
    let mut document: DocumentMut =
        text.parse().map_err(|error| Failure::of_file(scene, format!("is not TOML: {error}")))?;
    for other in ["node", "fit"] {
        document.remove(other);
    }
    let table = |entries: &[(&str, Item)]| Item::Table(entries.iter().cloned().collect::<Table>());
    document["excitation"] = table(&[("kind", value("silence"))]);
    let run = [("duration_s", value(scene.run.duration_s)), ("settle_s", value(scene.run.settle_s))];
    document["run"] = table(&run);
    Ok(document.to_string())
}

/// `modelDescription.xml`.
fn description(scene: &Scene, variables: &[Variable], token: u32) -> String {
    let (scene_name, name) = (scene.name(), Name::of_file(&scene.file).html());
    let (version, stop) = (env!("CARGO_PKG_VERSION"), scene.run.duration_s);
    let frequency = scene.excitation.highest_hz();
    let step = (frequency > 0.0).then(|| format!(" stepSize=\"{:e}\"", 1.0 / (STEPS_PER_PERIOD * frequency)));
    let step = step.unwrap_or_default();
    let mut text = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="{scene_name}" instantiationToken="{token:08x}" description="Vibration energy harvester of {name}" version="{version}" generationTool="host-bench {version}">
  <CoSimulation modelIdentifier="{LIBRARY}" canGetAndSetFMUState="true" canSerializeFMUState="true" canHandleVariableCommunicationStepSize="true"/>
  <UnitDefinitions>{UNITS}  </UnitDefinitions>
  <LogCategories><Category name="logStatusError"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="{stop:e}"{step}/>
  <ModelVariables>
"#
    );
    for (reference, Variable { name, unit, meaning, input }) in variables.iter().enumerate() {
        let causality = match (reference, input) {
            (0, _) => "causality=\"independent\"".to_owned(),
            (_, None) => "causality=\"output\"".to_owned(),
            (_, Some([start, least, most])) => {
                format!(r#"causality="input" start="{start:e}" min="{least:e}" max="{most:e}""#)
            }
        };
        let _ = writeln!(
            text,
            r#"    <Float64 name="{name}" valueReference="{reference}" variability="continuous" {causality} unit="{unit}" description="{meaning}"/>"#
        );
    }
    text += "  </ModelVariables>\n  <ModelStructure>\n";
    for kind in ["Output", "InitialUnknown"] {
        for (reference, _) in variables.iter().enumerate().skip(1).filter(|(_, one)| one.input.is_none()) {
            let _ = writeln!(text, "    <{kind} valueReference=\"{reference}\"/>");
        }
    }
    text + "  </ModelStructure>\n</fmiModelDescription>\n"
}

/// A ZIP archive of files, which are stored without compression.
fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let short = |value: usize| (value as u16).to_le_bytes();
    let long = |value: usize| (value as u32).to_le_bytes();
    let (mut all, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in files {
        let mut checksum = Fingerprint::new();
        checksum.numbers(content);
        // Version 2.0, no flags, stored, the first of January 1980, checksum, both sizes, length of the name, no extra field.
        let entry = [
            &[20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0][..],
            &checksum.value().to_le_bytes(),
            &long(content.len()),
            &long(content.len()),
            &short(name.len()),
            &[0, 0],
        ]
        .concat();
        // Made by version 3.0 under Unix; no comment, first disk, a binary file that may be run.
        directory.extend([&b"PK\x01\x02\x1e\x03"[..], &entry, &[0; 6], &long(0o100_755 << 16)].concat());
        directory.extend([&long(all.len())[..], name.as_bytes()].concat());
        all.extend([b"PK\x03\x04", &entry[..], name.as_bytes(), content].concat());
    }
    let (count, start) = (short(files.len()), all.len());
    all.extend(&directory);
    all.extend(
        [&b"PK\x05\x06\0\0\0\0"[..], &count, &count, &long(directory.len()), &long(start), &[0; 2]].concat(),
    );
    all
}

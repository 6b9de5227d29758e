use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};

use super::*;
use crate::scene_file::{self, Override, TEMPLATES, rows_of, template};

#[test]
fn the_schema_is_that_of_the_tables() {
    let shipped = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.schema.json"));
    assert_eq!(shipped.expect("a file of the project"), format!("{:#}\n", schema()), "keys --format schema");
}

#[test]
fn each_key_has_a_line_that_says_what_it_is() {
    let mut count = 0;
    for row in rows(None) {
        let name = format!("{}.{}", row.table, row.key);
        assert!(!row.meaning.is_empty() && !row.meaning.ends_with('.'), "{name}: {}", row.meaning);
        assert!(!row.bounds.is_empty() && !row.default.is_empty(), "{name}");
        // The unit of the name is that of the row.
        for (end, unit) in
            [("_m", "m"), ("_kg", "kg"), ("_hz", "Hz"), ("_ohm", "Ω"), ("_pa", "Pa"), ("_w", "W")]
        {
            let plain = row.key.ends_with(end) && !row.key.contains("_per_");
            assert!(!plain || row.unit == unit, "{name} in {}", row.unit);
        }
        count += 1;
    }
    assert!(count > 120, "{count} rows");
    // The width of a terminal.
    let wide = text(None).lines().find(|line| line.chars().count() > 100).map(str::to_owned);
    assert_eq!(wide, None);
}

/// The file of a template.
fn file(folder: &str, name: &str, text: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("harvester-keys-{}-{folder}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    let path = folder.join(format!("{name}.toml"));
    std::fs::write(&path, text).expect("a temporary file");
    path
}

#[test]
fn a_template_is_the_scene_that_its_values_are_of() {
    for name in TEMPLATES {
        let text = template(name).expect("a template");
        let path = file("templates", name, &text);
        let shipped = if name == "contact-separation" { "contact-separation-passive" } else { name };
        let mut expected = scene_file::read(&scene_file::shipped(shipped), &[]).expect("valid");
        expected.file = path.clone();
        assert_eq!(scene_file::read(&path, &[]).as_ref(), Ok(&expected), "{text}");
        if name == "node" {
            let node = |path: &Path| scene_file::read_with_node(path, &[]).map(|(_, node)| node);
            assert_eq!(node(&path).ok(), node(&scene_file::shipped(name)).ok(), "{text}");
        }
    }
}

/// Every kind of table with its keys, as options that make it of a template that has the tables around.
const KINDS: [(&str, &[&str]); 28] = [
    ("contact-separation", &[]),
    ("contact-separation", &["parameters.restitution={kind='constant', coefficient=0.5}"]),
    ("contact-separation", &["initial={gap_m=1e-3, velocity_m_per_s=0, charge_c=0}"]),
    ("sliding", &["initial={displacement_m=1e-3, velocity_m_per_s=0, charge_c=0}"]),
    ("bump-stop-tip-mass", &["tip_mass.offset_m=0", "parameters.transducer=bimorph-series"]),
    ("contact-separation", &["limits={pressure_pa=1e5, fringing=0.1, contact_speed_m_per_s=1}"]),
    ("sliding", &["limits={strain=5e-3, slope_rad=0.1}"]),
    (
        "bump-stop",
        &[
            "limits={strain=5e-3, piezo_strain=2e-3, piezo_field_v_per_m=6e5, slope_rad=0.1, contact_speed_m_per_s=1}",
        ],
    ),
    (
        "bump-stop",
        &["stop.contact='restitution'", "stop.restitution=0.5", "stop.contact_compliance_m_per_n=0"],
    ),
    (
        "bump-stop-none",
        &["parameters.beam_modes=1", "initial={modal_displacement=[0], modal_velocity=[0], voltage_v=0}"],
    ),
    ("bump-stop", &["stop.rod_modes=1", "initial={rod_modal_displacement=[0], rod_modal_velocity=[0]}"]),
    ("sliding", &["load.kind=dc-bus", "load.voltage_v=5", "load.diode_drop_v=0.3", "load.preset=diodes"]),
    ("rectified", &["load.preset=diodes"]),
    ("rectified", &["load.draw={kind='resistor', value=1e6, turn_on_v=4, turn_off_v=3}"]),
    ("rectified", &["load.draw={kind='current', value=1e-6, turn_on_v=4, turn_off_v=3}"]),
    ("sliding", &["run={duration_s=1, settle_s=0.5}"]),
    ("sliding", &["excitation.phase_rad=1"]),
    (
        "sliding",
        &[
            "run={duration_s=1}",
            "excitation={kind='sines', tones=[{amplitude_g=0.1, frequency_hz=20, phase_rad=0}]}",
        ],
    ),
    (
        "sliding",
        &[
            "run={duration_s=1}",
            "excitation={kind='half-sine', amplitude_g=1, duration_s=1e-2, start_s=0, period_s=1}",
        ],
    ),
    (
        "sliding",
        &[
            "run={duration_s=1}",
            "excitation={kind='bursts', amplitude_m_per_s2=1, frequency_hz=20, cycles=2, start_s=0, period_s=1}",
        ],
    ),
    (
        "sliding",
        &[
            "run={duration_s=1}",
            "excitation={kind='sweep', amplitude_g=1, from_hz=10, to_hz=20, sweep_s=1, law='linear', phase_rad=0}",
        ],
    ),
    ("contact-separation-truck", &["run.settle_s=0"]),
    (
        "contact-separation-truck",
        &["excitation={kind='random', spectral_density_m2_per_s3=[[10,1],[20,1]], seed=1, lines=64}"],
    ),
    (
        "node",
        &[
            "node.storage={capacitance_f=0.2, leakage_ohm=1e6, initial_v=3, charging_efficiency=0.9, discharging_efficiency=0.9, highest_v=5, turn_on_v=3, turn_off_v=2}",
        ],
    ),
    ("node", &["node.storage={battery='slb12400l151', charging_efficiency=0.9, discharging_efficiency=0.9}"]),
    ("node", &["node.time_constant_s=1e4", "node.day_weight=0.5"]),
    (
        "node",
        &[
            "node.standing_power_w=1e-6",
            "node.parts.clock=own",
            "node.burst.code=filter",
            "node.actions=[{name='one', energy_j=1e-6, duration_s=1, every_s=60, packet_bytes=9, adc_readings=2, instructions=9}]",
        ],
    ),
    ("sliding", &["fit={data=['data.csv'], free=['parameters.damping_ratio'], loss='linear', starts=3}"]),
];

/// Words of a choice, as an error lists them.
fn listed(words: &[&str]) -> String {
    words.iter().map(|word| format!("{word:?}")).collect::<Vec<_>>().join(" or ")
}

/// What is no word of a choice.
const NO_WORD: &str = "Exact 3 true ''";

/// What a key may not be: out of its bounds, or of another kind; and what an error then says of it.
fn wrong(key: &Key) -> (Vec<String>, String) {
    const NO_NUMBER: &str = "nan -inf 1e999 true {} [1] 3_apples '1' 1,5";
    let range = Bound::of(key).range;
    let (wrong, bound) = match key.value {
        Value::Number(_) | Value::NumberOrLimits(_) => (NO_NUMBER, Bound::of(key).to_string()),
        Value::Whole(_) => (NO_NUMBER, format!("a whole number from {} to {}", range.lowest, range.highest)),
        Value::Numbers(..) => ("1 [] [nan] [1e9] [true] [[1]] ['a']", "numbers, ".to_owned()),
        Value::Words(words) => (NO_WORD, listed(words)),
        Value::Part(words) => (NO_WORD, listed(&words())),
        Value::Flag => ("1 'yes' []", "true or false".to_owned()),
        Value::Table(_) => ("1", "must be a table".to_owned()),
        Value::Tables(_) => ("1 [] [1]", "a list of tables, at least one".to_owned()),
        _ => ("", String::new()),
    };
    // A date is the value of no key.
    let mut all: Vec<String> = format!("1979-05-27 {wrong}").split_whitespace().map(str::to_owned).collect();
    if wrong == NO_NUMBER {
        let beyond = |bound: f64, sign: f64| format!("{:e}", bound + sign * (1e-9 * bound.abs()).max(1e-12));
        all.push(beyond(range.lowest, -1.0));
        if range.highest.is_finite() {
            all.push(beyond(range.highest, 1.0));
            all.extend((!matches!(key.value, Value::NumberOrLimits(_))).then(|| "inf".to_owned()));
        }
    }
    (all, bound)
}

/// Refuses each key of a table that the document has, wrong in its turn, and a key that the table does not have.
fn refuse_each(
    (path, sets): (&Path, &[Override]),
    (table, of): (&Json, &'static Table),
    prefix: &str,
    seen: &mut Vec<String>,
) {
    let refuse = |key: &str, wrong: &str, bound: &str| {
        let sets: Vec<Override> = sets.iter().cloned().chain([Override::new(key, wrong)]).collect();
        let Err(error) = scene_file::read(path, &sets) else {
            panic!("{}: {key} = {wrong} is accepted", path.display())
        };
        let (told, shown) = (error.to_string(), key.replace(".0.", "[0]."));
        let begins = format!("{}: --set {shown} = ", path.display());
        // The words of a choice are in the order of its code or of its table.
        let says = bound.split(" or \"").all(|bound| told.contains(bound));
        assert!(told.starts_with(&begins) && says, "{key} = {wrong}, {bound}: {told}");
    };
    let kind = table[of.selector].as_str().and_then(|word| of.kind(word));
    for (name, value) in table.as_object().expect("a table") {
        let key = format!("{prefix}{name}");
        let row = of.key(name, kind);
        let inner = row.and_then(Key::table);
        match value {
            Json::Object(_) => {
                refuse_each((path, sets), (value, inner.expect("a table of keys")), &format!("{key}."), seen)
            }
            Json::Array(items) if items.iter().all(Json::is_object) => {
                refuse_each((path, sets), (&items[0], inner.expect("keys")), &format!("{key}.0."), seen);
            }
            _ => {}
        }
        let kinds = || listed(&of.kinds.iter().map(|kind| kind.word).collect::<Vec<_>>());
        let of_kind = || (NO_WORD.split(' ').map(str::to_owned).collect(), kinds());
        let (all, bound) = row.map_or_else(of_kind, wrong);
        all.iter().for_each(|wrong| refuse(&key, wrong, &bound));
        seen.push(name.clone());
    }
    refuse(&format!("{prefix}extra"), "1", "unknown key");
}

/// Each key that must be there is missing in its turn from the shipped scenes.
#[test]
fn a_missing_key_is_named_with_its_bound() {
    let mut count = 0;
    for name in ["contact-separation", "sliding", "bump-stop", "rectified"] {
        let text = std::fs::read_to_string(scene_file::shipped(name)).expect("a shipped scene");
        let lines: Vec<&str> = text.lines().collect();
        let mut table = String::new();
        for (at, line) in lines.iter().enumerate() {
            if let Some((name, _)) = line.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
                table = format!("{name}.");
            }
            let Some((key, _)) = line.split_once(" = ").filter(|_| !line.starts_with(['#', '['])) else {
                continue;
            };
            let full = format!("{table}{key}");
            // A word that chooses the kind has no row.
            let rows = rows_of(&full);
            if rows.iter().any(|row| row.default != Default::Required) {
                continue;
            }
            let without = [&lines[..at], &lines[at + 1..]].concat().join("\n");
            let path = file("missing", name, &without);
            let told = scene_file::read(&path, &[]).expect_err(&full).to_string();
            let bounds = match rows[..] {
                [Key { value: Value::Number(_), instead_of: None, .. }] => Bound::of(rows[0]).to_string(),
                _ => String::new(),
            };
            assert!(
                told.contains(key) && told.contains("is missing") && told.contains(&bounds),
                "{full}: {told}"
            );
            count += 1;
        }
    }
    assert!(count > 60, "{count} keys");
}

#[test]
fn each_key_of_the_tables_is_read_and_checked() {
    let mut seen = Vec::new();
    for (name, sets) in KINDS {
        let path = file("kinds", name, &template(name).expect("a template"));
        let sets: Vec<Override> = sets.iter().map(|set| set.parse().expect("KEY=VALUE")).collect();
        if let Err(error) = scene_file::read(&path, &sets) {
            panic!("{name} {sets:?}: {error}");
        }
        let document = scene_file::as_json(&path, &sets).expect("a document");
        refuse_each((&path, &sets), (&document, &KEYS), "", &mut seen);
    }
    // Those of a recording are in the tests of traces.
    let of_file = [
        "path",
        "column",
        "time_column",
        "rate_hz",
        "resample_hz",
        "longest_gap_samples",
        "scale_m_per_s2",
        "repeat",
    ];
    scene_file::key::walk(&KEYS, &mut |key| {
        let known = seen.iter().any(|name| name == key.name) || of_file.contains(&key.name);
        assert!(known, "{} is not in a file of this test", key.name);
    });
}

#[test]
fn a_kind_brings_its_keys_and_drops_those_of_the_other() {
    let read = |name: &str, sets: &[&str]| {
        let sets: Vec<Override> = sets.iter().map(|set| set.parse().expect("KEY=VALUE")).collect();
        scene_file::read(&scene_file::shipped(name), &sets)
            .map(|scene| scene.load)
            .map_err(|error| error.to_string())
    };
    let bus = scene_file::Load::DcBus { voltage_v: 5.0, diode_drop_v: 0.3 };
    let voltage = ["load.kind=dc-bus", "load.voltage_v=5", "load.diode_drop_v=0.3"];
    assert_eq!(read("sliding", &voltage), Ok(bus));
    // In any order, and what both kinds have stays.
    assert_eq!(read("sliding", &[voltage[1], voltage[2], voltage[0]]), Ok(bus));
    assert_eq!(read("rectified", &voltage[..2]), Ok(bus));
    let resistor = scene_file::Load::Resistor { resistance_ohm: 1e6 };
    assert_eq!(read("rectified", &["load.kind=resistor", "load.resistance_ohm=1e6"]), Ok(resistor));
    // A key of the same name with another unit is another quantity.
    let told = read("rectified", &["load.draw.kind=resistor"]).expect_err("no value");
    assert!(told.contains("load.draw.value: is missing"), "{told}");
    // What the new kind lacks is told, and an unknown kind too.
    let told = read("sliding", &["load.kind=dc-bus"]).expect_err("no voltage");
    assert!(told.contains("load.voltage_v: is missing"), "{told}");
    let told = read("sliding", &["load.kind=bus"]).expect_err("no kind");
    assert!(told.contains("load.kind = \"bus\": must be \"resistor\""), "{told}");
}

/// Whether a value is what a schema says, by the words that [`schema`] uses; the error is the path of the first fault.
fn check(value: &Json, schema: &Json, whole: &Json) -> Result<(), String> {
    let fault = |text: &str| Err(format!("{text}: {value}"));
    if let Some(name) = schema.get("$ref").and_then(Json::as_str) {
        let name = name.strip_prefix("#/").expect("a definition");
        return check(value, whole.pointer(&format!("/{name}")).expect("a definition"), whole);
    }
    for (word, rule) in schema.as_object().expect("a schema") {
        let all = || rule.as_array().expect("a list").iter();
        let holds = match word.as_str() {
            "type" => match rule.as_str().expect("a type") {
                "object" => value.is_object(),
                "array" => value.is_array(),
                "string" => value.is_string(),
                "boolean" => value.is_boolean(),
                "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
                "number" => value.is_number(),
                other => return fault(other),
            },
            "const" => same(rule, value),
            "enum" => all().any(|one| same(one, value)),
            "minimum" => value.as_f64().is_none_or(|number| number >= rule.as_f64().expect("a number")),
            "maximum" => value.as_f64().is_none_or(|number| number <= rule.as_f64().expect("a number")),
            "minItems" => {
                value.as_array().is_none_or(|list| list.len() >= rule.as_u64().expect("a count") as usize)
            }
            "maxItems" => {
                value.as_array().is_none_or(|list| list.len() <= rule.as_u64().expect("a count") as usize)
            }
            "items" => {
                for item in value.as_array().into_iter().flatten() {
                    check(item, rule, whole)?;
                }
                true
            }
            "required" => all().all(|name| value.get(name.as_str().expect("a name")).is_some()),
            "additionalProperties" => {
                let known = schema["properties"].as_object().expect("properties");
                value.as_object().is_none_or(|table| table.keys().all(|key| known.contains_key(key)))
            }
            "properties" => {
                for (name, rule) in rule.as_object().expect("properties") {
                    if let Some(inner) = value.get(name) {
                        check(inner, rule, whole).map_err(|error| format!("{name}: {error}"))?;
                    }
                }
                true
            }
            "oneOf" => {
                let checked: Vec<Result<(), String>> = all().map(|one| check(value, one, whole)).collect();
                if checked.iter().filter(|one| one.is_ok()).count() != 1 {
                    return Err(format!("oneOf: {checked:?}"));
                }
                true
            }
            "anyOf" => all().any(|one| check(value, one, whole).is_ok()),
            "allOf" => all().all(|one| check(value, one, whole).is_ok()),
            "not" => check(value, rule, whole).is_err(),
            "$schema" | "title" | "description" | "default" | "definitions" => true,
            other => return fault(&format!("a word that this test does not know: {other}")),
        };
        if !holds {
            return fault(&format!("{word} {rule}"));
        }
    }
    Ok(())
}

/// Whether two values are the same; of numbers whatever they are written as.
fn same(one: &Json, other: &Json) -> bool {
    one == other || matches!((one.as_f64(), other.as_f64()), (Some(one), Some(other)) if one == other)
}

#[test]
fn the_schema_accepts_the_shipped_scenes_and_refuses_faults() {
    let schema = schema();
    let read = |path: &Path, sets: &[&str]| {
        let sets: Vec<Override> = sets.iter().map(|set| set.parse().expect("KEY=VALUE")).collect();
        scene_file::as_json(path, &sets).expect("a document")
    };
    let mut count = 0;
    for entry in std::fs::read_dir(env!("CARGO_MANIFEST_DIR")).expect("the shipped scenes") {
        let path = entry.expect("a file").path();
        let is_scene = path.extension().is_some_and(|extension| extension == "toml");
        if is_scene && !path.ends_with("Cargo.toml") {
            assert_eq!(scene_file::shipped_text(&path), std::fs::read_to_string(&path).ok().as_deref());
            let document = read(&path, &[]);
            assert_eq!(check(&document, &schema, &schema), Ok(()), "{}", path.display());
            count += 1;
        }
    }
    assert!(count >= 15, "{count} scenes");
    let sliding = scene_file::shipped("sliding");
    let faults = "parameters.mass_kg=1 parameters.damping_ratio=11 parameters.force_law=other load.kind=bus load.kind=dc-bus \
                  load.resistance_ohm=-1 run.duration_s=0 excitation.amplitude_g=a scene=bump-stop node={}";
    for fault in faults.split(' ') {
        assert!(check(&read(&sliding, &[fault]), &schema, &schema).is_err(), "{fault}");
    }
    // Two keys of one quantity.
    let mut both = read(&sliding, &[]);
    both["excitation"]["amplitude_m_per_s2"] = json!(1.0);
    assert!(check(&both, &schema, &schema).is_err());
    both["excitation"] = json!({ "kind": "sine", "frequency_hz": 20.0 });
    assert!(check(&both, &schema, &schema).is_err());
    // What the reader's defaults are, the schema says.
    let lines = schema.pointer("/definitions/excitation/oneOf/3/properties/lines/default");
    assert_eq!(lines, Some(&json!(1024)));
    assert_eq!(rows_of("excitation.lines")[0].default, Default::Number(1024.0));
}

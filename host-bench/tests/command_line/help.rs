//! The texts of `--help`.

use super::tool::{BEAM, BUMP_STOP, MEASURED, PASSIVE, accepted};

/// The names of the commands.
fn commands() -> Vec<String> {
    let help = accepted(&["--help"]);
    let list = help.split("Commands:\n").nth(1).expect("the commands").split("\n\n").next().expect("an end");
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

/// Each option of a help text: its line, and the text below it.
fn options(help: &str) -> Vec<(String, String)> {
    let mut options: Vec<(String, String)> = Vec::new();
    for line in help.lines() {
        let trimmed = line.trim();
        // Options are indented by two or six letters, their texts below by more.
        let is_option = trimmed.starts_with('-') && line.find('-').is_some_and(|indent| indent <= 6);
        if is_option {
            options.push((trimmed.to_owned(), String::new()));
        } else if let Some((_, text)) = options.last_mut() {
            text.push_str(trimmed);
            text.push(' ');
        }
    }
    options
}

#[test]
fn no_text_has_the_markup_of_the_documentation() {
    let commands = commands();
    assert!(commands.len() >= 17, "{commands:?}");
    for command in &commands {
        let help = accepted(&[command, "--help"]);
        for markup in ["[`", "`]", "`", "::", "](", "crate::", "Self::"] {
            assert!(!help.contains(markup), "{command} --help has {markup:?}: {help}");
        }
    }
}

#[test]
fn each_number_has_its_unit_and_each_choice_its_default() {
    // What a value is called tells its unit.
    let units = [
        ("<S>", [" s ", "econds"]),
        ("<HZ>", ["Hz", "Hz"]),
        ("<V>", [" V", " V"]),
        ("<REL>", ["elative", "rror"]),
    ];
    for command in commands() {
        for (option, text) in options(&accepted(&[&command, "--help"])) {
            let all = format!("{option} {text}");
            for (name, words) in units {
                assert!(
                    !option.contains(name) || words.iter().any(|word| all.contains(word)),
                    "{command}: {all}"
                );
            }
            let chooses = text.contains("Possible values") && !option.contains("--core");
            assert!(!chooses || text.contains("[default: ") || text.contains("only"), "{command}: {all}");
        }
    }
}

#[test]
fn slow_commands_state_how_long_they_take() {
    let slow = "budget figures findings fit map needs on-target optimise plot resonance run stability stop sweep validation work-precision";
    for command in slow.split(' ') {
        let help = accepted(&[command, "--help"]);
        assert!(help.contains("Run time:"), "{command}: {help}");
    }
}

#[test]
fn what_people_read_has_at_most_a_hundred_columns() {
    let (commands, short) = (commands(), "run={duration_s=0.5,settle_s=0.25}");
    let over = ["--over", "load.resistance_ohm=1M:100M:2", "--over", "excitation.frequency_hz=20:21:2"];
    let sweep = ["sweep", PASSIVE, "--steady-state", "--no-accuracy", "--set", short];
    let few = ["--set", "run={duration_s=0.02,settle_s=0.01}", "--no-accuracy"];
    for arguments in [
        vec!["run", PASSIVE, "--set", short],
        [&["run", BUMP_STOP], &few[..]].concat(),
        [&sweep[..], &over].concat(),
        vec!["closed-form", BEAM],
        vec!["validation"],
        vec!["needs", PASSIVE, "--accuracy", "0.1"],
        vec!["fit", MEASURED],
        vec!["resonance", PASSIVE, "--from", "19", "--to", "22"],
        vec!["attractors", PASSIVE, "--starts", "4", "--set", short],
        vec!["findings", "--only", "42", "--single-start"],
    ]
    .into_iter()
    .chain(commands.iter().map(|command| vec![command.as_str(), "--help"]))
    {
        let told = accepted(&arguments);
        let wide = told.lines().find(|line| line.chars().count() > 100);
        assert!(wide.is_none(), "{}: {wide:?}", arguments[0]);
    }
}

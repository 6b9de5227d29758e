use super::statistics::{correlation, largest, least, median, share_above, smallest, spread};
use super::*;

#[test]
fn every_finding_is_measured_by_one_experiment() {
    for finding in FINDINGS.iter() {
        assert_ne!(finding.mark, Mark::Stopped, "{}", finding.number);
        let of = EXPERIMENTS.iter().filter(|experiment| experiment.numbers.contains(&finding.number)).count();
        assert_eq!(of, 1, "{}", finding.number);
        assert!(finding.statement.ends_with('.'), "{}", finding.statement);
        let draws = stored(finding.number).len();
        assert!(draws >= 200 && draws == stored("1").len(), "{} has {draws} draws", finding.number);
    }
    // A draw in which nothing is known was not measured.
    let known =
        |draw: &usize| FINDINGS.iter().any(|finding| !stored(finding.number)[*draw..].starts_with('u'));
    assert!((0..stored("1").len()).all(|draw| known(&draw)));
    let numbers: usize = EXPERIMENTS.iter().map(|experiment| experiment.numbers.len()).sum();
    assert_eq!(numbers, FINDINGS.len());
}

#[test]
fn a_number_that_is_not_in_the_list_is_refused() {
    let refused = wanted(&["8".to_owned(), "44".to_owned()]).expect_err("there is no 44");
    assert!(refused.to_string().starts_with("--only 44: must be of 1, 2"), "{refused}");
    let order: Vec<&str> = wanted(&["9".to_owned(), "8".to_owned()])
        .expect("both are in the list")
        .iter()
        .map(|finding| finding.number)
        .collect();
    assert_eq!(order, ["8", "9"]);
}

/// The mark follows from the checks: one that fails changes it, in both directions.
#[test]
fn the_mark_is_that_of_the_checks() {
    let of = |number: &str, value: f64| {
        let finding = FINDINGS.iter().find(|finding| finding.number == number).expect("in the list");
        let checks = [1.0, value].map(|value| check("8", "", [value], Bound::Below(2.0)));
        Row { finding, checks: checks.to_vec() }
    };
    for (number, expected) in [("8", Mark::Shown), ("9", Mark::Chosen)] {
        assert!(of(number, 1.5).mark() == expected && of(number, 1.5).is_as_expected());
        assert!(of(number, 2.5).mark() == Mark::NotShown && !of(number, 2.5).is_as_expected());
        assert!(!of(number, f64::NAN).is_as_expected());
    }
    assert!(of("a", 2.5).is_as_expected() && !of("a", 1.5).is_as_expected());
    let unknown = of("a", f64::NAN);
    assert!(unknown.mark() == Mark::NotShown && !unknown.is_as_expected());
}

/// The slider without charge leaves its patches at an amplitude that is larger by a fifth.
#[test]
fn a_run_that_reaches_the_edge_of_the_domain_marks_its_findings_and_the_others_go_on() {
    let batch = [
        Experiment {
            numbers: &["21", "22", "23", "24"],
            measure: |loader| resistance::measure_charge(loader, "0.432"),
        },
        Experiment { numbers: &["16"], measure: shapes::measure_charge },
    ];
    let wanted = wanted(&["16".to_owned(), "21".to_owned()]).expect("both are in the list");
    let rows = measure_of(&batch, wanted, true, &|_| ()).expect("no bad input");
    assert_eq!(rows.iter().map(Row::mark).collect::<Vec<_>>(), [Mark::Shown, Mark::Stopped]);
    let edge = &rows[1].checks[0].quantity;
    assert!(!rows[1].is_as_expected() && edge.contains(" is outside the model's domain at 5."), "{edge}");
    let refused = |_: Loader<'_>| Err(Failure::Input("bad".to_owned()));
    assert!(Experiment { numbers: &["8"], measure: refused }.measured(Loader(None), true).is_err());
}

#[test]
fn a_finding_without_a_measured_check_is_an_error() {
    let both =
        |_: Loader<'_>| Ok(["9", "8"].map(|number| check(number, "", [1.0], Bound::Reported)).to_vec());
    let one = |_: Loader<'_>| Ok(vec![check("8", "", [1.0], Bound::Reported)]);
    let of = |measure: fn(Loader<'_>) -> Result<Measured, Failure>| {
        let wanted = wanted(&["8".to_owned(), "9".to_owned()]).expect("both are in the list");
        measure_of(&[Experiment { numbers: &["8", "9"], measure }], wanted, true, &|_| ())
    };
    let found = of(both).expect("both are measured");
    assert_eq!(found.iter().map(|row| row.finding.number).collect::<Vec<_>>(), ["8", "9"]);
    let failure = of(one).expect_err("9 has no check");
    assert_eq!(failure.to_string(), "findings: finding 9 was not measured");
}

#[test]
fn a_bound_holds_for_every_value() {
    for (bound, holding, failing, text) in [
        (Bound::Above(0.5), [0.6, 0.7], [0.6, 0.5], "> 0.5"),
        (Bound::AtLeast(0.0), [0.0, 1.0], [0.0, -1e-300], ">= 0"),
        (Bound::Is(0.0), [0.0, 0.0], [0.0, 1e-300], "= 0"),
        (Bound::Below(1e-12), [0.0, -1.0], [0.0, 1e-12], "< 1e-12"),
        (Bound::Within(0.85, 1.1), [0.85, 1.1], [0.84, 1.0], "0.85 to 1.1"),
        (Bound::Falls, [2.0, 1.0], [1.0, 1.0], "falls"),
        (Bound::Rises, [1.0, 2.0], [1.0, 1.0], "rises"),
        (Bound::Reported, [1.0, 2.0], [f64::NAN, 1.0], ""),
    ] {
        assert!(check("8", "", holding, bound).holds(), "{bound:?}");
        assert_eq!(check("8", "", failing, bound).holds(), bound == Bound::Reported, "{bound:?}");
        assert_eq!(check("8", "", holding, bound).assertion(), text);
        let none = check("8", "", [], bound);
        assert!(!none.holds() && !none.is_measured(), "{bound:?}");
    }
    for bound in [Bound::Falls, Bound::Rises] {
        assert!(!check("8", "", [1.0], bound).holds(), "{bound:?}");
    }
    let shown = check("8", "", [0.0, 1.23456, -39.8131, 1234.56, 1.2e-7, 245.1799], Bound::Reported).shown();
    assert_eq!(shown, "0, 1.235, -39.81, 1235, 1.2e-7, 245.2");
}

#[test]
fn the_share_of_high_frequencies_is_that_of_two_sines() {
    let every_s = 1e-4;
    let time = |index: u32| every_s * f64::from(index);
    let sine = |frequency: f64, time: f64| (std::f64::consts::TAU * frequency * time).sin();
    let samples: Vec<f64> =
        (0..2500).map(|index| 3.0 + sine(44.0, time(index)) + 0.1 * sine(1500.0, time(index))).collect();
    let share = share_above(&samples, every_s, 1200.0);
    assert!((share - 0.01 / 1.01).abs() < 1e-9, "{share}");
    assert!(share_above(&samples, every_s, 1600.0) < 1e-9);
}

#[test]
fn correlation_and_median_have_their_known_values() {
    let pairs = [(1.0, 2.0), (2.0, 4.0), (3.0, 6.0)];
    assert!((correlation(pairs.into_iter()) - 1.0).abs() < 1e-12);
    assert!((correlation(pairs.into_iter().map(|(x, y)| (x, -y + 7.0))) + 1.0).abs() < 1e-12);
    // Σxy = 1·1 + 0·(−1) + (−1)·0 over √(2·2).
    let half = [(1.0, 1.0), (0.0, -1.0), (-1.0, 0.0)];
    assert!((correlation(half.into_iter()) - 0.5).abs() < 1e-12);
    assert_eq!(median([5.0, 1.0, 3.0].into_iter()), 3.0);
    assert!(median(std::iter::empty()).is_nan());
}

#[test]
fn an_extreme_of_nothing_or_of_not_a_number_is_not_a_number() {
    let values = [2.0, -1.0, 3.0];
    assert_eq!([largest(values.into_iter()), smallest(values.into_iter())], [3.0, -1.0]);
    assert_eq!(spread(values.into_iter()), 4.0);
    for values in [&[][..], &[f64::NAN], &[f64::NAN, 1.0], &[1.0, f64::NAN], &[1.0, f64::NAN, 2.0]] {
        let values = || values.iter().copied();
        assert!([largest(values()), smallest(values()), spread(values())].iter().all(|found| found.is_nan()));
    }
}

/// A cubic with a minimum at 1, in grids around it, from it on, and beyond which it falls.
#[test]
fn an_extreme_at_an_end_of_a_range_is_found_and_marked() {
    let of = |x: &f64| x * x * x / 3.0 - 0.65 * x * x + 0.3 * x;
    for (grid, lowest, inside) in [
        (&[0.5, 0.9, 1.4, 2.0][..], 1.0, true),
        (&[1.0, 1.5, 2.0], 1.0, false),
        (&[0.9, 1.4, 2.0], 1.0, true),
        (&[2.0, 1.5, 1.0, 0.7, -1.0], -1.0, false),
        (&[0.4, 1.0, 1.6], 1.0, true),
    ] {
        let (found, is_inside) = least(grid, |place| grid[place], Ok, of, 1e-6).expect("no failure");
        assert!((found - lowest).abs() < 1e-3, "{grid:?}: {found}");
        assert_eq!(is_inside, inside, "{grid:?}");
    }
}

/// A model in which friction, restitution or a capacitance is another; without friction the slider leaves its patches.
#[test]
fn a_finding_fails_on_a_mutant_of_each_mechanism() {
    let fails = |(numbers, part, times): (&[&str], &str, f64)| {
        let experiment = EXPERIMENTS.iter().find(|experiment| experiment.numbers == numbers).expect("is one");
        let mutant = |key: &str| if key.contains(part) { times } else { 1.0 };
        let found = experiment.measured(Loader(Some(&mutant)), true).expect("runs");
        let fails = |number: &&&str| found.iter().any(|check| check.number == **number && !check.holds());
        numbers.iter().filter(fails).copied().collect::<Vec<_>>().join(" ")
    };
    let mutants: [(&[&str], _, _); 4] = [
        (&["21", "22", "23", "24"], "friction", 0.0),
        (&["37", "38", "39"], "restitution.at", 0.5),
        (&["42"], "parasitic_capacitance", 0.1),
        (&["31", "32"], "piezo_permittivity", 10.0),
    ];
    assert_eq!(mutants.map(fails), ["21 22 23 24", "38", "42", "31 32"]);
}

#[test]
fn a_draw_has_one_factor_for_what_belongs_together() {
    let of = |key: &str| robustness::factor(7, key);
    assert_eq!(of("stop.position_m"), of("parameters.beam_length_m"));
    assert_eq!(of("parameters.kinetic_friction_inert"), of("parameters.static_friction_inert"));
    assert_ne!(of("stop.length_m"), of("parameters.beam_length_m"));
    assert_ne!(of("stop.gap_m"), robustness::factor(8, "stop.gap_m"));
    for key in ["parameters.beam_modes", "excitation.frequency_hz", "run.settle_s", "scene"] {
        assert_eq!(of(key), 1.0, "{key}");
    }
    let all: Vec<f64> = (0..1000).map(|number| robustness::factor(number, "load.resistance_ohm")).collect();
    assert!(all.iter().all(|factor| (0.8..=1.2).contains(factor)));
    assert!((statistics::mean(all.into_iter()) - 1.0).abs() < 0.015);
}

/// A value that was not measured decides nothing where another fails.
#[test]
fn a_finding_in_a_draw_holds_fails_or_is_unknown() {
    let letter = |values: [f64; 2]| {
        robustness::letter(values.map(|value| check("8", "", [value], Bound::Below(2.0))).iter())
    };
    assert_eq!([[1.0, 1.0], [1.0, 3.0], [f64::NAN, 1.0], [f64::NAN, 3.0]].map(letter), ['y', 'n', 'u', 'n']);
    let text = |letters: &str, mark| Robustness::of(letters, mark).text();
    let (one, many) = ("n", "y".repeat(19));
    assert_eq!(text(&format!("{one}{many}uu"), Mark::Shown), "95 % of 20 draws");
    assert_eq!(text(&format!("nn{many}"), Mark::Chosen), "90 % of 21 draws (at these parameters)");
    assert_eq!(text("nnn", Mark::NotShown), "100 % of 3 draws");
    assert_eq!(text("u", Mark::Shown), "unknown in all draws");
}

/// Draws from the number in the environment variable `DRAW` on.
#[test]
#[ignore = "half a minute of a core for each draw"]
fn stored_draws_are_measured_again() {
    let count = stored("1").len() as u64;
    let from = std::env::var("DRAW").map_or(0, |text| text.parse::<u64>().expect("a number")) % (count - 1);
    for (finding, letters) in drawn(&[], from..from + 2, &|_| {}).expect("all findings") {
        let own: String = stored(finding.number).chars().skip(from as usize).take(2).collect();
        assert_eq!(letters, own, "{} from draw {from} on", finding.number);
    }
}

#[test]
fn draws_of_some_findings_are_the_stored_ones() {
    let found = drawn(&["16".to_owned(), "42".to_owned()], 3..5, &|_| {}).expect("are findings");
    let stored = |finding: &Finding| stored(finding.number)[3..5].to_owned();
    assert!(
        found.len() == 2 && found.iter().all(|(finding, letters)| *letters == stored(finding)),
        "{found:?}"
    );
}

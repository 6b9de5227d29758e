//! The list of known failing cases: a file of CSV with the columns `scene` and `case`.
//!
//! A grid agrees with its list if the same cases fail: a new failing case does not, nor does a listed case that no longer
//! fails. So the list can only shrink.

use std::collections::BTreeSet;
use std::path::Path;

use super::Run;
use crate::method::Failure;
use crate::outcome::csv;

const COLUMNS: [&str; 2] = ["scene", "case"];

/// The list, as scene and case.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Known(BTreeSet<[String; 2]>);

impl Known {
    /// Reads the list from a file.
    ///
    /// # Errors
    /// [`Failure::Input`] if the file cannot be read, has other columns, or names a scene that is not one of `scenes`.
    pub(crate) fn read(file: &Path, scenes: &[&str]) -> Result<Self, Failure> {
        let refuse = |reason: String| Failure::Input(format!("--known {}: {reason}", file.display()));
        let text =
            std::fs::read_to_string(file).map_err(|error| refuse(format!("cannot be read: {error}")))?;
        Self::parse(&text, scenes).map_err(refuse)
    }

    fn parse(text: &str, scenes: &[&str]) -> Result<Self, String> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let heading = reader.headers().map_err(|error| error.to_string())?;
        if *heading != COLUMNS[..] {
            return Err(format!("the columns must be {}", COLUMNS.join(",")));
        }
        let mut cases = BTreeSet::new();
        for row in reader.deserialize() {
            let row: [String; 2] = row.map_err(|error| error.to_string())?;
            if !scenes.contains(&row[0].as_str()) {
                return Err(format!("scene {:?}: must be one of {}", row[0], scenes.join(", ")));
            }
            cases.insert(row);
        }
        Ok(Self(cases))
    }

    /// The list of the runs that failed.
    pub(crate) fn of(runs: &[Run]) -> Self {
        Self(runs.iter().filter(|run| run.is_failure).map(key).collect())
    }

    /// The list as the text of a file.
    pub(crate) fn text(&self) -> String {
        csv(&COLUMNS.join(","), self.0.iter().cloned())
    }

    /// In what the runs differ from the list, one line each. Listed cases of scenes without a run do not count.
    pub(crate) fn differences(&self, runs: &[Run]) -> Vec<String> {
        let failing = Self::of(runs).0;
        let all: BTreeSet<[String; 2]> = runs.iter().map(key).collect();
        let scenes: BTreeSet<&str> = runs.iter().map(|run| run.scene).collect();
        let new = runs.iter().filter(|run| run.is_failure && !self.0.contains(&key(run)));
        let new = new.map(|run| {
            format!("{}: {}: fails and is not in the list; run with {}", run.scene, run.case, run.options)
        });
        let gone = self.0.iter().filter(|[scene, _]| scenes.contains(scene.as_str()));
        let gone = gone.filter(|row| !failing.contains(*row)).map(|row| {
            let [scene, case] = row;
            let reason = if all.contains(row) { "no longer fails" } else { "is no case of this grid" };
            format!("{scene}: {case}: {reason}; remove it from the list")
        });
        new.chain(gone).collect()
    }
}

fn key(run: &Run) -> [String; 2] {
    [run.scene.to_owned(), run.case.clone()]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENES: [&str; 2] = ["sliding", "bump-stop"];

    fn run(scene: &'static str, case: &str, is_failure: bool) -> Run {
        Run { scene, case: case.to_owned(), is_failure, options: "--set a=1".to_owned() }
    }

    fn runs() -> Vec<Run> {
        vec![
            run("sliding", "a=1 precision=f32", true),
            run("sliding", "a=2 precision=f32", false),
            run("sliding", "a=3 precision=f32", true),
        ]
    }

    #[test]
    fn a_list_of_the_runs_that_fail_agrees_with_them_and_survives_its_file() {
        let known = Known::of(&runs());
        assert_eq!(known.text(), "scene,case\nsliding,a=1 precision=f32\nsliding,a=3 precision=f32\n");
        assert_eq!(Known::parse(&known.text(), &SCENES), Ok(known.clone()));
        assert_eq!(known.differences(&runs()), Vec::<String>::new());
        assert_eq!(Known::of(&[]).text(), "scene,case\n");
        assert_eq!(Known::parse("scene,case\n", &SCENES), Ok(Known::of(&[])));
    }

    #[test]
    fn a_failing_case_that_is_not_in_the_list_is_told() {
        let known = Known::of(&runs()[..2]);
        let lines = known.differences(&runs());
        assert_eq!(
            lines,
            ["sliding: a=3 precision=f32: fails and is not in the list; run with --set a=1".to_owned()]
        );
    }

    #[test]
    fn a_listed_case_that_no_longer_fails_or_is_none_of_the_grid_is_to_be_removed() {
        let mut before = runs();
        before[1].is_failure = true;
        before.push(run("sliding", "a=4 precision=f32", true));
        let lines = Known::of(&before).differences(&runs());
        assert_eq!(
            lines,
            [
                "sliding: a=2 precision=f32: no longer fails; remove it from the list",
                "sliding: a=4 precision=f32: is no case of this grid; remove it from the list",
            ]
        );
    }

    #[test]
    fn listed_cases_of_a_scene_that_is_not_run_do_not_count() {
        let mut all = runs();
        all.push(run("bump-stop", "b=1", true));
        assert_eq!(Known::of(&all).differences(&runs()), Vec::<String>::new());
    }

    #[test]
    fn a_file_with_other_columns_or_another_scene_is_refused() {
        for (text, part) in [
            ("", "columns"),
            ("scene,options\nsliding,a=1\n", "columns"),
            ("scene,case\nslidng,a=1\n", "slidng"),
            ("scene,case\nsliding\n", "fields"),
        ] {
            let refused = Known::parse(text, &SCENES).expect_err("refused");
            assert!(refused.contains(part), "{text:?}: {refused}");
        }
    }
}

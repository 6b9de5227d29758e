//! Whether a result is right within what it states, or says that it is not, or is a named error: over grids of stiff
//! and extreme scenes, and over random scenes.
//!
//! A case is a shipped scene with some of its keys changed, so that `run` of the command line runs it too. Its run is
//! judged with its accuracy statement by runs that are more accurate.

mod day;
mod exact;
mod grid;
mod judge;
mod page;
pub(crate) mod random;
mod summary;
mod twin;

use std::fmt::Display;

use crate::method::{Options, Precision};
use crate::scene_file::{self, Override, Scene, SceneError};

pub(crate) use day::{COLUMNS, Compared, DAY_S, pairs};
pub use exact::Quantity;
pub use grid::{Extent, Kind, grid};
pub use judge::{Class, Effort, Finding, Judge, judge};
pub(crate) use page::{CASES, page};
pub use random::{draw, draw_varied};
pub use summary::cause;
pub(crate) use summary::{build, fnv_1a, summary};

/// A shipped scene with changed keys and the options of its run.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// The shipped scene, by its name without ending.
    pub scene: &'static str,
    /// Keys and values that replace those of the shipped scene.
    pub changes: Vec<(String, String)>,
    /// Step in s, of the option `--step`; `None`: the default of the method.
    pub step_s: Option<f64>,
    /// Precision of the run that is judged.
    pub precision: Precision,
}

impl Case {
    /// A case of the shipped scene `scene`, changed by `--set` options, each as `key=value`.
    pub fn of(scene: &'static str, changes: &[&str], precision: Precision) -> Self {
        let pairs = changes.iter().filter_map(|change| change.split_once('='));
        let changes = pairs.map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
        Self { scene, changes, step_s: None, precision }
    }

    /// The scene, as the reader of scene files gives it.
    ///
    /// # Errors
    /// If the reader refuses it.
    pub fn read(&self) -> Result<Scene, SceneError> {
        let overrides: Vec<Override> =
            self.changes.iter().map(|(key, value)| Override::new(key, value)).collect();
        scene_file::read(&scene_file::shipped(self.scene), &overrides)
    }

    /// The options of its run.
    pub fn options(&self) -> Options {
        Options { precision: Some(self.precision), step_s: self.step_s, ..Options::default() }
    }

    /// The arguments with which the command line runs it, quoted for a shell.
    pub fn arguments(&self) -> String {
        let sets: Vec<String> =
            self.changes.iter().map(|(key, value)| format!(" --set '{key}={value}'")).collect();
        let step = self.step_s.map_or_else(String::new, |step_s| format!(" --step {step_s:e}"));
        let precision = self.precision.name();
        format!("run host-bench/scenes/{}.toml --precision {precision}{step}{}", self.scene, sets.concat())
    }

    pub(crate) fn with(mut self, key: &str, value: impl Display) -> Self {
        self.changes.push((key.to_owned(), value.to_string()));
        self
    }

    /// The case with a number for one more key, in the shortest text that reads back to it.
    pub(crate) fn with_number(self, key: &str, value: f64) -> Self {
        self.with(key, format_args!("{value:e}"))
    }

    /// Whether another case differs in nothing but its precision.
    pub(crate) fn is_twin_of(&self, other: &Self) -> bool {
        self.scene == other.scene && self.step_s == other.step_s && self.changes == other.changes
    }

    /// The number that the key of its changes has; `None` if it is not changed to a number.
    pub(crate) fn number(&self, key: &str) -> Option<f64> {
        let (_, value) = self.changes.iter().find(|(changed, _)| changed == key)?;
        value.parse().ok()
    }
}

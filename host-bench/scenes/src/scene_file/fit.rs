//! `[fit]`: data files, free keys and settings of the command `fit`, which may stand in the scene file.

use std::path::PathBuf;

use super::document::{Content, Node, SceneError};
use super::key::{Table, Value, between, other, whole};
use super::section::Section;

pub(super) static TABLE: Table = Table::of(&[
    other("data", Value::Texts, "CSV files of measurements, relative to the scene file").or_said("--data"),
    other("free", Value::FreeKeys, "The keys that are fitted").or_said("--free"),
    other("loss", Value::Words(&["linear", "huber"]), "What is summed of the squared residuals")
        .or_said("linear"),
    whole("starts", "", between(0.0, 1000.0), "Most further starts").or_number(24.0),
]);

/// What `[fit]` says; what is empty or `None` is not there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fit {
    /// Files of measurements; a relative name is relative to the scene file.
    pub data: Vec<PathBuf>,
    /// Free keys, each as `KEY` or `KEY=LOW:HIGH`.
    pub free: Vec<String>,
    /// Whether large residuals count linearly.
    pub huber: Option<bool>,
    /// Most further starts.
    pub starts: Option<usize>,
}

pub(super) fn fit(mut section: Section<'_>) -> Result<Fit, SceneError> {
    let folder = section.file().parent().map(PathBuf::from).unwrap_or_default();
    let data = section.texts("data")?.unwrap_or_default();
    let losses = [("linear", false), ("huber", true)];
    let huber = section.has("loss").then(|| section.choice("loss", &losses)).transpose()?;
    let starts = section.has("starts").then(|| section.whole_number("starts")).transpose()?;
    let fit = Fit {
        data: data.iter().map(|name| folder.join(name)).collect(),
        free: free(&mut section)?,
        huber,
        starts,
    };
    section.finish()?;
    Ok(fit)
}

/// `free`: a list of `"KEY"` and `"KEY=LOW:HIGH"`, or a table of keys, each with `true` or `[LOW, HIGH]`.
fn free(section: &mut Section<'_>) -> Result<Vec<String>, SceneError> {
    const WANTED: &str =
        "must be a list of \"KEY\" or \"KEY=LOW:HIGH\", or a table with true or [LOW, HIGH] for each key";
    match section.content("free") {
        None => Ok(Vec::new()),
        Some(Content::List(items)) => {
            let texts = items.iter().map(|item| item.content.text().map(str::to_owned));
            texts.collect::<Option<_>>().ok_or_else(|| section.refuse("free", WANTED))
        }
        Some(Content::Table(entries)) => {
            let mut all = Vec::new();
            keys("", entries, &mut all).ok_or_else(|| section.refuse("free", WANTED))?;
            Ok(all)
        }
        Some(_) => Err(section.refuse("free", WANTED)),
    }
}

/// Appends the keys of a table and of the tables in it; `None` where a value is neither `true` nor two numbers.
fn keys(prefix: &str, entries: &[(String, Node)], all: &mut Vec<String>) -> Option<()> {
    for (key, node) in entries {
        match &node.content {
            Content::Boolean(true) => all.push(format!("{prefix}{key}")),
            Content::Table(inner) => keys(&format!("{prefix}{key}."), inner, all)?,
            other => {
                let [low, high] = other.pair()?;
                all.push(format!("{prefix}{key}={low:e}:{high:e}"));
            }
        }
    }
    Some(())
}

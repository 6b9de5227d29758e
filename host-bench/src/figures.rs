//! The figures of the two papers, rebuilt on the embedded core: one chapter for each harvester.

pub mod bump_stop;
mod contact_separation;
mod page;
mod sliding;

pub use self::page::page;

use crate::method::Failure;
use crate::scene_file::{self, Excitation, Scene, Tone};

/// A harvester whose figures are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Subject {
    /// Figures 3 to 6 of Fu, Ouyang and Davis (2020), and both sweeps as tables.
    Sliding,
    /// Figures 8 to 11 of Fu, Ouyang and Davis (2020).
    ContactSeparation,
    /// Figures 6 to 10 of Mak, McWilliam, Popov and Fox (2010), and the convergence in modes and step.
    BumpStop,
}

/// One picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Name of its file without the ending.
    pub name: String,
    /// The picture.
    pub svg: String,
}

/// One figure, or a table without pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Its number in the paper, such as `Figure 8`; a name where the paper has none.
    pub label: &'static str,
    /// What it is.
    pub title: &'static str,
    /// What it shows, and the values it holds for.
    pub caption: String,
    /// Its pictures.
    pub panels: Vec<Panel>,
    /// A heading and rows of numbers; empty for a figure without a table.
    pub table: Vec<Vec<String>>,
    /// Its numbers.
    pub csv: String,
}

impl Figure {
    /// Name of the file with its numbers, without the ending.
    #[must_use]
    pub fn stem(&self) -> String {
        self.label.to_lowercase().replace(' ', "-")
    }
}

/// The figures of one harvester.
#[derive(Debug, Clone, PartialEq)]
pub struct Chapter {
    /// Its heading.
    pub title: &'static str,
    /// Text on all of its figures, in HTML paragraphs.
    pub introduction: String,
    /// The figures.
    pub figures: Vec<Figure>,
}

impl Subject {
    /// All of them, in the order of the papers.
    pub const ALL: [Self; 3] = [Self::Sliding, Self::ContactSeparation, Self::BumpStop];

    /// Its name, which is that of its folder.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sliding => "sliding",
            Self::ContactSeparation => "contact-separation",
            Self::BumpStop => "bump-stop",
        }
    }

    /// How often [`Subject::build`] calls `done`.
    #[must_use]
    pub fn runs(self) -> usize {
        match self {
            Self::Sliding => sliding::runs(),
            Self::ContactSeparation => contact_separation::runs(),
            Self::BumpStop => bump_stop::runs(),
        }
    }

    /// Makes its figures from the shipped scenes, on all cores; `done` is called after each run.
    ///
    /// # Errors
    /// If a run fails or a picture cannot be drawn.
    pub fn build(self, done: &(dyn Fn() + Sync)) -> Result<Chapter, Failure> {
        match self {
            Self::Sliding => sliding::build(&shipped("sliding")?, done),
            Self::ContactSeparation => contact_separation::build(&shipped("contact-separation")?, done),
            Self::BumpStop => bump_stop::build(done),
        }
    }
}

/// A shipped scene by the name of its file.
fn shipped(name: &str) -> Result<Scene, Failure> {
    Ok(scene_file::read(&scene_file::shipped(name), &[])?)
}

/// The sine of a scene's base acceleration.
fn sine(scene: &Scene) -> Result<&Tone, Failure> {
    match &scene.excitation {
        Excitation::Sine(tone) => Ok(tone),
        Excitation::Sines(_) | Excitation::File(_) | Excitation::Silence => {
            Err(Failure::of_file(scene, "excitation.kind must be \"sine\""))
        }
    }
}

/// Headings before rows.
fn table<const N: usize>(headings: [&str; N], rows: impl Iterator<Item = [String; N]>) -> Vec<Vec<String>> {
    std::iter::once(headings.map(str::to_owned)).chain(rows).map(Vec::from).collect()
}

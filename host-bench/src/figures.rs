//! The figures of the two papers, rebuilt on the embedded core: one chapter for each harvester.

pub mod bump_stop;
mod contact_separation;
pub(crate) mod sliding;

use crate::attractors::elsewhere;
use crate::method::{Failure, Options};
use crate::outcome::name;
use crate::report::chart::Chart;
use crate::report::file;
use crate::report::page::{Page, escaped};
use crate::report::setting::{margin, named};
use crate::run::{run_scene, try_each};
use crate::scene_file::{self, Excitation, Scene, Tone};

/// A harvester whose figures are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Subject {
    /// Figures 3 to 6 of Fu, Ouyang and Davis (2020), and both sweeps as tables.
    Sliding,
    /// Figures 8 to 11 of Fu, Ouyang and Davis (2020).
    ContactSeparation,
    /// Figures 6 to 11 of Mak, McWilliam, Popov and Fox (2010), and the convergence in modes and step.
    BumpStop,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Name of its file without the ending.
    pub name: String,
    width: u32,
    charts: Vec<Chart>,
}

impl Panel {
    /// Charts one above the other, equally high.
    fn new(
        name: impl Into<String>,
        (width, height): (u32, u32),
        charts: impl IntoIterator<Item = Chart>,
    ) -> Self {
        let mut charts: Vec<Chart> = charts.into_iter().collect();
        let height = height / charts.len().max(1) as u32;
        charts.iter_mut().for_each(|chart| chart.height = height);
        Self { name: name.into(), width, charts }
    }

    /// The picture as SVG text.
    pub fn svg(&self) -> Result<String, Failure> {
        file::svg(self.width, "", &self.charts, None).map_err(Failure::Input)
    }
}

/// One figure, or a table without pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Its number in the paper, such as `Figure 8`; a name where the paper has none.
    pub label: &'static str,
    pub title: &'static str,
    /// What it shows, and the values it holds for.
    pub caption: String,
    pub panels: Vec<Panel>,
    /// A heading and rows of numbers; empty for a figure without a table.
    pub table: Vec<Vec<String>>,
    pub csv: String,
}

impl Figure {
    /// Name of the file with its numbers, without the ending.
    pub fn stem(&self) -> String {
        self.label.to_lowercase().replace(' ', "-")
    }
}

/// The figures of one harvester.
#[derive(Debug, Clone, PartialEq)]
pub struct Chapter {
    pub title: &'static str,
    /// Text on all of its figures, in HTML paragraphs.
    pub introduction: String,
    /// Runs whose starts are displaced in search of other motions.
    pub(crate) points: Vec<(Scene, Options)>,
    pub figures: Vec<Figure>,
}

impl Subject {
    /// Its name, which is that of its folder.
    pub(crate) fn name(self) -> String {
        name(&self)
    }

    /// The shipped scenes that [`Subject::build`] reads.
    pub fn scenes(self) -> Vec<&'static str> {
        match self {
            Self::Sliding => vec!["sliding"],
            Self::ContactSeparation => vec!["contact-separation"],
            Self::BumpStop => bump_stop::scenes().collect(),
        }
    }

    /// How often [`Subject::build`] calls `done`.
    pub fn runs(self) -> usize {
        match self {
            Self::Sliding => sliding::runs(),
            Self::ContactSeparation => contact_separation::runs(),
            Self::BumpStop => bump_stop::runs(),
        }
    }

    /// Makes its figures from the shipped scenes, on all cores; `done` is called after each run. A `single_start` has no displaced ones.
    pub fn build(self, single_start: bool, done: &(dyn Fn() + Sync)) -> Result<Chapter, Failure> {
        let mut chapter = match self {
            Self::Sliding => sliding::build(&shipped("sliding")?, done),
            Self::ContactSeparation => contact_separation::build(&shipped("contact-separation")?, done),
            Self::BumpStop => bump_stop::build(done),
        }?;
        let scenes = self.scenes();
        let outcomes = try_each(&scenes, |name| run_scene(&shipped(name)?, &Options::default()))?;
        for (name, outcome) in scenes.iter().zip(outcomes) {
            chapter.introduction += &format!("<p>{name}{}</p>\n", margin(named(&outcome.margins)));
        }
        if !single_start {
            for warning in elsewhere(&chapter.points)?.into_iter().flatten() {
                chapter.introduction += &format!("<p>{warning}</p>\n");
            }
        }
        Ok(chapter)
    }
}

/// Runs each case on all cores; calls `done` after each.
fn try_each_counted<C: Sync, R: Send>(
    cases: &[C],
    done: &(dyn Fn() + Sync),
    run: impl Fn(&C) -> Result<R, Failure> + Sync,
) -> Result<Vec<R>, Failure> {
    let one = |case: &C| {
        let found = run(case);
        done();
        found
    };
    try_each(cases, one)
}

fn shipped(name: &str) -> Result<Scene, Failure> {
    Ok(scene_file::read_shipped(name, &[])?)
}

fn sine(scene: &Scene) -> Result<&Tone, Failure> {
    match &scene.excitation {
        Excitation::Sine(tone) => Ok(tone),
        _ => Err(Failure::of_file(scene, "excitation.kind must be \"sine\"")),
    }
}

fn table<const N: usize>(headings: [&str; N], rows: impl Iterator<Item = [String; N]>) -> Vec<Vec<String>> {
    std::iter::once(headings.map(str::to_owned)).chain(rows).map(Vec::from).collect()
}

/// The page of a chapter; pictures are in it, numbers in files beside it.
pub fn page(chapter: &Chapter) -> Result<String, Failure> {
    let mut page = Page::new(chapter.title);
    page.add(&chapter.introduction);
    for figure in &chapter.figures {
        let panel = |panel: &Panel| Ok(format!("<figure>{}</figure>\n", panel.svg()?.trim_end()));
        let panels = figure.panels.iter().map(panel).collect::<Result<String, Failure>>()?;
        page.add(&format!(
            "<h2>{}. {}</h2>\n<div class=\"panels\">\n{}</div>\n<p>{}</p>\n",
            figure.label,
            escaped(figure.title),
            panels,
            escaped(&figure.caption)
        ));
        page.table_of(&figure.table, 0);
        let links = figure.panels.iter().map(|panel| format!("{}.svg", panel.name));
        let files = std::iter::once(format!("{}.csv", figure.stem())).chain(links);
        let links: Vec<String> = files.map(|file| format!("<a href=\"{file}\">{file}</a>")).collect();
        page.add(&format!("<p class=\"note\">{}</p>\n", links.join(" · ")));
    }
    Ok(page.html())
}

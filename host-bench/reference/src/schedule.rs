//! The stretches of a run: each lasts until an event, a kink of the base acceleration, the start of the
//! measuring window or the end of the run.

use harvester_scene::base_motion::{Base, LocalBase};
use harvester_scene::scene_file::{RunSpan, Scene};

/// Events in a row without progress after which a run is given up.
const STORM: u32 = 10_000;

pub(super) struct Schedule<'a> {
    base: Base<'a>,
    /// Whether the base acceleration of a stretch is a few sines and a polynomial.
    in_pieces: bool,
    run: RunSpan,
    /// Longest stretch in s.
    longest: f64,
    /// Time in s that counts as progress between events.
    progress: f64,
    /// Time in s that the run has reached.
    pub(super) time: f64,
    storm: u32,
    storm_began: f64,
}

/// The next stretch, as long as no event ends it.
pub(super) struct Stretch {
    /// Start in s.
    pub(super) start: f64,
    /// Length in s.
    pub(super) span: f64,
    /// End in s.
    end: f64,
    /// Whether the stretch lies in the measuring window.
    pub(super) in_window: bool,
    /// Base acceleration from the start on.
    pub(super) base: LocalBase,
}

impl<'a> Schedule<'a> {
    /// The run of a scene, in stretches of at most `longest` seconds.
    pub(super) fn new(scene: &'a Scene, in_pieces: bool, longest: f64, progress: f64) -> Self {
        let base = Base(&scene.excitation);
        Self { base, in_pieces, run: scene.run, longest, progress, time: 0.0, storm: 0, storm_began: 0.0 }
    }

    /// The next stretch; `None` at the end of the run.
    pub(super) fn next(&mut self) -> Option<Stretch> {
        while self.time < self.run.duration_s {
            let start = self.time;
            let in_window = start >= self.run.settle_s;
            let boundary = if in_window { self.run.duration_s } else { self.run.settle_s };
            let base = if self.in_pieces { self.base.pieces_from(start) } else { self.base.from(start) };
            let span = (boundary - start).min(base.smooth_for()).min(self.longest);
            // A span lost in the rounding of absolute time is skipped.
            if span <= 8.0 * f64::EPSILON * start {
                self.time = boundary.min(start + span.max(f64::EPSILON * start));
                continue;
            }
            let end = if span == boundary - start { boundary } else { start + span };
            return Some(Stretch { start, span, end, in_window, base });
        }
        None
    }

    /// Goes to the end of a stretch, or to the event so many seconds after its start.
    ///
    /// # Errors
    /// If events follow each other without progress.
    pub(super) fn advance(&mut self, stretch: &Stretch, event: Option<f64>) -> Result<(), String> {
        let Some(elapsed) = event else {
            self.time = stretch.end;
            return Ok(());
        };
        self.time = (stretch.start + elapsed).min(stretch.end);
        if self.time > self.storm_began + self.progress {
            (self.storm, self.storm_began) = (0, self.time);
        }
        self.storm += 1;
        if self.storm > STORM {
            return Err(format!("event storm: {STORM} events within {:.1e} s", self.progress));
        }
        Ok(())
    }
}

/// Records the rows that fall due.
pub(super) struct Recorder {
    every: f64,
    pub(super) rows: Vec<Vec<f64>>,
}

impl Recorder {
    /// Records a row every so many seconds, from time zero on.
    pub(super) fn new(every: f64) -> Self {
        Self { every, rows: Vec::new() }
    }

    /// Records the rows that are due until `time` in s; `at` makes the row of a time in s.
    pub(super) fn until(&mut self, time: f64, mut at: impl FnMut(f64) -> Vec<f64>) {
        loop {
            let due = self.rows.len() as f64 * self.every;
            // Rounding may place the row at the end of the run just after the end.
            if due > time * (1.0 + 4.0 * f64::EPSILON) {
                return;
            }
            self.rows.push(at(due));
        }
    }
}

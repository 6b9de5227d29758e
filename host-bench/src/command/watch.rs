//! What a long computation tells on standard error while it runs; and `--quiet`.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use harvester_scene::progress;

use super::tell;

/// Time from one line to the next, and before the first.
pub(super) const EVERY: Duration = Duration::from_secs(3);

/// Time from one look at the progress to the next.
const LOOK: Duration = Duration::from_millis(100);

/// Whether only errors and warnings are told.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Tells errors and warnings only from here on.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a line on standard error that is neither an error nor a warning.
pub(crate) fn note(line: &str) {
    if !is_quiet() {
        tell(line);
    }
}

/// Tells every few seconds how far the runs of this process are, until it is dropped.
pub(crate) struct Watch {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Watch {
    pub(crate) fn new() -> Self {
        if is_quiet() {
            return Self { stop: None, thread: None };
        }
        let (stop, stopped) = mpsc::channel::<()>();
        let (before, ..) = progress::read();
        let thread = thread::spawn(move || {
            let (mut run, mut began, mut told) = (before, Instant::now(), Instant::now());
            // The sender is dropped where the watch is.
            while stopped.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                let (runs, part, done) = progress::read();
                if runs != run {
                    (run, began) = (runs, Instant::now());
                }
                if told.elapsed() >= EVERY {
                    told = Instant::now();
                    tell(&line(run.saturating_sub(before).max(1), part, done, began.elapsed().as_secs_f64()));
                }
            }
        });
        Self { stop: Some(stop), thread: Some(thread) }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A display that panicked has nothing more to show.
            let _ = thread.join();
        }
    }
}

/// How far a run is, what it does in a second, and how long it will take if it goes on like that.
fn line(run: u64, part: f64, done: [u64; 2], elapsed_s: f64) -> String {
    let to_go = if part > 0.0 && elapsed_s > 0.0 {
        format!(", about {:.0} s to go", elapsed_s * (1.0 - part) / part)
    } else {
        String::new()
    };
    let [steps, events] = done.map(|count| count as f64 / elapsed_s.max(f64::MIN_POSITIVE));
    let rates = format!("{steps:.0} steps and {events:.0} events a second");
    format!("run {run}: {:.1} % done, {elapsed_s:.0} s elapsed{to_go}; {rates}", 100.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_to_go_follows_from_the_part_that_is_done() {
        let quarter = "run 1: 25.0 % done, 10 s elapsed, about 30 s to go; 500 steps and 2 events a second";
        assert_eq!(line(1, 0.25, [5000, 20], 10.0), quarter);
        assert_eq!(
            line(2, 0.0, [0, 0], 3.0),
            "run 2: 0.0 % done, 3 s elapsed; 0 steps and 0 events a second"
        );
    }
}

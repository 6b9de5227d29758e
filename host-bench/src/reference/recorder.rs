//! Rows of a recording at equal distances in time.

/// Takes down rows that fall due.
#[derive(Debug)]
pub(super) struct Recorder {
    every: f64,
    next: u64,
    pub(super) rows: Vec<Vec<f64>>,
}

impl Recorder {
    /// With a row every so many seconds, from time zero on.
    pub(super) fn new(every: f64) -> Self {
        Self { every, next: 0, rows: Vec::new() }
    }

    /// Takes down the rows that are due until `time` in s; `at` makes one.
    pub(super) fn until<E>(&mut self, time: f64, at: impl Fn(f64) -> Result<Vec<f64>, E>) -> Result<(), E> {
        loop {
            let due = self.next as f64 * self.every;
            // A row due at the end of the run may be computed as just after it.
            if due > time * (1.0 + 4.0 * f64::EPSILON) {
                return Ok(());
            }
            self.rows.push(at(due)?);
            self.next += 1;
        }
    }
}

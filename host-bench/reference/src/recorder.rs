//! Rows of a recording at equal distances in time.

/// Records the rows that fall due.
#[derive(Debug)]
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
    pub(super) fn until<E>(
        &mut self,
        time: f64,
        mut at: impl FnMut(f64) -> Result<Vec<f64>, E>,
    ) -> Result<(), E> {
        loop {
            let due = self.rows.len() as f64 * self.every;
            // Rounding may place the row at the end of the run just after the end.
            if due > time * (1.0 + 4.0 * f64::EPSILON) {
                return Ok(());
            }
            self.rows.push(at(due)?);
        }
    }
}

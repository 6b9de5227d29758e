//! Samples in a column of a CSV file, and the times in another.

use std::path::Path;

use csv::{Position, ReaderBuilder, StringRecord, Trim};

use super::{Column, TraceFault, enough, scaled};

/// Intervals between two samples by which a time may be off: the rounding of a printed time, and no more.
const UNEVEN: f64 = 0.25;

/// A column that is looked for by the key `key`.
struct Wanted<'a> {
    key: &'static str,
    column: &'a Column,
    /// Its place from 0, once it is known.
    index: Option<usize>,
}

impl<'a> Wanted<'a> {
    fn new(key: &'static str, column: &'a Column) -> Self {
        let index = match column {
            Column::Number(number) => Some(number - 1),
            Column::Name(_) => None,
        };
        Self { key, column, index }
    }

    /// Finds a column of this name in the first row, `record`; whether it was looked for.
    fn find(&mut self, record: &StringRecord, line: u64) -> Result<bool, TraceFault> {
        let Column::Name(name) = self.column else { return Ok(false) };
        self.index = record.iter().position(|cell| plain(cell) == name);
        if self.index.is_some() {
            return Ok(true);
        }
        let heads: Vec<&str> = record.iter().take(20).collect();
        Err(TraceFault::new(self.key, format!("line {line}: no such column in {heads:?}")))
    }

    /// The number in a row; `None` if it is none, with the cell.
    fn number<'r>(&self, record: &'r StringRecord, line: u64) -> Result<Result<f64, &'r str>, TraceFault> {
        let cell = self.index.and_then(|index| record.get(index)).ok_or_else(|| {
            TraceFault::new(self.key, format!("line {line}: there are {} columns", record.len()))
        })?;
        Ok(plain(cell).parse().map_err(|_| cell))
    }
}

/// A cell without the mark that begins some files.
fn plain(cell: &str) -> &str {
    cell.trim_start_matches('\u{feff}')
}

/// The samples of one column in m/s²; where `clock` names a column of times in s, these are checked to follow
/// one another at `rate_hz`.
pub(super) fn samples(
    path: &Path,
    column: &Column,
    scale: f64,
    clock: Option<&Column>,
    rate_hz: f64,
) -> Result<Vec<f64>, TraceFault> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_path(path)
        .map_err(|error| one_line(&error))?;
    let mut sample = Wanted::new("column", column);
    let mut time = clock.map(|column| Wanted::new("time_column", column));
    let mut samples = Vec::new();
    let mut first_time = 0.0;
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|error| one_line(&error))?;
        let line = record.position().map_or(0, Position::line);
        if row == 0 {
            let named = sample.find(&record, line)?;
            let named_time = time.as_mut().map_or(Ok(false), |time| time.find(&record, line))?;
            if named || named_time {
                continue;
            }
        }
        let value = match sample.number(&record, line)? {
            Ok(value) => value,
            // A heading.
            Err(_) if row == 0 => continue,
            Err(cell) => {
                return Err(TraceFault::new("path", format!("line {line}: {cell:?} is not a number")));
            }
        };
        if let Some(time) = &time {
            let now = time
                .number(&record, line)?
                .map_err(|cell| TraceFault::new("path", format!("line {line}: {cell:?} is not a number")))?;
            if samples.is_empty() {
                first_time = now;
            }
            let due = first_time + samples.len() as f64 / rate_hz;
            // Not-a-number is refused too.
            if !((now - due).abs() * rate_hz <= UNEVEN) {
                let text = format!("line {line}: time {now} s must be {due} s, as at rate_hz = {rate_hz}");
                return Err(TraceFault::new("time_column", text));
            }
        }
        samples.push(scaled(value, scale, || format!("line {line}"))?);
    }
    enough(&samples, &format!("line {}", reader.position().line()))?;
    Ok(samples)
}

/// Messages of the CSV reader have no line breaks, but name the file's content.
fn one_line(error: &csv::Error) -> TraceFault {
    TraceFault::new("path", error.to_string().replace(['\n', '\r'], " "))
}

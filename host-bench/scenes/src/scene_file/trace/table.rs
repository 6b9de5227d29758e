//! Samples in a column of a CSV file, and the times in another.

mod layout;

use std::path::Path;

use csv::{Position, ReaderBuilder, StringRecord, Trim};

use self::layout::{Clock, Layout};
use super::clock::Times;
use super::number::{Delimiter, Numbers};
use super::{Asked, RESAMPLED, Samples, TraceFault, enough, scaled};
use crate::input::{self, MOST_OF_DATA};
use crate::scene_file::key::Bound;

/// The samples in m/s² and their rate in Hz, within `bound`: that of the times where the file has them.
pub(super) fn samples(path: &Path, asked: &Asked, bound: Bound) -> Result<Samples, TraceFault> {
    let text = input::text(path, MOST_OF_DATA).map_err(|error| TraceFault::new("path", error.to_string()))?;
    // The mark that begins some files.
    let text = text.trim_start_matches('\u{feff}');
    let delimiter = Delimiter::of(text);
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .delimiter(delimiter.byte())
        .trim(Trim::All)
        .from_reader(text.as_bytes());
    let mut rows =
        Rows { numbers: Numbers::new(delimiter), samples: Vec::new(), times: Some(Times::default()) };
    let mut layout: Option<Layout> = None;
    for record in reader.records() {
        let record = record.map_err(|error| one_line(&error))?;
        let line = record.position().map_or(0, Position::line);
        let layout = match &layout {
            Some(layout) => layout,
            None => {
                let found = layout.insert(Layout::of(&record, line, asked)?);
                if found.has_heading {
                    continue;
                }
                found
            }
        };
        rows.push(layout, &record, line)?;
    }
    enough(&rows.samples, &format!("line {}", reader.position().line()))?;
    // A file without a row has too few samples.
    let Some(layout) = layout else { return Ok((rows.samples, f64::NAN, None)) };
    timed(&layout, rows, asked, bound)
}

/// The rows that were read.
struct Rows {
    numbers: Numbers,
    samples: Vec<f64>,
    /// `None` where a column that might have had times has something else.
    times: Option<Times>,
}

impl Rows {
    fn push(&mut self, layout: &Layout, record: &StringRecord, line: u64) -> Result<(), TraceFault> {
        layout.check_width(record, line)?;
        let cell = cell(record, layout.sample, "column", line)?;
        let value = self
            .numbers
            .read(cell)
            .map_err(|reason| TraceFault::new("path", format!("line {line}: {reason}")))?;
        if let (Some(clock), Some(times)) = (layout.clock, &mut self.times) {
            let cell = self::cell(record, clock.column, clock.key, line)?;
            match self.numbers.read(cell) {
                Ok(time) => {
                    times.seconds.push(time * clock.unit_s);
                    times.lines.push(line);
                }
                Err(_) if !clock.is_named => self.times = None,
                Err(reason) => {
                    let fault = TraceFault::new("path", format!("line {line}: {reason}"));
                    return Err(clock.with_way_out(fault));
                }
            }
        }
        self.samples.push(scaled(value, layout.scale, || format!("line {line}"))?);
        Ok(())
    }
}

/// The cell of a column, from 0, which the key `key` asked for.
fn cell<'r>(
    record: &'r StringRecord,
    column: usize,
    key: &'static str,
    line: u64,
) -> Result<&'r str, TraceFault> {
    let absent = || TraceFault::new(key, format!("line {line}: there are {} columns", record.len()));
    record.get(column).ok_or_else(absent)
}

/// The samples at the rate of the times, at that which is stated, or at even times.
fn timed(layout: &Layout, rows: Rows, asked: &Asked, bound: Bound) -> Result<Samples, TraceFault> {
    let Rows { samples, times, .. } = rows;
    let wanted = || match asked.resampling {
        None => TraceFault::missing("rate_hz", format!("{bound}, or the file have a column of times")),
        Some(_) => TraceFault::new(RESAMPLED, "must have a column of times".to_owned()),
    };
    let (Some(clock), Some(times)) = (layout.clock, times) else {
        layout.check_sample(asked, false)?;
        return Ok((samples, asked.rate_hz.ok_or_else(wanted)?, None));
    };
    // The first column of a table without headings has times if it rises. A count of the rows has no rate.
    let is_time = clock.is_named || times.rise();
    layout.check_sample(asked, is_time)?;
    if !clock.is_named && (!is_time || times.count()) {
        return Ok((samples, asked.rate_hz.ok_or_else(wanted)?, None));
    }
    let key = blamed(clock, asked);
    let Some(resampling) = asked.resampling else {
        let rate = times.rate(asked.rate_hz, bound, key).map_err(|fault| clock.with_way_out(fault));
        return Ok((samples, rate?, None));
    };
    times.resampled(&samples, resampling, key)
}

/// The key to blame for times that do not agree with it or with one another.
fn blamed(clock: Clock, asked: &Asked) -> &'static str {
    match (clock.is_stated, asked.rate_hz) {
        (true, _) => "time_column",
        (false, Some(_)) => "rate_hz",
        (false, None) => "path",
    }
}

/// Messages of the CSV reader have no line breaks, but name the file's content.
fn one_line(error: &csv::Error) -> TraceFault {
    TraceFault::new("path", error.to_string().replace(['\n', '\r'], " "))
}

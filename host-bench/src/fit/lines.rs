//! The rows of a file that belong together, and the model between them as fine lines for the picture.

use super::data::{Data, Direction, Row, Rows};
use super::model::{Problem, at_row, quantity, steady};
use crate::embedded::Memory;
use crate::method::{Failure, Options};
use crate::report::setting::with_unit;
use crate::run::each;

/// Most frequencies of the fine lines of one file, and most between two rows.
const MOST: usize = 300;
const MOST_BETWEEN: usize = 10;

/// Rows of one amplitude, load and direction, in the order of their frequencies; all rows of a trace.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Group {
    /// What distinguishes it; empty of one alone.
    pub(crate) name: String,
    pub(crate) rows: Vec<usize>,
}

/// Frequencies in Hz and values of the model.
pub(crate) type Line = Vec<(f64, f64)>;

/// The groups of a file, in the order in which they begin.
pub(crate) fn groups(data: &Data) -> Vec<Group> {
    let Rows::Sweep(rows) = &data.rows else {
        return vec![Group { name: String::new(), rows: (0..data.count()).collect() }];
    };
    let mut all: Vec<Vec<usize>> = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        match all.iter_mut().find(|group| is_like(&rows[group[0]], row)) {
            Some(group) => group.push(index),
            None => all.push(vec![index]),
        }
    }
    for group in &mut all {
        group.sort_by(|&one, &other| rows[one].frequency_hz.total_cmp(&rows[other].frequency_hz));
    }
    let firsts: Vec<Row> = all.iter().map(|group| rows[group[0]]).collect();
    all.into_iter().map(|group| Group { name: name(&rows[group[0]], &firsts), rows: group }).collect()
}

fn is_like(one: &Row, other: &Row) -> bool {
    (one.amplitude_m_per_s2, one.resistance_ohm, one.direction)
        == (other.amplitude_m_per_s2, other.resistance_ohm, other.direction)
}

/// What distinguishes a row from those of the other groups.
fn name(row: &Row, all: &[Row]) -> String {
    let amplitude = row.amplitude_m_per_s2.map(|value| with_unit(value, "m/s²"));
    let resistance = row.resistance_ohm.map(|value| with_unit(value, "Ω"));
    let direction = row.direction.map(|direction| match direction {
        Direction::Up => "up".to_owned(),
        Direction::Down => "down".to_owned(),
    });
    let differs = [
        all.iter().any(|other| other.amplitude_m_per_s2 != row.amplitude_m_per_s2),
        all.iter().any(|other| other.resistance_ohm != row.resistance_ohm),
        all.iter().any(|other| other.direction != row.direction),
    ];
    let parts = [amplitude, resistance, direction].into_iter().zip(differs);
    parts.filter_map(|(part, differs)| part.filter(|_| differs)).collect::<Vec<_>>().join(", ")
}

/// For each group and column the model from the lowest to the highest frequency. A value is not a number where the model
/// fails. A trace has no lines, since its rows are close together.
pub(crate) fn lines(
    problem: &Problem<'_>,
    at: &[f64],
    options: &Options,
    file: usize,
) -> Result<Vec<Vec<Line>>, Failure> {
    let data = &problem.data[file];
    let Rows::Sweep(rows) = &data.rows else { return Ok(Vec::new()) };
    let scene = problem.scene(at)?;
    let groups = groups(data);
    let intervals: usize = groups.iter().map(|group| group.rows.len().saturating_sub(1)).sum();
    let between = (MOST / intervals.max(1)).clamp(1, MOST_BETWEEN);
    let of_group = |group: &Group| -> Vec<Line> {
        let first = rows[group.rows[0]];
        let values = |frequency_hz: f64, memory: Option<&Memory>| -> (Vec<f64>, Option<Memory>) {
            let row = Row { frequency_hz, ..first };
            let found = at_row(&scene, &row).and_then(|scene| steady(&scene, options, memory));
            let of = |name: &str, found: &Result<_, Failure>| match found {
                Ok((outcome, _)) => quantity(outcome, name).unwrap_or(f64::NAN),
                Err(_) => f64::NAN,
            };
            let columns = data.columns.iter().map(|column| of(&column.name, &found)).collect();
            (columns, found.ok().and_then(|(_, motion)| motion))
        };
        let mut frequencies = frequencies(rows, group, between);
        let mut found: Vec<Vec<f64>> = match first.direction {
            // Each frequency alone, as the rows are.
            None => each(&frequencies, |&frequency| values(frequency, None).0),
            Some(direction) => {
                if direction == Direction::Down {
                    frequencies.reverse();
                }
                let mut last = None;
                let chain = frequencies.iter().map(|&frequency| {
                    let (columns, motion) = values(frequency, last.as_ref());
                    last = motion;
                    columns
                });
                chain.collect()
            }
        };
        if first.direction == Some(Direction::Down) {
            frequencies.reverse();
            found.reverse();
        }
        let of_column = |column: usize| {
            frequencies.iter().zip(&found).map(|(&frequency, columns)| (frequency, columns[column])).collect()
        };
        (0..data.columns.len()).map(of_column).collect()
    };
    Ok(each(&groups, of_group))
}

/// The frequencies of a group, each interval divided into so many parts.
fn frequencies(rows: &[Row], group: &Group, between: usize) -> Vec<f64> {
    let mut own: Vec<f64> = group.rows.iter().map(|&row| rows[row].frequency_hz).collect();
    own.dedup();
    let inner = own.windows(2).flat_map(|pair| {
        (0..between).map(move |part| pair[0] + (pair[1] - pair[0]) * part as f64 / between as f64)
    });
    inner.chain(own.last().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::data::Column;

    fn row(frequency_hz: f64, amplitude: f64, direction: Option<Direction>) -> Row {
        Row { frequency_hz, amplitude_m_per_s2: Some(amplitude), resistance_ohm: None, direction }
    }

    #[test]
    fn rows_of_one_amplitude_and_direction_are_a_group_in_the_order_of_frequency() {
        let rows = vec![
            row(20.0, 1.0, Some(Direction::Down)),
            row(19.0, 1.0, Some(Direction::Down)),
            row(19.0, 2.0, Some(Direction::Up)),
            row(21.0, 2.0, Some(Direction::Up)),
        ];
        let columns = vec![Column { name: "rms_voltage_v".to_owned(), values: vec![0.0; 4], std: None }];
        let data =
            Data { file: "sweep.csv".into(), rows: Rows::Sweep(rows.clone()), columns, lines: Vec::new() };
        let found = groups(&data);
        let names: Vec<&str> = found.iter().map(|group| group.name.as_str()).collect();
        assert_eq!(names, ["1 m/s², down", "2 m/s², up"]);
        assert_eq!((&found[0].rows[..], &found[1].rows[..]), (&[1, 0][..], &[2, 3][..]));
        assert_eq!(frequencies(&rows, &found[1], 4), [19.0, 19.5, 20.0, 20.5, 21.0]);
        let alone = Data { rows: Rows::Sweep(rows[..2].to_vec()), ..data };
        assert_eq!(groups(&alone)[0].name, "");
    }
}

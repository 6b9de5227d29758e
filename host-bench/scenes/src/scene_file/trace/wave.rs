//! Samples of one channel of a WAV file.

use std::path::Path;

use hound::{SampleFormat, WavReader};

use super::{Column, TraceFault, enough, scaled};
use crate::input::{MOST_OF_DATA, read};
use crate::scene_file::key::Bound;

/// The samples of one channel, the only one if none is named, in m/s² and their rate in Hz, within `bound`, which must be `stated` if that is given.
/// Integers are taken as parts of full scale, `2^(bits − 1)`.
pub(super) fn samples(
    path: &Path,
    channel: Option<&Column>,
    scale: f64,
    stated: Option<f64>,
    bound: Bound,
) -> Result<(Vec<f64>, f64), TraceFault> {
    let fault = |error: hound::Error| TraceFault::new("path", error.to_string().replace(['\n', '\r'], " "));
    let bytes = read(path, MOST_OF_DATA).map_err(|error| TraceFault::new("path", error.to_string()))?;
    let mut reader = WavReader::new(bytes.as_slice()).map_err(fault)?;
    let spec = reader.spec();
    let channels = usize::from(spec.channels);
    let channel = match channel {
        None if channels == 1 => 0,
        None => {
            let wanted = format!("the number of a channel, from 1 to {channels}");
            return Err(TraceFault::missing("column", wanted));
        }
        Some(Column::Number(number)) if *number <= channels => number - 1,
        Some(_) => {
            let text = format!("of a WAV file must be the number of a channel, from 1 to {channels}");
            return Err(TraceFault::new("column", text));
        }
    };
    let rate_hz = f64::from(spec.sample_rate);
    if !bound.contains(rate_hz) {
        return Err(TraceFault::new("path", format!("has {rate_hz} samples per second: must be {bound}")));
    }
    if stated.is_some_and(|stated| stated != rate_hz) {
        return Err(TraceFault::new("rate_hz", format!("must be {rate_hz} as in the file, or left out")));
    }
    let full_scale = match spec.sample_format {
        SampleFormat::Float => 1.0,
        SampleFormat::Int => f64::from(spec.bits_per_sample.saturating_sub(1)).exp2(),
    };
    let mut samples = Vec::new();
    let mut keep = |place: usize, value: f64| {
        let frame = place / channels;
        if place % channels == channel {
            samples.push(scaled(value, scale, || format!("frame {frame}"))?);
        }
        Ok(())
    };
    match spec.sample_format {
        SampleFormat::Float => {
            for (place, value) in reader.samples::<f32>().enumerate() {
                keep(place, f64::from(value.map_err(fault)?))?;
            }
        }
        SampleFormat::Int => {
            for (place, value) in reader.samples::<i32>().enumerate() {
                keep(place, f64::from(value.map_err(fault)?) / full_scale)?;
            }
        }
    }
    enough(&samples, &format!("frame {}", samples.len()))?;
    Ok((samples, rate_hz))
}

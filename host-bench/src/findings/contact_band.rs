//! The impacting band of contact-separation over frequency: findings 33 to 36, 40, 41 and 43.

use super::scenes::{Changes, each, run, value};
use super::statistics::{largest, smallest};
use super::{Bound, Check, Measured};
use crate::method::Failure;

/// Lowest frequency in Hz, distance and number of the frequencies.
const FIRST_HZ: f64 = 18.0;
const EVERY_HZ: f64 = 0.05;
const COUNT: u32 = 81;
/// Charge densities in C/m².
const CHARGE_DENSITIES: [&str; 4] = ["5e-6", "20e-6", "35e-6", "50e-6"];
/// Runs from rest, measured from 10 to 15 s as the scene is shipped.
const SHIPPED: Changes<'static> = &[];
const GAP_FIELD: Changes<'static> = &[("parameters.force_law", "gap-field")];

/// The largest gap over frequency, each frequency from rest.
struct Band {
    /// Largest gap in m in the window of each frequency.
    peaks: Vec<f64>,
    /// First and last frequency in Hz with an impact; not-a-number without one, or if a number of impacts is.
    edges: [f64; 2],
}

impl Band {
    fn new(points: &[(f64, f64, f64)]) -> Self {
        let impacting = || {
            let with = points.iter().filter(|(_, _, impacts)| *impacts != 0.0);
            with.map(|(frequency, _, impacts)| if impacts.is_nan() { f64::NAN } else { *frequency })
        };
        Self {
            peaks: points.iter().map(|(_, peak, _)| *peak).collect(),
            edges: [smallest(impacting()), largest(impacting())],
        }
    }

    fn width(&self) -> f64 {
        self.edges[1] - self.edges[0]
    }

    /// Largest gap in mm over all frequencies.
    fn peak_mm(&self) -> f64 {
        1e3 * largest(self.peaks.iter().copied())
    }

    /// Largest relative difference of the gap over frequency.
    fn difference(&self, other: &Self) -> f64 {
        largest(self.peaks.iter().zip(&other.peaks).map(|(one, other)| (one / other - 1.0).abs()))
    }
}

/// The bands for charge densities and resistances, with these keys changed.
fn bands(cases: &[(&str, &str)], changes: Changes<'_>) -> Result<Vec<Band>, Failure> {
    let points: Vec<(&str, &str, u32)> = cases
        .iter()
        .flat_map(|(density, resistance)| (0..COUNT).map(|index| (*density, *resistance, index)))
        .collect();
    let found = each(&points, |(density, resistance, index)| {
        let frequency_hz = FIRST_HZ + EVERY_HZ * f64::from(*index);
        let frequency = format!("{frequency_hz}");
        let case = [
            ("parameters.charge_density_c_per_m2", *density),
            ("load.resistance_ohm", *resistance),
            ("excitation.frequency_hz", frequency.as_str()),
        ];
        let outcome = run("contact-separation", &[&case[..], changes].concat())?;
        let motion = outcome.contact_separation();
        let peak = value(motion.and_then(|motion| motion.peak_gap_m));
        Ok((frequency_hz, peak, value(motion.map(|motion| motion.impacts as f64))))
    })?;
    Ok(found.chunks(COUNT as usize).map(Band::new).collect())
}

/// Findings 33 to 36, 40, 41, 43, and b.
pub(super) fn measure() -> Result<Measured, Failure> {
    let [least, .., most] = CHARGE_DENSITIES;
    let of = |resistance: &'static str| CHARGE_DENSITIES.map(|density| (density, resistance));
    let high = bands(&of("1e8"), SHIPPED)?;
    let low = bands(&of("1e6"), SHIPPED)?;
    let middle = bands(&[(least, "1e7"), (most, "1e7")], SHIPPED)?;
    let energy = bands(&[(least, "1e8"), (most, "1e8")], GAP_FIELD)?;
    let peaks = |bands: &[Band]| bands.iter().map(Band::peak_mm).collect::<Vec<_>>();
    let edges = |bands: &[Band], edge: usize| bands.iter().map(|band| band.edges[edge]).collect::<Vec<_>>();
    let ends = |bands: &[Band]| [bands[0].peak_mm(), bands[bands.len() - 1].peak_mm()];
    let ratio = |bands: &[Band]| ends(bands)[1] / ends(bands)[0];
    let widening = |bands: &[Band]| bands[bands.len() - 1].width() - bands[0].width();
    let last = high.len() - 1;
    // Small charge, then large charge, at 1, 10 and 100 MΩ.
    let small = [&low[0], &middle[0], &high[0]];
    let large = [&low[last], &middle[1], &high[last]];
    let differences = |of: [&Band; 3]| [of[1].difference(of[0]), of[2].difference(of[0])];
    let same_edges = small
        .map(|band| (band.edges[0] - small[0].edges[0]).abs() + (band.edges[1] - small[0].edges[1]).abs());
    let same_peaks = small.map(|band| (band.peak_mm() / small[0].peak_mm() - 1.0).abs());
    Ok(vec![
        (
            "33",
            vec![
                Check::new("largest gap [mm], 5 to 50 µC/m², 100 MΩ", peaks(&high), Bound::Falls),
                Check::new("the same at 1 MΩ [mm]", peaks(&low), Bound::Falls),
                Check::new("last / first, 100 MΩ and 1 MΩ", [ratio(&high), ratio(&low)], Bound::Below(0.93)),
                Check::new("law gap-field: last / first", [ratio(&energy)], Bound::Reported),
            ],
        ),
        (
            "34",
            vec![
                Check::new("lower edge [Hz], 5 to 50 µC/m², 100 MΩ", edges(&high, 0), Bound::Falls),
                Check::new("upper edge [Hz]", edges(&high, 1), Bound::Falls),
                Check::new("the same at 1 MΩ: lower [Hz]", edges(&low, 0), Bound::Falls),
                Check::new("upper [Hz]", edges(&low, 1), Bound::Falls),
                Check::new(
                    "law gap-field, 50 µC/m²: edges [Hz]",
                    energy.last().map_or([f64::NAN; 2], |band| band.edges),
                    Bound::Reported,
                ),
            ],
        ),
        (
            "35",
            vec![Check::new(
                "width at 50 less at 5 µC/m² [Hz], 100 MΩ",
                [widening(&high)],
                Bound::Above(0.2),
            )],
        ),
        (
            "36",
            vec![
                Check::new("lower edge [Hz], 5 to 50 µC/m², 100 MΩ", edges(&high, 0), Bound::Falls),
                Check::new("at 50 µC/m² [Hz]: 1, 10, 100 MΩ", large.map(|band| band.edges[0]), Bound::Falls),
            ],
        ),
        (
            "40",
            vec![
                Check::new("5 µC/m²: move of the edges from 1 MΩ [Hz]", same_edges, Bound::Below(1e-9)),
                Check::new("5 µC/m²: change of the largest gap", same_peaks, Bound::Below(1e-4)),
                Check::new(
                    "largest change over frequency, 10 and 100 MΩ",
                    differences(small),
                    Bound::Below(5e-3),
                ),
            ],
        ),
        (
            "41",
            vec![
                Check::new("50 µC/m²: width [Hz], 1, 10, 100 MΩ", large.map(Band::width), Bound::Rises),
                Check::new(
                    "largest change over frequency, 10 and 100 MΩ",
                    differences(large),
                    Bound::Reported,
                ),
            ],
        ),
        (
            "43",
            vec![Check::new(
                "5 µC/m²: largest change of the gap with R",
                differences(small),
                Bound::Below(5e-3),
            )],
        ),
        (
            "b",
            vec![Check::new("1 MΩ: width at 50 less at 5 µC/m² [Hz]", [widening(&low)], Bound::Above(0.051))],
        ),
    ])
}

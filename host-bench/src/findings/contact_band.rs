//! The impacting band of contact-separation over frequency: findings 33 to 36, 40, 41 and 43.

use super::runs::{Changes, Loader, value};
use super::statistics::{largest, least};
use super::{Bound::*, Measured, check};
use crate::method::{Failure, Options};
use crate::run::{run_scene, try_each};
use crate::scene_file::Scene;

/// Lowest frequency in Hz, distance and number of the frequencies.
const FIRST_HZ: f64 = 18.0;
const EVERY_HZ: f64 = 0.05;
const COUNT: u32 = 81;
/// Charge densities in C/m².
const CHARGE_DENSITIES: [&str; 4] = ["5e-6", "20e-6", "35e-6", "50e-6"];
/// Runs from rest, measured from 10 to 15 s as the scene is shipped.
const SHIPPED: Changes<'static> = &[];
const GAP_FIELD: Changes<'static> = &[("parameters.force_law", "gap-field")];

/// To what an edge is found, in Hz, and from how many frequencies; the largest gap, in parts of the distance of three.
const EDGE_HZ: f64 = 1e-4;
const FINE: u32 = 40;
const PEAK: f64 = 1e-3;

/// From where the scene is, and the keys that are changed in it.
type Case<'a> = (Loader<'a>, Changes<'a>);

/// The scene at a frequency in Hz.
fn at((loader, changes): Case<'_>, frequency_hz: f64) -> Result<Scene, Failure> {
    let frequency = format!("{frequency_hz}");
    loader.scene("contact-separation", &[changes, &[("excitation.frequency_hz", &frequency)]].concat())
}

#[derive(Clone, Copy)]
struct Point {
    frequency_hz: f64,
    /// Largest gap in m in the window.
    peak_m: f64,
    is_impacting: bool,
}

impl Point {
    fn new(case: Case<'_>, frequency_hz: f64) -> Result<Self, Failure> {
        let outcome = run_scene(&at(case, frequency_hz)?, &Options::default())?;
        let motion = outcome.contact_separation();
        let peak_m = value(motion.and_then(|motion| motion.peak_gap_m));
        Ok(Self { frequency_hz, peak_m, is_impacting: motion.is_some_and(|motion| motion.impacts > 0) })
    }
}

/// The motion over frequency, each frequency from rest.
struct Band {
    points: Vec<Point>,
    /// First and last frequency in Hz with an impact; not-a-number where the frequencies do not go beyond.
    edges: [f64; 2],
    /// Largest gap in mm over all frequencies; not-a-number if it is at the first or the last.
    peak_mm: f64,
    /// The scenes at both edges and at the largest gap.
    scenes: Vec<Scene>,
}

impl Band {
    fn new(case: Case<'_>) -> Result<Self, Failure> {
        let frequencies: Vec<f64> = (0..COUNT).map(|index| FIRST_HZ + EVERY_HZ * f64::from(index)).collect();
        let points = try_each(&frequencies, |frequency| Point::new(case, *frequency))?;
        let edge = |inside: Option<usize>, outwards_hz: f64| {
            inside.map_or(Ok(f64::NAN), |inside| edge(case, frequencies[inside], outwards_hz))
        };
        let (first, last) = (
            points.iter().position(|point| point.is_impacting),
            points.iter().rposition(|point| point.is_impacting),
        );
        let edges = [edge(first, -EVERY_HZ)?, edge(last, EVERY_HZ)?];
        let measured = |frequency_hz: f64| Point::new(case, frequency_hz);
        let (highest, is_inside) =
            least(&points, |place| frequencies[place], measured, |point| -point.peak_m, PEAK)?;
        let peak_mm = if is_inside { 1e3 * highest.peak_m } else { f64::NAN };
        let places = edges.into_iter().chain([highest.frequency_hz]).filter(|place| place.is_finite());
        let scenes = places.map(|frequency_hz| at(case, frequency_hz)).collect::<Result<_, _>>()?;
        Ok(Self { edges, peak_mm, points, scenes })
    }

    fn width(&self) -> f64 {
        self.edges[1] - self.edges[0]
    }

    /// Largest relative difference of the gap over the frequencies at which both have impacts or neither has.
    fn difference(&self, other: &Self) -> f64 {
        let pairs = self.points.iter().zip(&other.points);
        let alike = pairs.filter(|(one, other)| one.is_impacting == other.is_impacting);
        largest(alike.map(|(one, other)| (one.peak_m / other.peak_m - 1.0).abs()))
    }
}

/// The frequency in Hz at which impacts begin outwards from one with impacts. At the left of a band with much charge there are
/// islands with impacts: the outermost of [`FINE`] frequencies over two distances outwards counts, and is bisected from.
/// Not-a-number if the band goes on.
fn edge(case: Case<'_>, inside_hz: f64, outwards_hz: f64) -> Result<f64, Failure> {
    let fine: Vec<f64> =
        (0..=FINE).map(|index| inside_hz + 2.0 * outwards_hz * f64::from(index) / f64::from(FINE)).collect();
    let points = try_each(&fine, |frequency| Point::new(case, *frequency))?;
    let outermost = points.iter().rposition(|point| point.is_impacting).unwrap_or(0);
    let (mut with, Some(mut without)) = (fine[outermost], fine.get(outermost + 1).copied()) else {
        return Ok(f64::NAN);
    };
    while (with - without).abs() > EDGE_HZ {
        let middle = 0.5 * (with + without);
        *(if Point::new(case, middle)?.is_impacting { &mut with } else { &mut without }) = middle;
    }
    Ok(with)
}

/// The bands for charge densities and resistances, with these keys changed.
fn bands(loader: Loader<'_>, cases: &[(&str, &str)], changes: Changes<'_>) -> Result<Vec<Band>, Failure> {
    try_each(cases, |(density, resistance)| {
        let case = [("parameters.charge_density_c_per_m2", *density), ("load.resistance_ohm", *resistance)];
        Band::new((loader, &[&case[..], changes].concat()))
    })
}

/// Findings 33 to 36, 40, 41 and 43.
pub(super) fn measure(loader: Loader<'_>) -> Result<Measured, Failure> {
    let [least, .., most] = CHARGE_DENSITIES;
    let of = |resistance: &'static str| CHARGE_DENSITIES.map(|density| (density, resistance));
    let high = bands(loader, &of("1e8"), SHIPPED)?;
    let low = bands(loader, &of("1e6"), SHIPPED)?;
    let middle = bands(loader, &[(least, "1e7"), (most, "1e7")], SHIPPED)?;
    let energy = bands(loader, &[(least, "1e8"), (most, "1e8")], GAP_FIELD)?;
    let peaks = |bands: &[Band]| bands.iter().map(|band| band.peak_mm).collect::<Vec<_>>();
    let edges = |bands: &[Band], edge: usize| bands.iter().map(|band| band.edges[edge]).collect::<Vec<_>>();
    let ends = |bands: &[Band]| [bands[0].peak_mm, bands[bands.len() - 1].peak_mm];
    let ratio = |bands: &[Band]| ends(bands)[1] / ends(bands)[0];
    let widening = |bands: &[Band]| bands[bands.len() - 1].width() - bands[0].width();
    let last = high.len() - 1;
    // Small charge, then large charge, at 1, 10 and 100 MΩ.
    let small = [&low[0], &middle[0], &high[0]];
    let large = [&low[last], &middle[1], &high[last]];
    let differences = |of: [&Band; 3]| [of[1].difference(of[0]), of[2].difference(of[0])];
    let same_edges = small
        .map(|band| (band.edges[0] - small[0].edges[0]).abs() + (band.edges[1] - small[0].edges[1]).abs());
    let same_peaks = small.map(|band| (band.peak_mm / small[0].peak_mm - 1.0).abs());
    let alike = "largest change where both have impacts or neither, 10 and 100 MΩ";
    let scenes = [&high, &low, &middle, &energy].into_iter().flatten().flat_map(|band| band.scenes.clone());
    Ok(vec![
        check("33", "largest gap [mm], 5 to 50 µC/m², 100 MΩ", peaks(&high), Falls).of(scenes),
        check("33", "the same at 1 MΩ [mm]", peaks(&low), Falls),
        check("33", "last / first, 100 MΩ and 1 MΩ", [ratio(&high), ratio(&low)], Below(0.93)),
        check("33", "law gap-field: last / first", [ratio(&energy)], Reported),
        check("34", "lower edge [Hz], 5 to 50 µC/m², 100 MΩ", edges(&high, 0), Falls),
        check("34", "upper edge [Hz]", edges(&high, 1), Falls),
        check("34", "the same at 1 MΩ: lower [Hz]", edges(&low, 0), Falls),
        check("34", "upper [Hz]", edges(&low, 1), Falls),
        check(
            "34",
            "law gap-field, 50 µC/m²: edges [Hz]",
            energy.last().map_or([f64::NAN; 2], |band| band.edges),
            Reported,
        ),
        check("35", "width at 50 less at 5 µC/m² [Hz], 100 MΩ", [widening(&high)], Above(0.2)),
        check("35", "at 1 MΩ [Hz]", [widening(&low)], Within(0.05, widening(&high))),
        check("36", "lower edge [Hz], 5 to 50 µC/m², 100 MΩ", edges(&high, 0), Falls),
        check("36", "at 50 µC/m² [Hz]: 1, 10, 100 MΩ", large.map(|band| band.edges[0]), Falls),
        check("40", "5 µC/m²: move of the edges from 1 MΩ [Hz]", same_edges, Below(0.02)),
        check("40", "5 µC/m²: change of the largest gap", same_peaks, Below(1e-3)),
        check("40", alike, differences(small), Below(5e-3)),
        check("41", "50 µC/m²: width [Hz], 1, 10, 100 MΩ", large.map(Band::width), Rises),
        check("41", alike, differences(large), Reported),
        check(
            "43",
            "5 µC/m²: largest change where both have impacts or neither",
            differences(small),
            Below(5e-3),
        ),
    ])
}

//! Contact and open phases of the second paper: findings 1 to 13.

use super::runs::{Changes, EVERY_S, History, Loader, NEAR_RESONANCE, OFF_RESONANCE, Sample, each_of, stop};
use super::statistics::{correlation, largest, mean, median, root_mean_square, share_above, smallest};
use super::{Bound::*, Measured, check};
use crate::embedded::{ContactInterval, chattering_phases, contact_intervals};
use crate::method::{Failure, Options};
use crate::scene_file::modes::BumpStopModes;
use crate::scene_file::{Excitation, Scene};

/// Time before and after a contact that belongs to the contact phase, in periods.
const MARGIN: f64 = 0.0625;
/// Length in s of the samples whose spectrum is taken: whole periods of 44 and of 220 Hz, or about it.
const SPECTRUM_S: f64 = 0.25;
/// Lowest frequency of the high part of the spectrum, in first natural frequencies.
const HIGH: f64 = 5.0;
const MEGOHM: Changes<'static> = &[("load.resistance_ohm", "1e6")];
/// Opening in m above which beam and rod are apart at every instant of a step.
const APART_M: f64 = 1e-7;

/// The contacts of a run, grouped by the pauses between them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Phases {
    contacts: Vec<ContactInterval>,
    period_s: f64,
}

impl Phases {
    /// Those of a run of the scene by the default method.
    pub(super) fn new(scene: &Scene) -> Result<Self, Failure> {
        Ok(Self { contacts: contact_intervals(scene, &Options::default())?, period_s: period_s(scene) })
    }

    fn of(history: &History) -> Self {
        Self { contacts: history.contacts.clone(), period_s: period_s(&history.scene) }
    }

    fn chattering(&self) -> impl Iterator<Item = &[ContactInterval]> {
        chattering_phases(&self.contacts, self.period_s)
    }

    /// First and last instant in s of each chattering phase.
    pub(super) fn spans(&self) -> Vec<[f64; 2]> {
        let span = |phase: &[ContactInterval]| {
            Some([phase.first()?.begins_s, largest(phase.iter().map(|contact| contact.ends_s))])
        };
        self.chattering().filter_map(span).collect()
    }

    fn counts(&self) -> impl Iterator<Item = f64> {
        self.chattering().map(|phase| phase.len() as f64)
    }

    /// Longest contact over the length of its chattering phase: the median over the phases.
    fn longest_share(&self) -> f64 {
        let longest = self.chattering().map(|phase| largest(phase.iter().map(ContactInterval::length_s)));
        let spans = self.spans();
        median(longest.zip(&spans).map(|(longest, [from, to])| longest / (to - from)))
    }

    /// Least number of chattering phases that begin in a period, of those from one instant to another in s.
    fn least_in_a_period(&self, from_s: f64, to_s: f64) -> f64 {
        let periods = ((to_s - from_s) / self.period_s).round() as usize;
        let mut counts = vec![0.0; periods];
        for [begins, _] in self.spans() {
            let period = ((begins - from_s) / self.period_s) as usize;
            counts.iter_mut().skip(period).take(1).for_each(|count| *count += 1.0);
        }
        smallest(counts.into_iter())
    }

    /// Whether each of some rising instants in s is in a contact phase.
    pub(super) fn contains(&self, instants: impl Iterator<Item = f64>) -> Vec<bool> {
        let margin = MARGIN * self.period_s;
        let mut rest = &self.contacts[..];
        let is_near = |instant: f64| {
            while let [first, later @ ..] = rest
                && first.ends_s + margin < instant
            {
                rest = later;
            }
            rest.first().is_some_and(|contact| contact.begins_s - margin <= instant)
        };
        instants.map(is_near).collect()
    }
}

fn period_s(scene: &Scene) -> f64 {
    scene.excitation.single_frequency().map_or(f64::NAN, f64::recip)
}

/// Voltages with and without a stop, over the contact phases and over the open phases.
struct Compared {
    /// RMS voltage over that without the stop.
    contact_ratio: f64,
    open_ratio: f64,
    open_correlation: f64,
}

impl Compared {
    fn new(with: &History, without: &History) -> Self {
        let near = Phases::of(with).contains(with.samples.iter().map(|sample| sample.time_s));
        let pairs = |wanted: bool| {
            let both = with.samples.iter().zip(&without.samples).zip(&near);
            both.filter(move |(_, near)| **near == wanted)
                .map(|((with, without), _)| (with.voltage_v, without.voltage_v))
        };
        let ratio = |wanted: bool| {
            root_mean_square(pairs(wanted).map(|pair| pair.0))
                / root_mean_square(pairs(wanted).map(|pair| pair.1))
        };
        Self {
            contact_ratio: ratio(true),
            open_ratio: ratio(false),
            open_correlation: correlation(pairs(false)),
        }
    }
}

/// Runs of three scenes: the stop at the tip, at mid-span, and none.
fn histories(loader: Loader<'_>, names: [&str; 3], changes: Changes<'_>) -> Result<[History; 3], Failure> {
    each_of(names, |name| History::of(loader.scene(name, changes)?))
}

fn phases_of(loader: Loader<'_>, names: &[&str; 3], changes: Changes<'_>) -> Result<[Phases; 2], Failure> {
    let [tip, mid, _] = *names;
    each_of([tip, mid], |name| Phases::new(&loader.scene(name, changes)?))
}

/// Findings 1 to 13.
pub(super) fn measure(loader: Loader<'_>) -> Result<Measured, Failure> {
    let paper = histories(loader, OFF_RESONANCE, &[])?;
    // 110 periods after 110.
    let near = histories(loader, NEAR_RESONANCE, &[("run.duration_s", "1.0")])?;
    let light: Changes<'_> = &[("parameters.damping_ratio", "0.001"), ("stop.gap_m", "5e-6")];
    let light = phases_of(loader, &OFF_RESONANCE, light)?;
    let mut measured = chatter([&paper[0], &paper[1]], [&near[0], &near[1]], &light)?;
    measured.extend(voltages(&paper, &near)?);
    let scenes = paper.into_iter().chain(near).map(|history| history.scene).collect();
    if let Some(check) = measured.first_mut() {
        check.scenes = scenes;
    }
    Ok(measured)
}

/// Findings 1 to 6: contacts, forces and displacements.
fn chatter(paper: [&History; 2], near: [&History; 2], light: &[Phases; 2]) -> Result<Measured, Failure> {
    let [of_paper, of_near] = [paper, near].map(|pair| pair.map(Phases::of));
    let least = |history: &History| {
        Phases::of(history).least_in_a_period(history.scene.run.settle_s, history.scene.run.duration_s)
    };
    let pair = |of: fn(&History) -> f64, pair: [&History; 2]| pair.map(of).to_vec();
    let shares = |of: &[Phases; 2]| of.each_ref().map(Phases::longest_share).to_vec();
    let counts = |of: &[Phases; 2], pick: fn(&mut dyn Iterator<Item = f64>) -> f64| {
        of.each_ref().map(|phases| pick(&mut phases.counts())).to_vec()
    };
    let [tip, mid] = paper;
    let means = [mean_displacement_error(tip)?, mean_displacement_error(mid)?];
    let lengths = |of: [&History; 2]| {
        of.map(|history| 1e6 * median(history.contacts.iter().map(ContactInterval::length_s))).to_vec()
    };
    let second_period_us = 1e6 / frequencies_hz(tip)?[1];
    Ok(vec![
        check("1", "fewest chattering phases in a period, tip and mid-span", paper.map(least), Above(0.5)),
        check("1", "the same at 220 Hz", near.map(least), Above(0.5)),
        check("2", "excess over the gap / amplitude", pair(excess, paper), Below(0.01)),
        check("2", "the same at 220 Hz", pair(excess, near), Below(0.03)),
        check("3", "least force [N]", pair(least_force, paper), AtLeast(0.0)),
        check("3", "largest force with an open gap [N]", pair(force_apart, paper), Is(0.0)),
        check("3", "mean displacement by the mean force, relative error", means, Below(1e-3)),
        check(
            "4",
            "fewest contacts of a chattering phase",
            counts(&of_paper, |counts| smallest(counts)),
            Above(20.0),
        ),
        check("4", "longest contact / chattering phase", shares(&of_paper), Below(0.667)),
        check(
            "4",
            "at 220 Hz: contacts of a phase, median",
            counts(&of_near, |counts| median(counts)),
            Above(10.0),
        ),
        check("4", "at 220 Hz: longest contact / phase", shares(&of_near), Below(0.2)),
        check("4", "damping ratio 0.001, gap 5 µm: longest / phase", shares(light), Below(0.2)),
        check("5", "largest displacement of the rod [m]", pair(rod_peak, paper), Within(2e-8, 3e-7)),
        check("5", "median distance in a phase [m]", pair(distance, paper), Within(2e-8, 3e-7)),
        check("5", "at 220 Hz: rod [m]", pair(rod_peak, near), Within(2e-8, 3e-7)),
        check("5", "at 220 Hz: distance [m]", pair(distance, near), Within(2e-8, 3e-7)),
        check("5a", "RMS of the free rod / its static motion", pair(free_rod, paper), Above(2.0)),
        check("6", "median contact [µs]", lengths(paper), Below(0.1 * second_period_us)),
        check("6", "at 220 Hz [µs]", lengths(near), Below(0.1 * second_period_us)),
    ])
}

/// Findings 7 to 13: voltage and power.
fn voltages([tip, mid, none]: &[History; 3], near: &[History; 3]) -> Result<Measured, Failure> {
    let compared = [tip, mid].map(|with| Compared::new(with, none));
    let compared_near = [&near[0], &near[1]].map(|with| Compared::new(with, &near[2]));
    let of = |compared: &[Compared; 2], pick: fn(&Compared) -> f64| compared.each_ref().map(pick).to_vec();
    let high = |histories: &[&History]| {
        histories.iter().map(|history| high_share(history)).collect::<Result<Vec<_>, _>>()
    };
    let ratios = |of: fn(&History) -> f64, over: &History, histories: &[&History]| {
        histories.iter().map(|history| of(history) / of(over)).collect::<Vec<_>>()
    };
    let list = |of: fn(&History) -> f64, histories: [&History; 3]| histories.map(of).to_vec();
    let [near_tip, near_mid, near_none] = near.each_ref();
    let (power, peak, rms) = (History::mean_power_w, History::peak_voltage_v, History::rms_voltage_v);
    Ok(vec![
        check("7", "power above 5 natural frequencies, tip and mid-span", high(&[tip, mid])?, Above(1e-3)),
        check("7", "at 220 Hz", high(&[near_tip, near_mid])?, Above(1e-3)),
        check("7", "without a stop, 44 and 220 Hz", high(&[none, near_none])?, Below(1e-6)),
        check("8", "RMS voltage in contact / none", of(&compared, |of| of.contact_ratio), Below(0.75)),
        check("8", "at 220 Hz", of(&compared_near, |of| of.contact_ratio), Below(0.75)),
        check("9", "RMS voltage out of contact / none", of(&compared, |of| of.open_ratio), Within(0.85, 1.1)),
        check("9", "correlation with none", of(&compared, |of| of.open_correlation), Above(0.9)),
        check("9", "at 220 Hz: ratio", of(&compared_near, |of| of.open_ratio), Reported),
        check("10", "mean power / none", ratios(power, none, &[tip, mid]), Below(0.7)),
        check("10", "at 220 Hz", ratios(power, near_none, &[near_tip, near_mid]), Below(0.7)),
        check("11", "peak voltage, mid-span / tip", ratios(peak, tip, &[mid]), Above(1.05)),
        check("11", "at 220 Hz", ratios(peak, near_tip, &[near_mid]), Above(1.05)),
        check("12", "mean power, mid-span / tip", ratios(power, tip, &[mid]), Above(1.2)),
        check("12", "at 220 Hz", ratios(power, near_tip, &[near_mid]), Above(1.2)),
        check("13", "RMS voltage [V]: tip, mid-span, none", list(rms, [tip, mid, none]), Rises),
        check("13", "at 220 Hz [V]", list(rms, [near_tip, near_mid, near_none]), Rises),
        check("13", "peak voltage [V]: tip, mid-span, none", list(peak, [tip, mid, none]), Reported),
    ])
}

/// What no parameters tried reproduce: c and d.
pub(super) fn measure_not_reproduced(loader: Loader<'_>) -> Result<Measured, Failure> {
    let ([tip, mid, none], [wide_tip, wide_mid, wide_none]) = {
        let (one, other) = rayon::join(|| histories(loader, OFF_RESONANCE, MEGOHM), || wide_gap(loader));
        (one?, other?)
    };
    let open = |with: [&History; 2], none: &History| with.map(|with| Compared::new(with, none).open_ratio);
    let shares = [&wide_tip, &wide_mid].map(|history| Phases::of(history).longest_share());
    let peaks = wide_mid.peak_voltage_v() / wide_tip.peak_voltage_v();
    Ok(vec![
        check("c", "1 MΩ: RMS voltage out of contact / none", open([&tip, &mid], &none), Within(0.85, 1.1)),
        check("d", "gap 30 µm: longest contact / phase", shares, Below(0.2)),
        check(
            "d",
            "gap 30 µm: RMS voltage out of contact / none",
            open([&wide_tip, &wide_mid], &wide_none),
            Within(0.85, 1.1),
        ),
        check("d", "gap 30 µm: peak voltage, mid-span / tip", [peaks], Above(1.05)),
    ])
}

/// The runs with a gap of 30 µm; the one without a stop has none.
fn wide_gap(loader: Loader<'_>) -> Result<[History; 3], Failure> {
    let [tip, mid, none] = OFF_RESONANCE;
    let (wide, unchanged): (Changes<'_>, Changes<'_>) = (&[("stop.gap_m", "30e-6")], &[]);
    each_of([(tip, wide), (mid, wide), (none, unchanged)], |(name, changes)| {
        History::of(loader.scene(name, changes)?)
    })
}

/// By how much the beam at the stop passes the gap, over its largest displacement.
fn excess(history: &History) -> f64 {
    let places = || history.samples.iter().map(|sample| sample.stop_point_m);
    (largest(places()) - history.gap_m()) / largest(places().map(f64::abs))
}

fn least_force(history: &History) -> f64 {
    smallest(history.samples.iter().map(|sample| sample.force_n))
}

/// Largest force where beam and rod are apart.
fn force_apart(history: &History) -> f64 {
    let gap = history.gap_m();
    let apart = |sample: &&Sample| sample.stop_point_m - sample.rod_m - gap < -APART_M;
    largest(history.samples.iter().filter(apart).map(|sample| sample.force_n))
}

/// Relative error of `⟨y(X_c)⟩ = −⟨F⟩ Σ φ²/ω²`, which holds over a stationary motion with a resistor.
fn mean_displacement_error(history: &History) -> Result<f64, Failure> {
    let modes = modes(history)?;
    let compliance: f64 = modes.beam.iter().map(|mode| (mode.at_stop / mode.angular_frequency).powi(2)).sum();
    let predicted = -history.mean_force_n()? * compliance;
    let found = mean(history.samples.iter().map(|sample| sample.stop_point_m));
    Ok((found / predicted - 1.0).abs())
}

fn modes(history: &History) -> Result<BumpStopModes, Failure> {
    let model = history.scene.bump_stop()?;
    Ok(BumpStopModes::new(&model.parameters, model.stop.as_ref()))
}

/// Frequencies in Hz of the first two bending modes.
fn frequencies_hz(history: &History) -> Result<[f64; 2], Failure> {
    let [first, second, ..] = modes(history)?.beam[..] else {
        return Err(Failure::of_file(&history.scene, "parameters.beam_modes must be at least 2 here"));
    };
    Ok([first, second].map(|mode| mode.angular_frequency / std::f64::consts::TAU))
}

fn rod_peak(history: &History) -> f64 {
    largest(history.samples.iter().map(|sample| sample.rod_m.abs()))
}

/// Median distance in m of the beam from the rest position of the rod within the chattering phases.
fn distance(history: &History) -> f64 {
    let spans = Phases::of(history).spans();
    let mut rest = &spans[..];
    let is_within = |sample: &&Sample| {
        while let [[_, ends], later @ ..] = rest
            && *ends < sample.time_s
        {
            rest = later;
        }
        rest.first().is_some_and(|[begins, _]| *begins <= sample.time_s)
    };
    let gap = history.gap_m();
    median(history.samples.iter().filter(is_within).map(|sample| (sample.stop_point_m - gap).abs()))
}

/// RMS displacement of the rod without a force in the contact phases, over that of its face under the peak acceleration
/// of the base at rest, `ρ a L²/2E`.
fn free_rod(history: &History) -> f64 {
    let near = Phases::of(history).contains(history.samples.iter().map(|sample| sample.time_s));
    let free = history.samples.iter().zip(near).filter(|(sample, near)| *near && sample.force_n == 0.0);
    let acceleration = match &history.scene.excitation {
        Excitation::Sine(tone) => tone.amplitude_m_per_s2,
        _ => f64::NAN,
    };
    let still = stop(&history.scene).map_or(f64::NAN, |stop| {
        0.5 * stop.density_kg_per_m3 * acceleration * stop.length_m.powi(2) / stop.young_modulus_pa
    });
    root_mean_square(free.map(|(sample, _)| sample.rod_m)) / still
}

/// Part of the power of the voltage above five natural frequencies.
fn high_share(history: &History) -> Result<f64, Failure> {
    let period_s = period_s(&history.scene);
    let count = ((SPECTRUM_S / period_s).round() * period_s / EVERY_S).round() as usize;
    let voltages: Vec<f64> = history.samples.iter().take(count).map(|sample| sample.voltage_v).collect();
    let [first_hz, _] = frequencies_hz(history)?;
    Ok(share_above(&voltages, EVERY_S, HIGH * first_hz))
}

//! Warnings about the accuracy of a run.

use super::{LEAST, delivers, relative};
use crate::outcome::{Outcome, fields};
use crate::resolution::natural_frequency_hz;
use crate::scene_file::{Excitation, Load, Scene};
use serde_json::Value;

/// Estimated relative error of the mean power above which a run warns.
const NOTABLE: f64 = 5e-3;
/// Estimated relative error above which nothing is known of the quantity.
const UNKNOWN: f64 = 1.0;
/// RMS voltage behind a bridge over the highest voltage at which it conducts above which a run warns.
const BEYOND: f64 = 1.1;
/// Relative residual of the energy ledger above which a run warns.
const UNBALANCED: f64 = 1e-2;
/// Relative difference of a peak in finer steps above which a run warns, so that one without a warning is within 2 %.
const PEAK: f64 = 1e-2;
/// Relative difference of an RMS voltage from that in double precision above which a run warns.
const RMS: f64 = 1e-2;
/// Parts of the energy that a harvester exchanges below which the energy delivered to a resistor, which is quadratic in
/// the voltage, and through a bridge, which is linear in the charge, are not resolved in double precision.
const UNRESOLVED: [f64; 2] = [1e-26, 1e-14];

/// The warning of a statement that is unknown or notable.
pub(super) fn warning(outcome: &Outcome, asked: Option<f64>) -> Option<String> {
    let accuracy = &outcome.accuracy;
    let is_power = delivers(outcome) || accuracy.rounding == Some(1.0);
    let quantity = if is_power { "the mean power" } else { "the largest motion and the RMS voltage" };
    let Some(total) = accuracy.total else {
        return Some(format!(
            "accuracy: the error of {quantity} is unknown: a run to compare with did not end or has the same steps, one \
             of the two delivers nothing, the mean step is longer than a quarter of a period, or a rod that is hit with a \
             restitution oscillates within a step"
        ));
    };
    let missed = asked.is_some_and(|asked| total > asked.max(LEAST));
    (missed || asked.is_none() && total > NOTABLE).then(|| {
        let sources = [
            ("the chaotic motion", accuracy.chaos),
            ("the step", accuracy.step),
            ("rounding", accuracy.rounding),
            ("fast relaxations", accuracy.boundary_layers),
        ];
        let known = sources.iter().filter_map(|(name, error)| Some(format!("{:.1e} by {name}", (*error)?)));
        let not_reached =
            asked.filter(|_| missed).map_or(String::new(), |asked| format!("{asked:e} is not held: "));
        let (unknown, remedy) = match total > UNKNOWN {
            true => (
                format!("{quantity} cannot be determined: "),
                "; smaller steps (--accuracy, --tolerance or --step) and a longer run.duration_s may help",
            ),
            false => Default::default(),
        };
        format!(
            "accuracy: {not_reached}{unknown}the estimated relative error of {quantity} is {total:.1e}: {}{remedy}",
            known.collect::<Vec<_>>().join(", ")
        )
    })
}

/// The warning of the peak that differs most from that of a run in finer steps, or of one of the runs of a chaotic motion.
pub(super) fn differing_peak(outcome: &Outcome, others: &[Outcome], is_chaotic: bool) -> Option<String> {
    let own = fields(outcome);
    let is_peak = |name: &str| ["peak", "largest_range", "max_"].iter().any(|part| name.contains(part));
    let apart = |(name, value): (String, Value)| {
        let (one, other) = (own.get(&name)?.as_f64()?, value.as_f64()?);
        (one != other && is_peak(&name)).then(|| (name, (one / other - 1.0).abs()))
    };
    let differing = others.iter().flat_map(fields).filter_map(apart).filter(|(_, apart)| *apart > PEAK);
    let (name, apart) = differing.max_by(|(_, one), (_, other)| one.total_cmp(other))?;
    let cause = if is_chaotic {
        "displaced starts of a chaotic motion"
    } else {
        "finer steps (--accuracy, --step or --tolerance)"
    };
    Some(format!("peaks: {name} differs by {apart:.1e} in {cause}"))
}

/// The warning of an RMS voltage that is lost in the rounding of single precision: a small difference of large voltages.
pub(super) fn lost_rms(outcome: &Outcome, exact: &Outcome) -> Option<String> {
    let apart = relative(outcome.rms_voltage_v?, exact.rms_voltage_v?)?;
    (apart > RMS).then(|| format!("rounding: rms_voltage_v differs by {apart:.1e} in double precision"))
}

/// The warning of a trace whose straight lines differ notably from a smooth curve through its samples, or cannot be compared with it.
pub(super) fn sampled(scene: &Scene, outcome: &Outcome) -> Option<String> {
    let Excitation::File(trace) = &scene.excitation else { return None };
    let key = if trace.resampled.is_some() { "resample_hz" } else { "rate_hz" };
    let Some(sampling) = outcome.accuracy.sampling else {
        return Some(format!(
            "excitation.{key}: the error by the sampling is unknown: the run on a smoother trace did not end"
        ));
    };
    let natural = natural_frequency_hz(scene, outcome).filter(|_| trace.resampled.is_none());
    let remedy = natural.map(|natural| more_samples(trace.rate_hz, natural));
    (sampling > NOTABLE).then(|| {
        let remedy = remedy.unwrap_or_default();
        format!("excitation.{key}: {sampling:.1e} of the mean power by the sampling of the trace{remedy}")
    })
}

/// What helps against an error by the sampling of a trace. Straight lines between `n` samples in a period take
/// `1 − sinc²(1/n)` ≈ `π²/(3 n²)` of the amplitude of a sine, and twice as much of the power of a linear harvester.
fn more_samples(rate_hz: f64, natural_hz: f64) -> String {
    let enough = std::f64::consts::PI * (2.0 / (3.0 * NOTABLE)).sqrt();
    format!(
        "; a higher sampling rate helps: {rate_hz} Hz are {:.1} samples in a period of the natural frequency of {natural_hz:.4} Hz, \
         about {enough:.0} make the error of a linear harvester {NOTABLE:e}",
        rate_hz / natural_hz
    )
}

/// The warning of an energy ledger that does not close.
pub fn imbalance(outcome: &Outcome) -> Option<String> {
    outcome.energy_residual.filter(|residual| !(residual.abs() <= UNBALANCED)).map(|residual| {
        format!(
            "accuracy: energy_residual = {residual:.1e} is more than {UNBALANCED}: the step or the tolerance was \
             probably too coarse, or the method unstable"
        )
    })
}

/// The warning of a delivered energy that is lost in the rounding of those exchanged: runs to compare with may round alike.
pub(super) fn unresolved(scene: &Scene, outcome: &Outcome) -> Option<String> {
    let flow = outcome.flow.as_ref()?;
    let delivered_j = outcome.delivered_energy_j.filter(|&energy| energy > 0.0)?;
    let exchanged_j = flow.base_j.abs().max(flow.dissipated_j).max(flow.contact_j);
    let [resistor, bridge] = UNRESOLVED;
    let least = if matches!(scene.load, Load::Resistor { .. }) { resistor } else { bridge };
    (delivered_j < least * exchanged_j).then(|| {
        format!(
            "accuracy: the delivered energy of {delivered_j:.1e} J is not resolved: the harvester exchanges \
             {exchanged_j:.1e} J"
        )
    })
}

/// The warning of a terminal voltage at which the bridge would have conducted: a conduction was missed.
pub(super) fn beyond_threshold(scene: &Scene, outcome: &Outcome) -> Option<String> {
    let (drop_v, store_v) = match &scene.load {
        Load::Resistor { .. } => return None,
        Load::DcBus { voltage_v, diode_drop_v } => (*diode_drop_v, *voltage_v),
        // All that came in, and nothing of it drawn.
        Load::RectifiedStore(store) => {
            let squares = 2.0 * outcome.flow.as_ref()?.delivered_j.max(0.0) / store.capacitance_f;
            (store.diode_drop_v, (store.initial_v * store.initial_v + squares).sqrt())
        }
    };
    let most_v = store_v + 2.0 * drop_v;
    let rms_v = outcome.rms_voltage_v.filter(|&rms_v| rms_v > BEYOND * most_v)?;
    Some(format!(
        "accuracy: rms_voltage_v = {rms_v:.3e} is above the {most_v:.3e} V at which the bridge conducts: a conduction was missed"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::{Override, read, shipped};

    #[test]
    fn a_trace_that_could_not_be_compared_with_a_smoother_one_is_announced() {
        let outcome = Outcome::default();
        let noise = "{kind=\"file\",path=\"noise.csv\",column=1,rate_hz=400,scale_m_per_s2=1,repeat=true}";
        let run = Override::new("run", "{duration_s=1.0,settle_s=0.5}");
        let changes = [run, Override::new("excitation", noise)];
        for (changes, is_recorded) in [(&changes[..], true), (&changes[..1], false)] {
            let scene = read(&shipped("sliding"), changes).expect("a shipped scene");
            let text = sampled(&scene, &outcome);
            assert_eq!(text.is_some_and(|text| text.contains("is unknown")), is_recorded);
        }
    }
}

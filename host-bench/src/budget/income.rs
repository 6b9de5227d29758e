//! The power that the harvester delivers over the day.
//!
//! *By level*: the scene is run once for each amplitude of the day, over its own measuring window, and its mean power
//! holds for each hour of that amplitude. A bridge is run into a bus at several voltages, because the voltage of the
//! storage changes little in a period of the motion, and the power is interpolated between them. The transients from
//! hour to hour are left out. *Exact*: every step of the day.

use crate::accuracy::{Statements, run_as_it_is};
use crate::embedded::{WholeDay, whole_day};
use crate::method::{Failure, Options, Precision};
use crate::scene_file::{Excitation, Load, Node, Scene};

/// Relative tolerance of the step control of a triboelectric scene, as in firmware.
const NODE_TOLERANCE: f64 = 0.05;
/// Number of voltages of the storage at which a bridge is run, from 0 to the highest.
const VOLTAGES: u32 = 9;

/// Power over the day.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Income {
    /// For each hour pairs of a voltage of the storage in V, rising, and the power in W there. A power that does not
    /// depend on the voltage is the only pair.
    ByLevel(Vec<Vec<(f64, f64)>>),
    /// Mean power in W in equal intervals of so many seconds.
    Exact { interval_s: u32, powers_w: Vec<f64> },
}

impl Income {
    /// Power in W at a second of the day and a voltage of the storage in V.
    pub(crate) fn power_w(&self, second: u32, storage_v: f64) -> f64 {
        match self {
            Self::ByLevel(hours) => {
                hours.get((second / 3600) as usize).map_or(0.0, |curve| at_voltage(curve, storage_v))
            }
            Self::Exact { interval_s, powers_w } => {
                powers_w.get((second / interval_s) as usize).copied().unwrap_or(0.0)
            }
        }
    }

    /// The same power all day.
    #[cfg(test)]
    pub(super) fn constant(power_w: f64) -> Self {
        Self::ByLevel(vec![vec![(0.0, power_w)]; crate::scene_file::HOURS])
    }
}

/// The power at a voltage, linear between the known voltages.
fn at_voltage(curve: &[(f64, f64)], voltage: f64) -> f64 {
    let above = curve.partition_point(|(known, _)| *known <= voltage);
    match (above.checked_sub(1).map(|below| curve[below]), curve.get(above)) {
        (Some((left, low)), Some((right, high))) => low + (high - low) * (voltage - left) / (right - left),
        (Some((_, power)), None) | (None, Some(&(_, power))) => power,
        (None, None) => 0.0,
    }
}

/// Options of a run for the income; the tolerance of firmware where none is given.
pub(crate) fn options(scene: &Scene, precision: Precision, tolerance: Option<f64>) -> Options {
    // The step of a bump-stop scene does not follow from a tolerance.
    let tolerance = tolerance.or(scene.bump_stop().is_err().then_some(NODE_TOLERANCE));
    Options { precision: Some(precision), tolerance, ..Options::default() }
}

/// The income by level; the statements of its runs are added.
pub(crate) fn by_level(
    scene: &Scene,
    node: &Node,
    options: &Options,
    statements: &mut Statements,
) -> Result<Income, Failure> {
    let mut known: Vec<(f64, Vec<(f64, f64)>)> = Vec::new();
    for factor in node.hours {
        if known.iter().all(|(other, _)| *other != factor) {
            known.push((factor, curve(scene, node, factor, options, statements)?));
        }
    }
    let of = |factor: f64| known.iter().find(|(other, _)| *other == factor).map(|(_, curve)| curve.clone());
    Ok(Income::ByLevel(node.hours.into_iter().filter_map(of).collect()))
}

/// The power at one amplitude over the voltage of the storage.
fn curve(
    scene: &Scene,
    node: &Node,
    factor: f64,
    options: &Options,
    statements: &mut Statements,
) -> Result<Vec<(f64, f64)>, Failure> {
    if factor == 0.0 {
        // A harvester at rest has no power; a short run would still have the transient of its start.
        return Ok(vec![(0.0, 0.0)]);
    }
    let excitation = scene.excitation.scaled(factor);
    let mut power = |load: Load| -> Result<f64, Failure> {
        let scene = Scene { load, excitation: excitation.clone(), ..scene.clone() };
        let outcome = run_as_it_is(&scene, options)?;
        statements.add(&outcome);
        let power = outcome.mean_power_w.filter(|power| power.is_finite());
        power.ok_or_else(|| Failure::Step("the harvester has no finite mean power".to_owned()))
    };
    let Load::RectifiedStore(storage) = scene.load else { return Ok(vec![(0.0, power(scene.load)?)]) };
    let points = (0..VOLTAGES).map(|step| {
        let voltage_v = node.storage.highest_v * f64::from(step) / f64::from(VOLTAGES - 1);
        Ok((voltage_v, power(Load::DcBus { voltage_v, diode_drop_v: storage.diode_drop_v })?))
    });
    points.collect()
}

/// The income of every step of the day, and the day itself.
pub(crate) fn exact(scene: &Scene, node: &Node, options: &Options) -> Result<(Income, WholeDay), Failure> {
    check_trace(scene)?;
    let day = whole_day(scene, &node.hours, node.update_s, options)?;
    let powers_w = day.energies_j.iter().map(|energy| energy / f64::from(node.update_s)).collect();
    Ok((Income::Exact { interval_s: node.update_s, powers_w }, day))
}

/// Refuses a trace that ends before the day does.
fn check_trace(scene: &Scene) -> Result<(), Failure> {
    match &scene.excitation {
        Excitation::File(trace) if !trace.repeat => {
            Err(Failure::of_file(scene, "excitation.repeat: must be true with --exact"))
        }
        _ => Ok(()),
    }
}

/// Whether the harvester and the storage of a node can be one trajectory: the bridge must charge the storage itself.
pub(crate) fn check_looped(scene: &Scene, node: &Node) -> Result<(), Failure> {
    check_trace(scene)?;
    let efficiency = node.storage.charging_efficiency;
    if efficiency < 1.0 {
        return Err(Failure::of_file(
            scene,
            format!("node.storage.charging_efficiency: {efficiency} must be 1 with --exact behind a bridge"),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_is_interpolated_over_the_voltage_and_constant_beyond() {
        let curve = [(0.0, 0.0), (2.0, 6.0), (4.0, 8.0)];
        for (voltage, power) in [(0.0, 0.0), (0.5, 1.5), (2.0, 6.0), (3.0, 7.0), (4.0, 8.0), (9.0, 8.0)] {
            assert_eq!(at_voltage(&curve, voltage), power, "{voltage}");
        }
        assert_eq!(at_voltage(&[(0.0, 5.0)], 3.0), 5.0);
        let income = Income::Exact { interval_s: 60, powers_w: vec![1.0, 2.0] };
        assert_eq!([0, 59, 60, 119].map(|second| income.power_w(second, 3.0)), [1.0, 1.0, 2.0, 2.0]);
    }
}

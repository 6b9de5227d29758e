//! The cantilever without a stop: a series resonant circuit for each mode, in linear elements.

use std::fmt::Write as _;

use super::{Netlist, Parameter};
use crate::method::Failure;
use crate::scene_file::modes::BumpStopModes;
use crate::scene_file::{BumpStop, Coupling, Scene};

const NOTES: &str = "Equations of mode i (docs/equations.md), with r the modal displacement in sqrt(kg) m and v = V(p,n):
  r'' + 2 damping_ratio omega r' + omega^2 r = -gamma a - two_way theta v
  capacitance v' = sum of theta r' - current of the load
Each mode is a series circuit of L = 1, R = 2 damping_ratio omega and C = 1/omega^2. Its current is r', the voltage of its
capacitor omega^2 r. Displacement and acceleration are positive in one direction, towards the stop of a scene that has
one; v rises as the tip moves in that direction.
All elements are linear: nothing is regularised, and .ac holds too. The mean power is as exact as the time
step: of bump-stop-none.toml within 4e-5 at 1000 steps of a period, within 4e-4 at 400.
";

/// The netlist of a cantilever. Refuses a stop.
pub(super) fn netlist(scene: &Scene, model: &BumpStop) -> Result<Netlist, Failure> {
    if model.stop.is_some() {
        let text = "stop: must be absent for --spice: a netlist has no contact between modes of beam and rod";
        return Err(Failure::of_file(scene, text));
    }
    let from = &model.parameters;
    let modes = BumpStopModes::new(from, None);
    let two_way = if from.coupling == Coupling::TwoWay { 1.0 } else { 0.0 };
    let mut parameters = Vec::new();
    let mut add = |name: &str, value: f64, unit: &'static str, meaning: &str| {
        parameters.push(Parameter::new(name, value, unit, meaning));
    };
    add("damping_ratio", from.damping_ratio, "1", "damping ratio of every mode");
    add("capacitance_f", modes.capacitance, "F", "between the terminals at constant strain");
    add("two_way", two_way, "1", "1: the voltage acts on the beam; 0: it does not");
    add("voltage_v", model.initial.voltage_v, "V", "voltage at the start");
    let mut elements = "Cpiezo p n {capacitance_f} IC={voltage_v}\n".to_owned();
    for (index, mode) in modes.beam.iter().enumerate() {
        let i = index + 1;
        let mut of_mode = |name: &str, value: f64, unit: &'static str, meaning: &str| {
            add(&format!("{name}_{i}"), value, unit, &format!("mode {i}: {meaning}"));
        };
        of_mode(
            "omega",
            mode.angular_frequency,
            "rad/s",
            "angular frequency, terminals short-circuited, undamped",
        );
        of_mode("gamma", mode.participation, "√kg", "participation factor of the base acceleration");
        of_mode("theta", mode.coupling, "N/(V √kg)", "force of one volt, charge of one unit of displacement");
        of_mode(
            "displacement",
            model.initial.modal_displacement[index],
            "√kg·m",
            "displacement at the start",
        );
        of_mode("velocity", model.initial.modal_velocity[index], "√kg·m/s", "velocity at the start");
        let _ = write!(
            elements,
            "* mode {i}
Ebase{i} f{i} e{i} acc 0 {{-gamma_{i}}}
Evolt{i} e{i} 0 p n {{-two_way*theta_{i}}}
Rmode{i} f{i} a{i} {{2*damping_ratio*omega_{i}}}
Lmode{i} a{i} b{i} 1 IC={{velocity_{i}}}
Cmode{i} b{i} c{i} {{1/(omega_{i}*omega_{i})}} IC={{omega_{i}*omega_{i}*displacement_{i}}}
Vmode{i} c{i} 0 0
Fmode{i} n p Vmode{i} {{theta_{i}}}
"
        );
    }
    Ok(Netlist {
        notes: NOTES.to_owned(),
        parameters,
        elements,
        points: 1000.0,
        options: "method=trap maxord=2 reltol=1e-6 abstol=1e-15 vntol=1e-9",
    })
}

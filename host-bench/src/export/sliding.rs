//! Sliding by behavioural sources, with friction as a steep function of the velocity in place of dry friction.

use std::f64::consts::{FRAC_2_PI, PI};

use model_core::part::VACUUM_PERMITTIVITY;

use super::{Netlist, Parameter, law_name};
use crate::scene_file::modes::Cantilever;
use crate::scene_file::{ForceLaw, GRAVITY, Sliding, SlidingParameters, StickCharge};

/// Speed of the creep in stick over patch radius times angular frequency. A hundred times this speed costs some per cent of the power.
const CREEP: f64 = 1e-7;

/// Width of the static friction in speeds of the creep: the largest friction of `sliding.toml` is at most 0.42 % below its static one.
const WIDTH: f64 = 30.0;

const NOTES: &str = "Equations (docs/equations.md), with the displacement x, the charge q through the load, S = pi patch_radius^2,
C = eps0 relative_permittivity S/thickness, the parts s1 + s2 = 1 of the disc on the active and the inert patch:
  modal_mass (x'' + 2 damping_ratio omega x' + omega^2 x + base_coupling a) = F_k + F_lat
  V(p,n) = (sigma S s2 - q)/(C s1),  F_k = -mu(x,x') (slider_mass g + F_e(law))
  F_lat(lateral)
Acceleration and displacement are positive in one direction. Node g is x in mm, v its velocity in m/s, q the charge in nC, s is s2.
Regularised: with w = friction_speed_m_per_s and k = exp(-(x'/30 w)^2), which is node k,
  mu = tanh(x'/w) (kinetic friction + k (static friction - kinetic friction)).
A slider in stick creeps at about w.(stick)
The mean power of sliding.toml is 0.04 % below that of the scene; docs/export.md has stick-slip and the cost of a larger w.
Beyond two patch radii, where a run ends with an error, the overlap is that of 1.999998 radii.
";

pub(super) fn netlist(model: &Sliding) -> Netlist {
    let from = &model.parameters;
    let mode = Cantilever::new(from);
    let mut parameters = vec![
        Parameter::new(
            "omega",
            mode.angular_frequency,
            "rad/s",
            "angular frequency of the beam with the slider",
        ),
        Parameter::new("modal_mass_kg", mode.modal_mass, "kg", "modal mass at the tip"),
        Parameter::new(
            "base_coupling",
            mode.participation,
            "1",
            "force of the base per modal mass and acceleration",
        ),
        Parameter::new("damping_ratio", from.damping_ratio, "1", "damping ratio, without friction"),
    ];
    parameters.extend(
        [
            ("slider_mass_kg", from.slider_mass_kg),
            ("patch_radius_m", from.patch_radius_m),
            ("static_friction_active", from.static_friction_active),
            ("static_friction_inert", from.static_friction_inert),
            ("kinetic_friction_active", from.kinetic_friction_active),
            ("kinetic_friction_inert", from.kinetic_friction_inert),
            ("dielectric_thickness_m", from.dielectric_thickness_m),
            ("relative_permittivity", from.relative_permittivity),
            ("charge_density_c_per_m2", from.charge_density_c_per_m2),
        ]
        .map(|(name, value)| Parameter::of_key(&format!("parameters.{name}"), value)),
    );
    let [displacement, velocity, charge] = start(model);
    let speed = CREEP * from.patch_radius_m * mode.angular_frequency;
    parameters.extend([
        Parameter::new("start_displacement_m", displacement, "m", "displacement at the start"),
        Parameter::new("start_velocity_m_per_s", velocity, "m/s", "velocity at the start"),
        Parameter::new("start_charge_c", charge, "C", "charge through the load at the start"),
        Parameter::new("friction_speed_m_per_s", speed, "m/s", "speed w of the regularised friction"),
    ]);
    let frozen = from.stick_charge == StickCharge::Frozen;
    let lateral = if from.lateral_force { " = (ds1/dx) V (sigma S + C V/2)" } else { " = 0" };
    let stick = if frozen { " The terminals have no voltage in it: the factor 1 - k." } else { "" };
    Netlist {
        notes: NOTES
            .replace("(law)", law_name(from.force_law))
            .replace("(lateral)", lateral)
            .replace("(stick)", stick),
        parameters,
        elements: elements(from, frozen),
        points: 1000.0,
        options: "method=gear maxord=2 reltol=1e-5 abstol=1e-12 vntol=1e-9 chgtol=1e-18 itl4=100",
    }
}

/// Displacement in m, velocity in m/s, and charge through the load in C at the start.
fn start(model: &Sliding) -> [f64; 3] {
    let (from, initial) = (&model.parameters, &model.initial);
    let displacement = initial.position_m.unwrap_or(0.0);
    let xi = (displacement / (2.0 * from.patch_radius_m)).abs();
    let inert = FRAC_2_PI * (xi.asin() + xi * (1.0 - xi * xi).sqrt());
    let relaxed = from.charge_density_c_per_m2 * PI * from.patch_radius_m * from.patch_radius_m * inert;
    [displacement, initial.velocity_m_per_s.unwrap_or(0.0), initial.charge_c.unwrap_or(relaxed)]
}

/// The elements; in stick a charge that is frozen has no voltage.
fn elements(from: &SlidingParameters, frozen: bool) -> String {
    // Bounds hold in each guess of the solver only where they stand in the expression: no node has the argument of a root.
    let xi = "min(abs(V(g))*1e-3/(2*patch_radius_m),0.999999)";
    let active = "max(1-V(s),1e-9)";
    let force = match from.force_law {
        ForceLaw::TransferredCharge => format!("pow(V(q)*1e-9,2)/(2*eps_s*{active})"),
        ForceLaw::GapField => format!("relative_permittivity*pow(sigma_s-V(q)*1e-9,2)/(2*eps_s*{active})"),
        ForceLaw::None => "0".to_owned(),
    };
    let lateral = if from.lateral_force {
        let slope = format!("{FRAC_2_PI:e}/patch_radius_m*sqrt(1-pow({xi},2))");
        format!("(V(g)<0 ? 1 : -1)*{slope}*V(u)*(sigma_s+capacitance/2*V(u))")
    } else {
        "0".to_owned()
    };
    let flows = if frozen { "*(1-V(k))" } else { "" };
    format!(
        ".param area={{{PI:e}*patch_radius_m*patch_radius_m}}
.param eps_s={{{VACUUM_PERMITTIVITY:e}*relative_permittivity*area}}
.param capacitance={{eps_s/dielectric_thickness_m}}
.param sigma_s={{charge_density_c_per_m2*area}}
* the overlap, and 1 in stick
Binert s 0 V={FRAC_2_PI:e}*(asin({xi})+{xi}*sqrt(1-pow({xi},2)))
Bstick k 0 V=exp(-pow(min(abs(V(v))/({WIDTH}*friction_speed_m_per_s),30),2))
* the circuit
Bopen u 0 V=(sigma_s*V(s)-V(q)*1e-9)/(capacitance*{active})
Bout p x V=V(u){flows}
Vsense x n 0
Fcharge 0 q Vsense -1
Ccharge q 0 1e-9 IC={{start_charge_c*1e9}}
* the motion
Bkinetic m 0 V=kinetic_friction_inert+(kinetic_friction_active-kinetic_friction_inert)*(1-V(s))
Bstatic h 0 V=static_friction_inert+(static_friction_active-static_friction_inert)*(1-V(s))
Bfriction f 0 V=tanh(V(v)/friction_speed_m_per_s)*(V(m)+(V(h)-V(m))*V(k))*(slider_mass_kg*{GRAVITY}+{force})/modal_mass_kg
Bmotion 0 v I=-omega*omega*V(g)*1e-3-2*damping_ratio*omega*V(v)-base_coupling*V(acc)-V(f)+({lateral})/modal_mass_kg
Cvelocity v 0 1 IC={{start_velocity_m_per_s}}
Bgap 0 g I=V(v)*1e3
Cgap g 0 1 IC={{start_displacement_m*1e3}}
"
    )
}

//! Contact-separation by behavioural sources, with an elastic contact in place of an instantaneous impact.

use model_core::part::VACUUM_PERMITTIVITY;

use super::{Netlist, Parameter, law_name};
use crate::scene_file::{ContactSeparation, ForceLaw, Restitution};

/// Stiffness of the contact as a multiple of that of the spring: a contact lasts 1/20,000 of a natural period.
const CONTACT_STIFFNESS: f64 = 1e8;

const NOTES: &str = "Equations (docs/equations.md), with the gap g, the charge Q through the load, D = g + d_e, d_e = thickness/permittivity:
  mass g'' = -stiffness (g - initial_gap) - 2 damping_ratio sqrt(stiffness mass) g' - mass a - F_e(law)
  V(p,n) = (sigma S g - Q D)/(eps0 S + C_p D)
Acceleration is positive towards an opening gap. Node g is the gap in mm, v its velocity in m/s, q the charge in nC.
Regularised: an impact is a linear spring contact_stiffness_n_per_m with a damper that gives the coefficient of restitution
of the speed at the impact, which node h holds. A coefficient below 1e-3 is 1e-3. The capacitance is that of g = 0 in contact.
The mean power of contact-separation-passive.toml is 0.2 % above that of the scene in periodic motion at 20.5 Hz, 0.3 % on the
upper branch at 22.5 Hz; a hundred times softer contact costs 0.7 % at 20.5 Hz. In chaotic motion only statistics compare.
Left out: sticking as a state. A mass at rest in contact stays on the spring, and its charge flows on through the load
(stick_charge = \"relaxing\").
";

pub(super) fn netlist(model: &ContactSeparation) -> Netlist {
    let from = &model.parameters;
    let mut parameters = Vec::new();
    let mut add = |key: &str, value: f64| parameters.push(Parameter::of_key(key, value));
    for (name, value) in [
        ("mass_kg", from.mass_kg),
        ("stiffness_n_per_m", from.stiffness_n_per_m),
        ("damping_ratio", from.damping_ratio),
        ("initial_gap_m", from.initial_gap_m),
        ("electrode_area_m2", from.electrode_area_m2),
        ("dielectric_thickness_m", from.dielectric_thickness_m),
        ("relative_permittivity", from.relative_permittivity),
        ("charge_density_c_per_m2", from.charge_density_c_per_m2),
        ("parasitic_capacitance_f", from.parasitic_capacitance_f),
    ] {
        add(&format!("parameters.{name}"), value);
    }
    let coefficient = match from.restitution {
        Restitution::Constant { coefficient } => {
            add("parameters.restitution.coefficient", coefficient);
            "restitution_coefficient"
        }
        Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s } => {
            add("parameters.restitution.at_rest", at_rest);
            add("parameters.restitution.at_speed", at_speed);
            add("parameters.restitution.reference_speed_m_per_s", reference_speed_m_per_s);
            "restitution_at_speed+(restitution_at_rest-restitution_at_speed)*exp(-V(h)/restitution_reference_speed_m_per_s)"
        }
    };
    let (gap, velocity, charge) = start(model);
    let mut own = |name: &str, value: f64, unit: &'static str, meaning: &str| {
        parameters.push(Parameter::new(name, value, unit, meaning));
    };
    own("start_gap_m", gap, "m", "gap at the start");
    own("start_velocity_m_per_s", velocity, "m/s", "velocity at the start, opening positive");
    own("start_charge_c", charge, "C", "charge through the load at the start");
    let stiffness = CONTACT_STIFFNESS * from.stiffness_n_per_m;
    own("contact_stiffness_n_per_m", stiffness, "N/m", "stiffness of the contact");
    Netlist {
        notes: NOTES.replace("(law)", law_name(from.force_law)),
        parameters,
        elements: elements(from.force_law, coefficient),
        points: 1000.0,
        options: "method=trap maxord=2 reltol=1e-5 abstol=1e-12 vntol=1e-9 chgtol=1e-18 itl4=100",
    }
}

/// Gap in m, velocity in m/s, and charge through the load in C at the start.
fn start(model: &ContactSeparation) -> (f64, f64, f64) {
    let (from, initial) = (&model.parameters, &model.initial);
    let gap = initial.position_m.unwrap_or(from.initial_gap_m);
    let thickness = from.dielectric_thickness_m / from.relative_permittivity;
    let charge = from.charge_density_c_per_m2 * from.electrode_area_m2;
    let transferred = initial.charge_c.unwrap_or(charge * gap / (gap + thickness));
    let voltage =
        (charge * gap - transferred * (gap + thickness)) / (VACUUM_PERMITTIVITY * from.electrode_area_m2);
    (gap, initial.velocity_m_per_s.unwrap_or(0.0), transferred - from.parasitic_capacitance_f * voltage)
}

/// The elements, with a coefficient of restitution as an expression.
fn elements(law: ForceLaw, coefficient: &str) -> String {
    // Units near one keep the solver's absolute tolerances below the relative one.
    let gap = "max(V(g),0)*1e-3";
    let distance = format!("({gap}+d_e)");
    let charge = "(V(q)*1e-9+parasitic_capacitance_f*V(p,n))";
    let force = match law {
        ForceLaw::TransferredCharge => {
            format!("pow({charge}/(1+parasitic_capacitance_f/eps_s*{distance}),2)/(2*eps_s)")
        }
        ForceLaw::GapField => format!("pow(sigma_s-{charge},2)/(2*eps_s)"),
        ForceLaw::None => "0".to_owned(),
    };
    format!(
        ".param d_e={{dielectric_thickness_m/relative_permittivity}}
.param eps_s={{{VACUUM_PERMITTIVITY:e}*electrode_area_m2}}
.param sigma_s={{charge_density_c_per_m2*electrode_area_m2}}
.param omega={{sqrt(stiffness_n_per_m/mass_kg)}}
.param omega_c={{sqrt(contact_stiffness_n_per_m/mass_kg)}}
* the circuit
Bout p x V=(sigma_s*{gap}-V(q)*1e-9*{distance})/(eps_s+parasitic_capacitance_f*{distance})
Vsense x n 0
Fcharge 0 q Vsense -1
Ccharge q 0 1e-9 IC={{start_charge_c*1e9}}
* the motion
Bmotion 0 v I=omega*omega*(initial_gap_m-V(g)*1e-3)-2*damping_ratio*omega*V(v)-V(acc)-({force})/mass_kg
Bcontact 0 v I=(V(g)<0 ? -omega_c*omega_c*V(g)*1e-3-2*omega_c*V(z)*V(v) : 0)
Cvelocity v 0 1 IC={{start_velocity_m_per_s}}
Bgap 0 g I=V(v)*1e3
Cgap g 0 1 IC={{start_gap_m*1e3}}
* the damping ratio of the contact by the speed at the impact
Bspeed 0 h I=(V(g)>0 ? (abs(V(v))-V(h))*1e5 : 0)
Cspeed h 0 1 IC={{abs(start_velocity_m_per_s)}}
Bln ln 0 V=-ln(max({coefficient},1e-3))
Bratio z 0 V=V(ln)/sqrt({:e}+V(ln)*V(ln))
",
        std::f64::consts::PI.powi(2)
    )
}

//! The parts of a scene that can be left out, and the scene without one.

use crate::outcome::Outcome;
use crate::scene_file::{
    BumpStop, Contact, Coupling, Draw, ForceLaw, Load, Model, Restitution, Scene, StickCharge, StopParameters,
};

/// A part of a scene that can be left out, with what stands in for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Part {
    /// Modes of the beam above this number.
    BeamModes(usize),
    /// Modes of the rod above this number.
    RodModes(usize),
    /// The rod: its static compliance stays.
    Rod,
    Stop,
    /// The compliance of the modes that are left out: the contact becomes a constraint.
    ResidualCompliance,
    /// The compliance in series with the contact.
    ContactCompliance,
    /// The rotary inertia of the tip mass.
    RotaryInertia,
    /// The distance of the centre of the tip mass beyond the end of the beam.
    TipMassOffset,
    /// The effect of the voltage on the beam.
    TwoWayCoupling,
    /// The electrostatic force on the motion.
    ElectrostaticForce,
    /// The electrostatic force along the plane.
    LateralForce,
    ParasiticCapacitance,
    /// The dependence of the restitution on the speed: this coefficient instead.
    RestitutionBySpeed(f64),
    Friction,
    /// Stick of the mass or the slider. The scene stays as it is: without a stick its code never runs.
    Sticking,
    /// The behaviour of the charge in stick: the other one instead.
    StickCharge,
    /// The bridge and what is behind it: this resistor in Ω instead.
    Bridge(f64),
    /// The storage: a bus of this voltage in V instead.
    Storage(f64),
    DiodeDrop,
    Leakage,
    Draw,
}

impl Part {
    /// What is left out, and what stands in for it.
    pub(crate) fn name(self) -> String {
        match self {
            Self::BeamModes(count) => format!("beam modes above {count}"),
            Self::RodModes(count) => format!("rod modes above {count}"),
            Self::Rod => "rod (a spring instead)".to_owned(),
            Self::Stop => "stop".to_owned(),
            Self::ResidualCompliance => "residual compliance (a constraint instead)".to_owned(),
            Self::ContactCompliance => "contact compliance".to_owned(),
            Self::RotaryInertia => "rotary inertia of the tip mass".to_owned(),
            Self::TipMassOffset => "offset of the tip mass".to_owned(),
            Self::TwoWayCoupling => "two-way coupling".to_owned(),
            Self::ElectrostaticForce => "electrostatic force".to_owned(),
            Self::LateralForce => "lateral force".to_owned(),
            Self::ParasiticCapacitance => "parasitic capacitance".to_owned(),
            Self::RestitutionBySpeed(constant) => format!("restitution by speed ({constant:.3} instead)"),
            Self::Friction => "friction".to_owned(),
            Self::Sticking => "sticking".to_owned(),
            Self::StickCharge => "charge in stick (the other behaviour instead)".to_owned(),
            Self::Bridge(resistance_ohm) => format!("bridge ({resistance_ohm:.3e} ohm instead)"),
            Self::Storage(voltage_v) => format!("storage (a bus of {voltage_v:.3} V instead)"),
            Self::DiodeDrop => "diode drop".to_owned(),
            Self::Leakage => "leakage".to_owned(),
            Self::Draw => "draw of the node".to_owned(),
        }
    }

    pub(crate) fn leave_out(self, scene: &mut Scene) {
        match &mut scene.load {
            load @ (Load::RectifiedStore(_) | Load::DcBus { .. }) => self.leave_out_of_load(load),
            Load::Resistor { .. } => {}
        }
        match &mut scene.model {
            Model::ContactSeparation(model) => {
                let parameters = &mut model.parameters;
                match self {
                    Self::ElectrostaticForce => parameters.force_law = ForceLaw::None,
                    Self::ParasiticCapacitance => parameters.parasitic_capacitance_f = 0.0,
                    Self::RestitutionBySpeed(coefficient) => {
                        parameters.restitution = Restitution::Constant { coefficient };
                    }
                    Self::StickCharge => parameters.stick_charge = other(parameters.stick_charge),
                    _ => {}
                }
            }
            Model::Sliding(model) => {
                let parameters = &mut model.parameters;
                match self {
                    Self::ElectrostaticForce => parameters.force_law = ForceLaw::None,
                    Self::LateralForce => parameters.lateral_force = false,
                    Self::StickCharge => parameters.stick_charge = other(parameters.stick_charge),
                    Self::Friction => {
                        parameters.static_friction_active = 0.0;
                        parameters.static_friction_inert = 0.0;
                        parameters.kinetic_friction_active = 0.0;
                        parameters.kinetic_friction_inert = 0.0;
                    }
                    _ => {}
                }
            }
            Model::BumpStop(model) => self.leave_out_of_beam(model),
        }
    }

    fn leave_out_of_beam(self, model: &mut BumpStop) {
        let initial = &mut model.initial;
        match self {
            Self::BeamModes(count) => {
                model.parameters.beam_modes = count;
                initial.modal_displacement.truncate(count);
                initial.modal_velocity.truncate(count);
            }
            Self::TwoWayCoupling => model.parameters.coupling = Coupling::OneWay,
            Self::Stop => model.stop = None,
            _ => {}
        }
        if let Some(body) = &mut model.parameters.tip_mass {
            match self {
                Self::RotaryInertia => body.rotary_inertia_kg_m2 = 0.0,
                Self::TipMassOffset => body.offset_m = 0.0,
                _ => {}
            }
        }
        if let Self::Rod | Self::Stop | Self::RodModes(_) = self {
            let count = if let Self::RodModes(count) = self { count } else { 0 };
            initial.rod_modal_displacement.truncate(count);
            initial.rod_modal_velocity.truncate(count);
        }
        if let Some(stop) = &mut model.stop {
            self.leave_out_of_stop(stop);
        }
    }

    fn leave_out_of_stop(self, stop: &mut StopParameters) {
        match self {
            Self::RodModes(count) => stop.rod_modes = count,
            Self::Rod => stop.rod_modes = 0,
            Self::ResidualCompliance => stop.contact = Contact::DisplacementConstraint,
            Self::ContactCompliance => stop.contact_compliance_m_per_n = 0.0,
            _ => {}
        }
    }

    fn leave_out_of_load(self, load: &mut Load) {
        match (self, load) {
            (Self::Bridge(resistance_ohm), load) => *load = Load::Resistor { resistance_ohm },
            (Self::Storage(voltage_v), load) => {
                if let Load::RectifiedStore(store) = *load {
                    *load = Load::DcBus { voltage_v, diode_drop_v: store.diode_drop_v };
                }
            }
            (Self::DiodeDrop, Load::RectifiedStore(store)) => store.diode_drop_v = 0.0,
            (Self::DiodeDrop, Load::DcBus { diode_drop_v, .. }) => *diode_drop_v = 0.0,
            (Self::Leakage, Load::RectifiedStore(store)) => store.leakage_ohm = f64::INFINITY,
            (Self::Draw, Load::RectifiedStore(store)) => store.draw = Draw::None,
            _ => {}
        }
    }
}

fn other(charge: StickCharge) -> StickCharge {
    match charge {
        StickCharge::Frozen => StickCharge::Relaxing,
        StickCharge::Relaxing => StickCharge::Frozen,
    }
}

/// The parts that a scene has, but for its modes. What stands in for a part follows from `full`, the run of the scene.
pub(crate) fn parts(scene: &Scene, full: &Outcome) -> Vec<Part> {
    let mut parts = match &scene.model {
        Model::ContactSeparation(model) => {
            let from = &model.parameters;
            let by_speed = constant_restitution(&from.restitution, full).map(Part::RestitutionBySpeed);
            let mut parts = vec![Part::Sticking, Part::StickCharge];
            parts.extend((from.force_law != ForceLaw::None).then_some(Part::ElectrostaticForce));
            parts.extend((from.parasitic_capacitance_f > 0.0).then_some(Part::ParasiticCapacitance));
            parts.extend(by_speed);
            parts
        }
        Model::Sliding(model) => {
            let from = &model.parameters;
            let rubs = from.static_friction_active > 0.0 || from.static_friction_inert > 0.0;
            let mut parts = vec![Part::Sticking, Part::StickCharge];
            parts.extend(rubs.then_some(Part::Friction));
            parts.extend((from.force_law != ForceLaw::None).then_some(Part::ElectrostaticForce));
            parts.extend(from.lateral_force.then_some(Part::LateralForce));
            parts
        }
        Model::BumpStop(model) => {
            let two_way = model.parameters.coupling == Coupling::TwoWay;
            let mut parts: Vec<Part> = two_way.then_some(Part::TwoWayCoupling).into_iter().collect();
            if let Some(body) = model.parameters.tip_mass {
                parts.extend((body.rotary_inertia_kg_m2 > 0.0).then_some(Part::RotaryInertia));
                parts.extend((body.offset_m != 0.0).then_some(Part::TipMassOffset));
            }
            if let Some(stop) = &model.stop {
                parts.push(Part::Stop);
                let flexible = stop.contact == Contact::ResidualFlexibility;
                parts.extend((flexible && stop.rod_modes > 0).then_some(Part::Rod));
                parts.extend((flexible && stop.rod_modes > 0).then_some(Part::ResidualCompliance));
                parts.extend((stop.contact_compliance_m_per_n > 0.0).then_some(Part::ContactCompliance));
            }
            parts
        }
    };
    parts.extend(parts_of_load(&scene.load, full));
    parts
}

/// The coefficient at the largest impact speed, or without impacts at rest; `None` if it is constant already.
fn constant_restitution(restitution: &Restitution, full: &Outcome) -> Option<f64> {
    let Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s } = *restitution else {
        return None;
    };
    let speed = full.contact_separation().and_then(|found| found.max_impact_speed_m_per_s).unwrap_or(0.0);
    Some(at_speed + (at_rest - at_speed) * (-speed / reference_speed_m_per_s).exp())
}

fn parts_of_load(load: &Load, full: &Outcome) -> Vec<Part> {
    let mut parts = Vec::new();
    let drop = match *load {
        Load::Resistor { .. } => return parts,
        Load::DcBus { diode_drop_v, .. } => diode_drop_v,
        Load::RectifiedStore(store) => {
            let end = full.store.and_then(|store| store.store_voltage_v).unwrap_or(store.initial_v);
            let is_mean = full.store.is_some_and(|store| store.cycles.is_some());
            let mean = if is_mean { end } else { 0.5 * (store.initial_v + end) };
            parts.extend((mean > 0.0).then_some(Part::Storage(mean)));
            parts.extend(store.leakage_ohm.is_finite().then_some(Part::Leakage));
            parts.extend((store.draw != Draw::None).then_some(Part::Draw));
            store.diode_drop_v
        }
    };
    parts.extend((drop > 0.0).then_some(Part::DiodeDrop));
    if let (Some(voltage), Some(power)) = (full.rms_voltage_v, full.mean_power_w)
        && power > 0.0
    {
        parts.push(Part::Bridge(voltage * voltage / power));
    }
    parts
}

/// The numbers of modes of beam and rod of a bump-stop scene.
pub(crate) fn modes(scene: &Scene) -> [usize; 2] {
    scene.bump_stop().map_or([0; 2], BumpStop::modes)
}

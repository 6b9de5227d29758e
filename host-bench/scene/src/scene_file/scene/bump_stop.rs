//! A bump-stop scene as plain numbers.

/// A bump-stop harvester and the state it starts in.
#[derive(Debug, Clone, PartialEq)]
pub struct BumpStop {
    /// Table `[parameters]`.
    pub parameters: BumpStopParameters,
    /// Table `[stop]`; `None`: the beam swings freely.
    pub stop: Option<StopParameters>,
    /// Table `[initial]`.
    pub initial: BumpStopStart,
}

/// `[parameters]` of a bump-stop scene: a cantilever of a substrate and one piezoelectric layer, both of
/// its full length and width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BumpStopParameters {
    /// Length of the beam in m.
    pub beam_length_m: f64,
    /// Width of the beam in m.
    pub beam_width_m: f64,
    /// Thickness of the substrate in m.
    pub substrate_thickness_m: f64,
    /// Young's modulus of the substrate in Pa.
    pub substrate_young_modulus_pa: f64,
    /// Density of the substrate in kg/m³.
    pub substrate_density_kg_per_m3: f64,
    /// Thickness of the piezoelectric layer in m.
    pub piezo_thickness_m: f64,
    /// Young's modulus of the piezoelectric layer in Pa, short-circuit.
    pub piezo_young_modulus_pa: f64,
    /// Density of the piezoelectric layer in kg/m³.
    pub piezo_density_kg_per_m3: f64,
    /// Piezoelectric constant d31 in m/V; its sign does not matter, the electrodes are taken so that
    /// the voltage rises as the tip moves towards the stop.
    pub piezo_d31_m_per_v: f64,
    /// Permittivity ε33 in F/m at constant strain.
    pub piezo_permittivity_f_per_m: f64,
    /// Damping ratio of every mode of beam and rod.
    pub damping_ratio: f64,
    /// Bending modes kept.
    pub beam_modes: usize,
    /// Whether the voltage acts back on the beam.
    pub coupling: Coupling,
    /// Table `[tip_mass]`; `None`: a free end.
    pub tip_mass: Option<TipMassParameters>,
}

/// `[tip_mass]` of a bump-stop scene: a rigid body at the free end of the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipMassParameters {
    /// Mass in kg.
    pub mass_kg: f64,
    /// Rotary inertia in kg·m² about the body's own centre of mass, for rotation in the plane of bending.
    pub rotary_inertia_kg_m2: f64,
    /// Distance in m of the body's centre of mass beyond the end of the beam, along the beam.
    pub offset_m: f64,
}

/// Whether the voltage acts back on the beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// It does: what is harvested is taken from the motion.
    TwoWay,
    /// It does not: the beam drives the circuit and does not feel it.
    OneWay,
}

/// `[stop]` of a bump-stop scene: an elastic rod that stands on the base, its face beside the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopParameters {
    /// Length of the rod in m.
    pub length_m: f64,
    /// Width of the rod in m.
    pub width_m: f64,
    /// Thickness of the rod in m.
    pub thickness_m: f64,
    /// Young's modulus of the rod in Pa.
    pub young_modulus_pa: f64,
    /// Density of the rod in kg/m³.
    pub density_kg_per_m3: f64,
    /// Distance in m of the point of contact from the clamp, at most the length of the beam.
    pub position_m: f64,
    /// Distance in m between beam and rod, both at rest.
    pub gap_m: f64,
    /// Longitudinal modes of the rod that are kept; 0: a rod without mass.
    pub rod_modes: usize,
    /// How the contact is closed.
    pub contact: Contact,
    /// Compliance in m/N in series with the contact, beside that of the modes left out.
    pub contact_compliance_m_per_n: f64,
    /// Coefficient of restitution, 0 to 1; there under [`Contact::Restitution`], and only there.
    pub restitution: Option<f64>,
}

/// How a contact is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contact {
    /// Through the static compliance of the modes that are left out.
    ResidualFlexibility,
    /// Rigidly, by impacts between the modes that are kept.
    Restitution,
    /// By a force in each time step that makes the gap zero at its end: the paper's method.
    DisplacementConstraint,
}

/// `[initial]` of a bump-stop scene.
#[derive(Debug, Clone, PartialEq)]
pub struct BumpStopStart {
    /// Modal displacements of the beam in √kg·m, one for each mode.
    pub modal_displacement: Vec<f64>,
    /// Modal velocities of the beam in √kg·m/s, one for each mode.
    pub modal_velocity: Vec<f64>,
    /// Modal displacements of the rod in √kg·m, one for each mode.
    pub rod_modal_displacement: Vec<f64>,
    /// Modal velocities of the rod in √kg·m/s, one for each mode.
    pub rod_modal_velocity: Vec<f64>,
    /// Voltage in V; behind a short circuit there is none.
    pub voltage_v: f64,
}

impl BumpStopStart {
    /// At rest, without voltage.
    #[must_use]
    pub fn at_rest(beam_modes: usize, rod_modes: usize) -> Self {
        Self {
            modal_displacement: vec![0.0; beam_modes],
            modal_velocity: vec![0.0; beam_modes],
            rod_modal_displacement: vec![0.0; rod_modes],
            rod_modal_velocity: vec![0.0; rod_modes],
            voltage_v: 0.0,
        }
    }
}

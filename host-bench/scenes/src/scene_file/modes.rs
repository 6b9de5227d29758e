//! Modes of a clamped piezoelectric beam and of the rod that it hits.
//!
//! The beam is a clamped-free Euler-Bernoulli beam of two or three layers; the rod is fixed at its base and free at its face. Modes are
//! normalised to unit modal mass. The electrodes cover the whole length of the piezoelectric layer, so its coupling is that of the
//! slope at the tip: Erturk and Inman, J. Vib. Acoust. 130 (2008). With a tip mass the beam has other modes and the same section. They
//! are for the checks of the reader, the reference and the peers.

mod cantilever;
mod tip_mass;

use std::f64::consts::{PI, TAU};

pub use self::cantilever::Cantilever;
use self::tip_mass::Body;
use crate::scene_file::{BumpStop, BumpStopParameters, StopParameters};

/// A bending mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamMode {
    /// `λ`, the wave number times the length: without a tip mass, root of `cos λ cosh λ = −1`.
    pub eigenvalue: f64,
    /// Angular frequency in rad/s, short-circuit and undamped.
    pub angular_frequency: f64,
    /// `γ = ∫ m' φ dx` in √kg, and the mass of a tip mass times the shape at its centre: participation factor of the base acceleration.
    pub participation: f64,
    /// `θ` in N/(V √kg): force of one volt on the mode, and charge of one unit of it.
    pub coupling: f64,
    /// Curvature `φ''(0)` at the clamp in 1/(m² √kg).
    pub clamp_curvature: f64,
    /// Shape at the tip in 1/√kg.
    pub at_tip: f64,
    /// Shape at the point of contact in 1/√kg; 0 without a stop.
    pub at_stop: f64,
}

/// A longitudinal mode of the rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RodMode {
    /// Angular frequency in rad/s, undamped.
    pub angular_frequency: f64,
    /// `∫ ρ A ψ dξ` in √kg: participation factor of the base acceleration.
    pub participation: f64,
    /// Shape at the face in 1/√kg.
    pub at_face: f64,
}

/// Modes of beam and rod, and the static compliance of the modes left out.
#[derive(Debug, Clone, PartialEq)]
pub struct BumpStopModes {
    pub beam: Vec<BeamMode>,
    pub rod: Vec<RodMode>,
    /// Capacitance of the piezoelectric layer in F.
    pub capacitance: f64,
    /// Bending stiffness in N·m², short-circuit.
    pub bending_stiffness: f64,
    /// Mass of the beam in kg, without the tip mass.
    pub beam_mass: f64,
    /// Static compliance in m/N of the beam's modes left out, at the point of contact.
    pub beam_residual: f64,
    /// The same of the rod's at its face.
    pub rod_residual: f64,
    /// Static curvature at the clamp of the beam's modes left out, in 1/m: for a force of 1 N at the point of contact, a
    /// base acceleration of 1 m/s², and a voltage of 1 V, all negative.
    pub clamp_residual: [f64; 3],
    /// Distance in m of the outer face of substrate and piezoelectric layer from the neutral axis, and the modulus in Pa.
    pub fibres: [[f64; 2]; 2],
}

/// A beam's cross section of two layers, or of three for a bimorph.
struct Section {
    /// Bending stiffness `E I` in N·m².
    bending_stiffness: f64,
    /// Mass per length in kg/m.
    mass_per_length: f64,
    /// Bending moment of one volt in N·m/V, and charge of one radian of slope at the tip.
    moment_per_volt: f64,
    /// Distance in m of each outer face from the neutral axis, and the modulus in Pa.
    fibres: [[f64; 2]; 2],
}

impl Section {
    fn new(from: &BumpStopParameters) -> Self {
        let (width, substrate, piezo) =
            (from.beam_width_m, from.substrate_thickness_m, from.piezo_thickness_m);
        let [count, in_series] = from.layers();
        // From the lower face of the substrate.
        let mut layers = vec![
            (from.substrate_young_modulus_pa, substrate, 0.5 * substrate),
            (from.piezo_young_modulus_pa, piezo, substrate + 0.5 * piezo),
        ];
        layers.extend((count == 2.0).then_some((from.piezo_young_modulus_pa, piezo, -0.5 * piezo)));
        let stiffness: f64 = layers.iter().map(|(modulus, thickness, _)| modulus * thickness).sum();
        let moment: f64 =
            layers.iter().map(|(modulus, thickness, middle)| modulus * thickness * middle).sum();
        let neutral = moment / stiffness;
        let bending = layers.iter().map(|(modulus, thickness, middle)| {
            modulus * thickness * (thickness * thickness / 12.0 + (middle - neutral).powi(2))
        });
        let (_, _, piezo_middle) = layers[1];
        Self {
            bending_stiffness: width * bending.sum::<f64>(),
            mass_per_length: width
                * (from.substrate_density_kg_per_m3 * substrate
                    + count * from.piezo_density_kg_per_m3 * piezo),
            moment_per_volt: (from.piezo_young_modulus_pa * from.piezo_d31_m_per_v).abs()
                * width
                * (piezo_middle - neutral)
                * (count / in_series),
            fibres: [
                [neutral, from.substrate_young_modulus_pa],
                [substrate + piezo - neutral, from.piezo_young_modulus_pa],
            ],
        }
    }

    /// Bending mode number `index` (from 0) of a beam of a length in m without a tip mass.
    fn free_mode(&self, index: usize, length: f64, stop: Option<&StopParameters>) -> BeamMode {
        let root_mass = (self.mass_per_length * length).sqrt();
        let scale = (self.bending_stiffness / self.mass_per_length).sqrt() / (length * length);
        let eigenvalue = eigenvalue(index);
        let ratio = shape_ratio(eigenvalue);
        let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let at_stop = stop.map_or(0.0, |stop| {
            if stop.position_m == length { 2.0 * sign } else { shape(eigenvalue, stop.position_m / length) }
        });
        let slope_at_tip = sign * 2.0 * eigenvalue * ratio / (length * root_mass);
        BeamMode {
            eigenvalue,
            angular_frequency: eigenvalue * eigenvalue * scale,
            participation: 2.0 * ratio * root_mass / eigenvalue,
            coupling: self.moment_per_volt * slope_at_tip,
            clamp_curvature: 2.0 * eigenvalue * eigenvalue / (length * length * root_mass),
            at_tip: 2.0 * sign / root_mass,
            at_stop: at_stop / root_mass,
        }
    }
}

/// Root number `index` (from 0) of `cos λ cosh λ = −1`, by Newton's iteration on `cos λ + 1 / cosh λ`.
fn eigenvalue(index: usize) -> f64 {
    let mut root = (index as f64 + 0.5) * PI;
    // The start is within 0.31 of the root, and the convergence is quadratic.
    for _ in 0..12 {
        let inverse = root.cosh().recip();
        root -= (root.cos() + inverse) / (-root.sin() - inverse * root.tanh());
    }
    root
}

/// `(sinh λ − sin λ) / (cosh λ + cos λ)`.
fn shape_ratio(eigenvalue: f64) -> f64 {
    (eigenvalue.sinh() - eigenvalue.sin()) / (eigenvalue.cosh() + eigenvalue.cos())
}

/// `cosh u − cos u − σ (sinh u − sin u)` at `u = λ s`.
///
/// `1 − σ = (e^−λ + cos λ + sin λ) / (cosh λ + cos λ)` in `(1−σ) e^u / 2` avoids the difference of two exponentials.
fn shape(eigenvalue: f64, place: f64) -> f64 {
    let ratio = shape_ratio(eigenvalue);
    let u = eigenvalue * place;
    let decay = (-eigenvalue).exp();
    // cosh λ + cos λ, over e^λ.
    let denominator = 0.5 * (1.0 + decay * decay) + eigenvalue.cos() * decay;
    let growing = 0.5 * (decay + eigenvalue.cos() + eigenvalue.sin()) / denominator * (u - eigenvalue).exp();
    let falling = 0.5 * (1.0 + ratio) * (-u).exp();
    growing + falling - u.cos() + ratio * u.sin()
}

impl BumpStop {
    /// Natural frequencies in Hz, rising, of the modes kept of the beam, short-circuit and undamped, and of the rod.
    pub fn natural_frequencies_hz(&self) -> [Vec<f64>; 2] {
        BumpStopModes::new(&self.parameters, self.stop.as_ref()).natural_frequencies_hz()
    }
}

impl BumpStopModes {
    /// The modes that a scene keeps.
    pub fn new(from: &BumpStopParameters, stop: Option<&StopParameters>) -> Self {
        let section = Section::new(from);
        let [count, in_series] = from.layers();
        let length = from.beam_length_m;
        let beam_mass = section.mass_per_length * length;
        let beam: Vec<BeamMode> = match &from.tip_mass {
            None => (0..from.beam_modes).map(|index| section.free_mode(index, length, stop)).collect(),
            Some(body) => {
                let body = Body::new(body, beam_mass, length);
                let place = stop.map(|stop| stop.position_m / length);
                let eigenvalues = body.eigenvalues(from.beam_modes).into_iter();
                eigenvalues.map(|eigenvalue| body.mode(eigenvalue, &section, length, place)).collect()
            }
        };
        let (rod, rod_residual) = stop.map_or((Vec::new(), 0.0), rod);
        let beam_residual = stop.map_or(0.0, |stop| {
            let modal: f64 = beam.iter().map(|mode| (mode.at_stop / mode.angular_frequency).powi(2)).sum();
            let residual = stop.position_m.powi(3) / (3.0 * section.bending_stiffness) - modal;
            // Of a heavy tip mass at the contact the modes left out have less than the rounding.
            if from.tip_mass.is_some() { residual.max(0.0) } else { residual }
        });
        let compliance = |mode: &BeamMode| mode.clamp_curvature / mode.angular_frequency.powi(2);
        let modal =
            |of: fn(&BeamMode) -> f64| beam.iter().map(|mode| compliance(mode) * of(mode)).sum::<f64>();
        let weight = from.tip_mass.map_or(0.0, |body| body.mass_kg * (length + body.offset_m));
        let moments = [
            stop.map_or(0.0, |stop| stop.position_m),
            0.5 * beam_mass * length + weight,
            section.moment_per_volt,
        ]
        .map(|moment| moment / section.bending_stiffness);
        let clamp_residual = [
            moments[0] - modal(|mode| mode.at_stop),
            moments[1] - modal(|mode| mode.participation),
            moments[2] - modal(|mode| mode.coupling),
        ];
        Self {
            beam,
            rod,
            capacitance: from.piezo_permittivity_f_per_m * from.beam_width_m * length
                / from.piezo_thickness_m
                * (count / (in_series * in_series)),
            bending_stiffness: section.bending_stiffness,
            beam_mass,
            beam_residual,
            rod_residual,
            clamp_residual,
            fibres: section.fibres,
        }
    }

    /// Natural frequencies in Hz, rising, of the beam and of the rod.
    pub fn natural_frequencies_hz(&self) -> [Vec<f64>; 2] {
        let beam = self.beam.iter().map(|mode| mode.angular_frequency / TAU);
        let rod = self.rod.iter().map(|mode| mode.angular_frequency / TAU);
        [beam.collect(), rod.collect()]
    }

    /// Approach of beam and rod in m since rest, from their modal displacements in √kg·m.
    pub fn approach(&self, beam: &[f64], rod: &[f64]) -> f64 {
        let beam: f64 = self.beam.iter().zip(beam).map(|(mode, value)| mode.at_stop * value).sum();
        let rod: f64 = self.rod.iter().zip(rod).map(|(mode, value)| mode.at_face * value).sum();
        beam - rod
    }
}

/// Modes of the rod, and the static compliance of those left out.
fn rod(stop: &StopParameters) -> (Vec<RodMode>, f64) {
    let area = stop.width_m * stop.thickness_m;
    let mass = stop.density_kg_per_m3 * area * stop.length_m;
    let speed = (stop.young_modulus_pa / stop.density_kg_per_m3).sqrt();
    let modes: Vec<RodMode> = (0..stop.rod_modes)
        .map(|index| {
            // Quarter waves along the rod.
            let quarters = (2 * index + 1) as f64;
            let sign = if index % 2 == 0 { 1.0 } else { -1.0 };
            RodMode {
                angular_frequency: quarters * PI * speed / (2.0 * stop.length_m),
                participation: 2.0 * (2.0 * mass).sqrt() / (quarters * PI),
                at_face: sign * (2.0 / mass).sqrt(),
            }
        })
        .collect();
    let modal: f64 = modes.iter().map(|mode| (mode.at_face / mode.angular_frequency).powi(2)).sum();
    let whole = stop.length_m / (stop.young_modulus_pa * area);
    (modes, whole - modal)
}

/// Means of a function and of its square from 0 to 1: the Gauss-Legendre rule of five points on `pieces` equal pieces.
fn means(pieces: u32, of: impl Fn(f64) -> f64) -> [f64; 2] {
    let root = (10f64 / 7.0).sqrt();
    let [inner, outer] = [(5.0 - 2.0 * root).sqrt() / 3.0, (5.0 + 2.0 * root).sqrt() / 3.0];
    let [near, far] = [(322.0 + 13.0 * 70f64.sqrt()) / 900.0, (322.0 - 13.0 * 70f64.sqrt()) / 900.0];
    let points = [(-outer, far), (-inner, near), (0.0, 128.0 / 225.0), (inner, near), (outer, far)];
    let mut means = [0.0, 0.0];
    for piece in 0..pieces {
        for (abscissa, weight) in points {
            let value = of((f64::from(piece) + 0.5 + 0.5 * abscissa) / f64::from(pieces));
            let weight = 0.5 * weight / f64::from(pieces);
            means[0] += weight * value;
            means[1] += weight * value * value;
        }
    }
    means
}

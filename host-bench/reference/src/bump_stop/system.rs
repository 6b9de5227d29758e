//! The bump-stop harvester as a linear system `y' = A y` for each state of contact and circuit.
//!
//! Equations (1) to (4) and (10) of Mak, McWilliam, Popov and Fox in modal coordinates `r`, `q`, with the
//! back-coupling that conserves energy:
//!
//! ```text
//! r_i'' + 2ζω_i r_i' + ω_i² r_i = −γ_i a − φ_i F − θ_i v
//! q_j'' + 2ζΩ_j q_j' + Ω_j² q_j = −g_j a + ψ_j F
//! C v' = Σ θ_i r_i' − v / R
//! ```
//!
//! The coordinates are scaled so that half their square is energy: `ω r`, `r'`, `Ω q`, `q'`, `√C v`, and `√C_s V_s` of a storage. The
//! vector holds after them a constant 1, the generators of the base acceleration (a polynomial, sine and cosine of each tone), and the
//! generator of a constant power. The contact force and every current are rows times this vector, so its propagation is exact.

use nalgebra::DMatrix;

use crate::ledger::{Integrals, integral};
use crate::storage::Storage;
use harvester_scene::base_motion::LocalBase;
use harvester_scene::scene_file::modes::BumpStopModes;
use harvester_scene::scene_file::{BumpStop, BumpStopStart, Contact, Coupling, Draw, Load};

#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    beam: usize,
    rod: usize,
    tones: usize,
    /// The straight line of the base acceleration and its slope, or its polynomial and all derivatives.
    powers: usize,
    has_power: bool,
}

impl Layout {
    /// Scaled displacement and velocity of a mode of the beam.
    fn beam(&self, mode: usize) -> [usize; 2] {
        [mode, self.beam + mode]
    }

    /// Scaled displacement and velocity of a mode of the rod.
    fn rod(&self, mode: usize) -> [usize; 2] {
        [2 * self.beam + mode, 2 * self.beam + self.rod + mode]
    }

    /// Scaled voltage; all before it is mechanical.
    pub(super) fn voltage(&self) -> usize {
        2 * (self.beam + self.rod)
    }

    /// Scaled voltage of the storage.
    pub(super) fn storage(&self) -> usize {
        self.voltage() + 1
    }

    /// The constant 1.
    pub(super) fn one(&self) -> usize {
        self.storage() + 1
    }

    /// The polynomial of the base acceleration and its derivatives.
    fn polynomial(&self) -> std::ops::Range<usize> {
        self.one() + 1..self.one() + 1 + self.powers
    }

    /// Sine and cosine of a tone.
    fn tone(&self, tone: usize) -> [usize; 2] {
        let after = self.polynomial().end + 2 * tone;
        [after, after + 1]
    }

    /// Current in A of a draw of constant power, as a straight line, and its slope.
    pub(super) fn draw(&self) -> [usize; 2] {
        let after = self.polynomial().end + 2 * self.tones;
        [after, after + 1]
    }

    /// Scaled displacement and velocity of each mode, the beam's first, and the scaled voltage.
    pub(super) fn by_mode(&self, vector: &[f64]) -> Vec<f64> {
        let (beam, rod) =
            ((0..self.beam).map(|mode| self.beam(mode)), (0..self.rod).map(|mode| self.rod(mode)));
        beam.chain(rod).flatten().chain([self.voltage()]).map(|place| vector[place]).collect()
    }

    pub(super) fn size(&self) -> usize {
        let [draw, _] = self.draw();
        draw + if self.has_power { 2 } else { 0 }
    }
}

/// A linear quantity: its value is this row times the vector.
pub(super) type Row = Vec<f64>;

pub(super) fn value(row: &[f64], vector: &[f64]) -> f64 {
    // Four sums side by side, for speed.
    let (rows, vectors) = (row.chunks_exact(4), vector.chunks_exact(4));
    let rest: f64 = rows.remainder().iter().zip(vectors.remainder()).map(|(one, other)| one * other).sum();
    let mut sums = [0.0; 4];
    for (row, vector) in rows.zip(vectors) {
        for ((sum, one), other) in sums.iter_mut().zip(row).zip(vector) {
            *sum += one * other;
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// The harvester, without what depends on the state of contact.
pub(super) struct System {
    pub(super) modes: BumpStopModes,
    pub(super) layout: Layout,
    /// Matrix without contact and without storage; the terminals are on a resistor, or open behind a bridge.
    pub(super) free: DMatrix<f64>,
    /// Rate of the vector for a contact force of 1 N.
    pub(super) push: Row,
    /// Penetration in m: negative while the contact is open. Zero weights without a stop.
    pub(super) gap: Row,
    /// Rate of the penetration in m/s.
    pub(super) gap_rate: Row,
    /// Displacement of the tip in m.
    pub(super) tip: Row,
    /// Displacement in m of the beam at the point of contact.
    pub(super) stop_point: Row,
    /// Displacement in m of the face of the rod.
    pub(super) face: Row,
    /// Curvature in 1/m of the beam at its clamp, without what the contact force adds.
    pub(super) clamp: Row,
    /// Voltage in V; zero weights behind a short circuit.
    pub(super) voltage: Row,
    /// The storage behind a bridge.
    pub(super) storage: Option<Storage>,
    /// Voltage of the storage in V; zero weights without one.
    pub(super) storage_voltage: Row,
    /// Base acceleration in m/s².
    pub(super) base: Row,
    /// `−(Σ γ r' + Σ g q')`: base power over base acceleration, in N·s.
    pub(super) base_lever: Row,
    /// Loss factors `2ζω` in 1/s of the velocities, zero elsewhere.
    pub(super) damping: Row,
    /// Current into the circuit in A.
    pub(super) current: Row,
    /// `1/R` in 1/Ω; 0 also behind a short circuit, where there is no voltage.
    pub(super) conductance: f64,
    /// Whether the voltage acts on the beam.
    pub(super) two_way: bool,
    /// `Σ φ² + Σ ψ²` in 1/kg: acceleration of the gap over the force.
    pub(super) mobility: f64,
}

impl System {
    /// The system of a scene; `base` gives the sines of the base acceleration.
    pub(super) fn new(model: &BumpStop, load: Load, base: &LocalBase) -> Self {
        let modes = BumpStopModes::new(&model.parameters, model.stop.as_ref());
        let storage = Storage::of(load);
        let has_power = storage.is_some_and(|storage| matches!(storage.draw, Draw::Power { .. }));
        let tones = base.sines().len();
        let powers = base.powers().len();
        let layout = Layout { beam: modes.beam.len(), rod: modes.rod.len(), tones, powers, has_power };
        let size = layout.size();
        let zero = || vec![0.0; size];
        let resistance = load.resistance_ohm();
        let mut system = Self {
            modes,
            layout,
            free: DMatrix::zeros(size, size),
            push: zero(),
            gap: zero(),
            gap_rate: zero(),
            tip: zero(),
            stop_point: zero(),
            face: zero(),
            clamp: zero(),
            voltage: zero(),
            storage,
            storage_voltage: zero(),
            base: zero(),
            base_lever: zero(),
            damping: zero(),
            current: zero(),
            conductance: if resistance == 0.0 { 0.0 } else { resistance.recip() },
            two_way: model.parameters.coupling == Coupling::TwoWay,
            mobility: 0.0,
        };
        system.add_base(base);
        system.add_beam(model.parameters.damping_ratio);
        system.add_rod(model.parameters.damping_ratio);
        if resistance > 0.0 {
            system.add_voltage();
        }
        system.add_storage();
        let [_, by_base, by_voltage] = system.modes.clamp_residual;
        let by_voltage = if system.two_way { by_voltage } else { 0.0 };
        let others = system.base.iter().zip(&system.voltage);
        for (weight, (base, voltage)) in system.clamp.iter_mut().zip(others) {
            *weight -= by_base * base + by_voltage * voltage;
        }
        system.gap[layout.one()] = model.stop.as_ref().map_or(0.0, |stop| -stop.gap_m);
        system.gap_rate = Self::rate(&system.gap, &system.free);
        system.mobility = system.push.iter().map(|weight| weight * weight).sum();
        system
    }

    fn add_base(&mut self, base: &LocalBase) {
        let polynomial = self.layout.polynomial();
        self.base[polynomial.start] = 1.0;
        for place in polynomial.skip(1) {
            self.free[(place - 1, place)] = 1.0;
        }
        for (tone, [_, angular_frequency, _]) in base.sines().iter().enumerate() {
            let [sine, cosine] = self.layout.tone(tone);
            self.base[sine] = 1.0;
            self.free[(sine, cosine)] = *angular_frequency;
            self.free[(cosine, sine)] = -angular_frequency;
        }
    }

    /// A mode at these places of displacement and velocity.
    fn add_mode(
        &mut self,
        [at, rate]: [usize; 2],
        angular_frequency: f64,
        damping_ratio: f64,
        participation: f64,
    ) {
        self.free[(at, rate)] = angular_frequency;
        self.free[(rate, at)] = -angular_frequency;
        self.free[(rate, rate)] = -2.0 * damping_ratio * angular_frequency;
        self.damping[rate] = 2.0 * damping_ratio * angular_frequency;
        self.base_lever[rate] = -participation;
        for (column, weight) in self.base.iter().enumerate() {
            self.free[(rate, column)] -= participation * weight;
        }
    }

    fn add_beam(&mut self, damping_ratio: f64) {
        for (index, mode) in self.modes.beam.clone().into_iter().enumerate() {
            let [at, rate] = self.layout.beam(index);
            self.add_mode([at, rate], mode.angular_frequency, damping_ratio, mode.participation);
            self.tip[at] = mode.at_tip / mode.angular_frequency;
            self.clamp[at] = mode.clamp_curvature / mode.angular_frequency;
            self.stop_point[at] = mode.at_stop / mode.angular_frequency;
            self.gap[at] = self.stop_point[at];
            self.push[rate] = -mode.at_stop;
            self.current[rate] = mode.coupling;
        }
    }

    fn add_rod(&mut self, damping_ratio: f64) {
        for (index, mode) in self.modes.rod.clone().into_iter().enumerate() {
            let [at, rate] = self.layout.rod(index);
            self.add_mode([at, rate], mode.angular_frequency, damping_ratio, mode.participation);
            self.face[at] = mode.at_face / mode.angular_frequency;
            self.gap[at] = -self.face[at];
            self.push[rate] = mode.at_face;
        }
    }

    /// The voltage, unless the terminals are short-circuited.
    fn add_voltage(&mut self) {
        let electric = self.layout.voltage();
        let root_capacitance = self.modes.capacitance.sqrt();
        self.voltage[electric] = root_capacitance.recip();
        for [_, rate] in (0..self.layout.beam).map(|mode| self.layout.beam(mode)) {
            self.free[(electric, rate)] = self.current[rate] / root_capacitance;
            if self.two_way {
                self.free[(rate, electric)] = -self.current[rate] / root_capacitance;
            }
        }
        self.free[(electric, electric)] = -self.conductance / self.modes.capacitance;
    }

    /// The storage, and the straight line of a draw of constant power.
    fn add_storage(&mut self) {
        if let Some(storage) = &self.storage {
            let weight = if storage.is_bus() { 1.0 } else { storage.capacitance.sqrt().recip() };
            self.storage_voltage[self.layout.storage()] = weight;
        }
        if self.layout.has_power {
            let [draw, slope] = self.layout.draw();
            self.free[(draw, slope)] = 1.0;
        }
    }

    /// The vector at the start, without the generators.
    pub(super) fn start(&self, from: &BumpStopStart) -> Vec<f64> {
        let Self { layout, modes, .. } = self;
        let mut vector = vec![0.0; layout.size()];
        for (index, mode) in modes.beam.iter().enumerate() {
            let [at, rate] = layout.beam(index);
            vector[at] = mode.angular_frequency * from.modal_displacement[index];
            vector[rate] = from.modal_velocity[index];
        }
        for (index, mode) in modes.rod.iter().enumerate() {
            let [at, rate] = layout.rod(index);
            vector[at] = mode.angular_frequency * from.rod_modal_displacement[index];
            vector[rate] = from.rod_modal_velocity[index];
        }
        let electric = layout.voltage();
        if self.voltage[electric] != 0.0 {
            vector[electric] = from.voltage_v / self.voltage[electric];
        }
        vector[layout.one()] = 1.0;
        if let Some(storage) = &self.storage {
            vector[electric] = from.voltage_v / self.voltage[electric];
            let place = layout.storage();
            vector[place] = storage.initial / self.storage_voltage[place];
        }
        vector
    }

    /// Shares the charge of a start voltage above the threshold of the bridge with the storage; gives the energies.
    pub(super) fn share_at_start(&self, from: &BumpStopStart, vector: &mut [f64]) -> Integrals {
        let mut shared = Integrals::default();
        let Some(storage) = &self.storage else { return shared };
        let excess = from.voltage_v.abs() - storage.initial - storage.drop;
        if excess <= 0.0 {
            return shared;
        }
        let capacitance = self.modes.capacitance;
        let charge = excess * capacitance / (1.0 + capacitance / storage.capacitance);
        let rise = charge / storage.capacitance;
        shared[integral::INTO_LOAD] = charge * (storage.initial + 0.5 * rise);
        shared[integral::DIODES] = charge * (storage.drop + 0.5 * excess);
        let voltage = (storage.initial + storage.drop + rise).copysign(from.voltage_v);
        let (electric, place) = (self.layout.voltage(), self.layout.storage());
        vector[electric] = voltage / self.voltage[electric];
        vector[place] = (storage.initial + rise) / self.storage_voltage[place];
        shared
    }

    /// Whether the draw is connected by the voltage of the storage.
    pub(super) fn is_connected_at_start(&self, vector: &[f64]) -> bool {
        self.storage.is_some_and(|storage| storage.starts_connected(value(&self.storage_voltage, vector)))
    }

    /// Sets the generator of a constant power in W to the tangent to `P/V_s`; `storage_rate` is the row of the
    /// rate of the storage voltage.
    pub(super) fn set_draw(&self, vector: &mut [f64], power: f64, storage_rate: &[f64]) {
        let [draw, slope] = self.layout.draw();
        let voltage = value(&self.storage_voltage, vector);
        vector[draw] = power / voltage;
        vector[slope] = 0.0;
        vector[slope] = -power / (voltage * voltage) * value(storage_rate, vector);
    }

    /// Sets the generators to the base acceleration from its local origin on.
    pub(super) fn set_base(&self, vector: &mut [f64], base: &LocalBase) {
        let mut factorial = 1.0;
        for (n, (place, power)) in self.layout.polynomial().zip(base.powers()).enumerate() {
            factorial *= n.max(1) as f64;
            vector[place] = factorial * power;
        }
        for (tone, [amplitude, _, phase]) in base.sines().iter().enumerate() {
            let [sine, cosine] = self.layout.tone(tone);
            vector[sine] = amplitude * phase.sin();
            vector[cosine] = amplitude * phase.cos();
        }
    }

    /// Row of the rate of a linear quantity in a system of this matrix.
    pub(super) fn rate(row: &[f64], matrix: &DMatrix<f64>) -> Row {
        matrix.column_iter().map(|column| value(row, column.as_slice())).collect()
    }

    /// The closed contact: the rows of its force in N and of its release, and its stiffness in N/m.
    ///
    /// The force is the penetration over the static compliance of the modes left out (MacNeal's residual
    /// flexibility) and of the contact in series. In a rigid contact, of stiffness 0 here, the force keeps the gap from accelerating.
    pub(super) fn closed_contact(&self, model: &BumpStop) -> ([Row; 2], f64) {
        let negated = |row: &Row| row.iter().map(|weight| -weight).collect();
        let Some(stop) = &model.stop else {
            // The guard of the release is zero and never rises.
            return ([vec![0.0; self.layout.size()], vec![0.0; self.layout.size()]], 0.0);
        };
        match stop.contact {
            Contact::ResidualFlexibility => {
                let compliance =
                    self.modes.beam_residual + self.modes.rod_residual + stop.contact_compliance_m_per_n;
                let force = self.gap.iter().map(|weight| weight / compliance).collect();
                ([force, negated(&self.gap)], compliance.recip())
            }
            Contact::Restitution | Contact::DisplacementConstraint => {
                let acceleration = Self::rate(&self.gap_rate, &self.free);
                let force: Row = acceleration.iter().map(|weight| weight / self.mobility).collect();
                let release = negated(&force);
                ([force, release], 0.0)
            }
        }
    }

    /// Energies in J of beam and rod, of the charge, and of the storage.
    pub(super) fn energies(&self, vector: &[f64]) -> [f64; 3] {
        let electric = self.layout.voltage();
        let half_squares = |part: &[f64]| 0.5 * part.iter().map(|entry| entry * entry).sum::<f64>();
        let storage = |storage: Storage| storage.energy(value(&self.storage_voltage, vector));
        [
            half_squares(&vector[..electric]),
            half_squares(&vector[electric..=electric]),
            self.storage.map_or(0.0, storage),
        ]
    }

    /// Highest frequency in Hz of the modes, free or closed on a spring of `stiffness` N/m.
    ///
    /// The closed one is the last root of `1 = Σ k b² / (λ − ω²)` over all modes, `b` their shapes at the
    /// contact; it lies within `k Σ b²` above the highest free one.
    pub(super) fn highest_frequency(&self, stiffness: f64) -> f64 {
        let beam = self.modes.beam.iter().map(|mode| (mode.angular_frequency, mode.at_stop));
        let rod = self.modes.rod.iter().map(|mode| (mode.angular_frequency, mode.at_face));
        let modes: Vec<(f64, f64)> = beam.chain(rod).collect();
        let highest = modes.iter().fold(0.0, |highest, (frequency, _)| f64::max(highest, *frequency));
        let (mut below, mut above) = (highest * highest, highest * highest + stiffness * self.mobility);
        for _ in 0..60 {
            let middle = 0.5 * (below + above);
            let sum: f64 = modes
                .iter()
                .map(|(frequency, shape)| stiffness * shape * shape / (middle - frequency * frequency))
                .sum();
            *(if sum > 1.0 { &mut below } else { &mut above }) = middle;
        }
        above.sqrt() / std::f64::consts::TAU
    }
}

//! Computes the regular motion of a triboelectric harvester behind a bridge into a storage of constant voltage.
//!
//! The position is approximated by `x = x0 + X cos θ`, `θ = Ω t`. While the bridge blocks the charge is constant, and at a
//! fixed position the voltage falls with the charge, so the charge is kept between the two charges at which the voltage is
//! `±U`, `U = V_s + 2 V_D`:
//!
//! ```text
//! Q ← min(max(Q, Q(x, U)), Q(x, −U))               V(x, Q(x, ±U)) = ±U
//! ```
//!
//! This play has no rate: along a motion between two turning points the charge that passes in a period follows from
//! the extremes of the voltage alone, without an approximation. In contact-separation it is
//!
//! ```text
//! ΔQ = Q(x0 + X, U) − Q(x0 − X, −U)
//! ```
//!
//! once up and once down in each period, in sliding twice: the rectangle in the plane of charge and voltage. The storage
//! takes `V_s` times all charge that passes. Capacitance in parallel to the harvester is part of `V(x, Q)`.
//!
//! The mean `F_0` and the first harmonic `F_c cos θ + F_s sin θ` of all forces per mass along the motion (spring, damping,
//! friction, field) balance it under the base acceleration `A`, of which the part `κ` acts on the position:
//!
//! ```text
//! F_0 = 0                   κ² A² = (Ω² X + F_c)² + F_s²
//! ```
//!
//! The first determines `x0`, the second, explicit in `A`, the amplitude. The slider's friction changes its sign at each
//! turning point: the second equation is there Den Hartog's, with the constant friction of equal work. The higher
//! harmonics of the motion are otherwise neglected; [`Reason::HigherHarmonics`] bounds them. Derived here.

use super::{ElectricalPort, PortVoltage, Rectified};
use crate::hybrid::Automaton;
use crate::integrate::System;
use crate::part::storage::StorageElement;
use crate::scalar::{Complex, Scalar};
use crate::scene::closed_form::{ClosedForm, Reason, Validity, ratio};

/// Points of a period: a multiple of four, so that both turning points and the centre are among them. With kinks between
/// the points the harmonics are accurate to the inverse square of their number.
const POINTS: usize = 96;
/// `cos(2π/96)` and `sin(2π/96)`.
const TURN: [f64; 2] = [0.997_858_923_238_603_5, 0.065_403_129_230_143_07];
/// Amplitudes that are tried, from small ones upwards, before the first one that is large enough is refined.
const TRIED: u32 = 24;
/// Halvings of the interval of the amplitude.
const HALVINGS: u32 = 30;
/// Most iterations for the mean position.
const MOST_CENTRINGS: u32 = 8;
/// Residual of the mean force relative to that of the spring at the amplitude.
const CENTRED: f64 = 1e-6;
/// The same, up to which the motion is balanced: the higher harmonics that are left out are larger.
const BALANCED: f64 = 1e-3;
/// Least amplitude that is tried, as a part of the largest.
const LEAST: f64 = 1e-3;
/// Largest valid second and third harmonic of the motion together, as a part of the first.
const HARMONIC: f64 = 0.03;

/// The regular motion of a harvester at open terminals, for its closed form behind a bridge.
///
/// It cannot be implemented outside this crate.
pub trait RegularMotion<S: Scalar>: ElectricalPort<S> {
    /// What a motion beyond [`RegularMotion::room`] does.
    const BEYOND: Reason;
    /// Whether a motion with impacts coexists above resonance.
    const COEXISTS: bool;

    /// Position in m and charge in charge units at rest, without voltage.
    fn rest(&self) -> [S; 2];

    /// Largest amplitude in m of a regular motion about a mean position in m.
    fn room(&self, mean: S) -> S;

    /// The mode of a motion through a position, towards larger positions if `forward`.
    fn moving(&self, forward: bool, position: S) -> Self::Mode;

    /// The load on the position at rest, and the largest load at which friction holds it, both per mass in m/s², at a
    /// position, a charge and a base acceleration.
    fn grip(&self, position: S, charge: S, acceleration: S) -> [S; 2];

    /// What a motion of an amplitude in m needs, from the first harmonic `[F_c, F_s]` of its forces per mass in m/s².
    fn needs(&self, amplitude: S, angular_frequency: S, first: [S; 2]) -> Needs<S>;
}

/// What a motion needs of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Needs<S> {
    /// Base acceleration times its part in the motion, in m/s².
    pub drive: S,
    /// Whether the position moves with the base, as above resonance.
    pub is_above: bool,
    /// Load on the position at its turning point per mass, in m/s², that must exceed static friction.
    pub pull: S,
}

/// A motion `x0 + X cos θ`.
#[derive(Clone, Copy)]
struct Motion<S> {
    mean: S,
    amplitude: S,
}

/// What a period of a motion does.
struct Period<S> {
    /// Mean force per mass in m/s².
    mean: S,
    /// `F_c` and `F_s` of the first three harmonics, as `F_c + j F_s`.
    harmonics: [Complex<S>; 3],
    /// Charge that passes, without regard to its sign, in charge units.
    passed: S,
    /// Mean of the squared voltage in V².
    square: S,
    /// Charge at `θ = 0`, in charge units.
    charge_at_turn: S,
}

/// The drive of the base: its acceleration times its part in the motion, in m/s², and its angular frequency.
#[derive(Clone, Copy)]
struct Drive<S> {
    acceleration: S,
    omega: S,
    /// Angular frequency of the harvester in rad/s.
    natural: S,
}

impl<S: Scalar> Drive<S> {
    /// The mean force that is left at the mean position, as a part of the amplitude by which it would move it.
    fn unbalanced(&self, motion: &Motion<S>, period: &Period<S>) -> S {
        period.mean.abs() / (self.natural * self.natural * motion.amplitude).max(S::TINY)
    }
}

impl<S: Scalar, H: RegularMotion<S>, R: StorageElement<S>> Rectified<S, H, R> {
    /// Mean power into a storage held at `storage_voltage` in V, under the base acceleration `amplitude · sin(2π ·
    /// frequency · t)` in m/s² and Hz, of the motion without impacts, or without stick and on the active patch. The
    /// mean current into the storage is this power over its voltage.
    ///
    /// Approximate: one harmonic of the motion. Exactly 0 if static friction holds the slider from the start, or if the
    /// voltage never reaches that of the storage and the diodes. 50 to 300 periods of 192 evaluations of the forces: for
    /// a host or a design, not for each sample of a node.
    #[must_use]
    pub fn closed_form_at(&self, amplitude: S, frequency: S, storage_voltage: S) -> ClosedForm<S> {
        let threshold = self.bridge.threshold(storage_voltage);
        let [at, charge] = self.harvester.rest();
        let drive = self.drive(amplitude.abs(), frequency);
        let [pull, hold] = self.harvester.grip(at, charge, amplitude.abs());
        let held = ratio(pull.abs(), hold);
        if hold > S::ZERO && held <= S::ONE || amplitude == S::ZERO {
            return ClosedForm {
                mean_power: S::ZERO,
                rms_voltage: S::ZERO,
                amplitude: S::ZERO,
                validity: Validity::Holds { margin: if hold > S::ZERO { held } else { S::ZERO } },
            };
        }
        let (motion, period) = self.motion(&drive, threshold);
        let needs = self.needs(&motion, &period, &drive);
        let reach = motion.amplitude / self.harvester.room(motion.mean).max(S::TINY);
        let in_transient = H::COEXISTS && needs.is_above;
        let [_, second, third] = period.harmonics;
        let higher = self.response(&drive, 2, second) + self.response(&drive, 3, third);
        let [_, hold] = self.harvester.grip(motion.mean + motion.amplitude, period.charge_at_turn, S::ZERO);
        let charge_rate = self.harvester.coulombs() * period.passed * frequency;
        ClosedForm {
            mean_power: storage_voltage * charge_rate,
            rms_voltage: period.square.sqrt(),
            amplitude: motion.amplitude,
            validity: Validity::of([
                (Reason::NotBalanced, drive.unbalanced(&motion, &period) * S::from_f64(1.0 / BALANCED)),
                (H::BEYOND, reach),
                (Reason::ImpactsInTransient, if in_transient { reach + reach } else { S::ZERO }),
                (Reason::Sticks, ratio(hold, needs.pull)),
                (Reason::HigherHarmonics, higher / (S::from_f64(HARMONIC) * motion.amplitude).max(S::TINY)),
            ]),
        }
    }

    fn drive(&self, amplitude: S, frequency: S) -> Drive<S> {
        let [at, charge] = self.harvester.rest();
        let mode = self.harvester.moving(true, at);
        let state = [at, S::ZERO, charge];
        let [still, shaken] = [S::ZERO, S::ONE].map(|acceleration| {
            let [_, rate, _] = System::<S, 3, 0>::flow(&self.harvester.flow(mode), &state, acceleration);
            rate
        });
        let coupling = shaken - still;
        Drive {
            acceleration: (coupling * amplitude).abs(),
            omega: frequency * S::from_f64(core::f64::consts::TAU),
            natural: Automaton::<S, 3, 0>::error_scale(&self.harvester).angular_frequency,
        }
    }

    /// The amplitude in m of harmonic number `n` of the motion under a force per mass.
    fn response(&self, drive: &Drive<S>, n: u32, force: Complex<S>) -> S {
        let omega = S::from_u32(n) * drive.omega;
        let stiffness = (drive.natural - omega) * (drive.natural + omega);
        force.magnitude() / stiffness.abs().max(S::TINY)
    }

    /// The motion of the least amplitude that needs at least the drive, or one beyond the room, and its period.
    fn motion(&self, drive: &Drive<S>, threshold: S) -> (Motion<S>, Period<S>) {
        let [rest, _] = self.harvester.rest();
        let room = self.harvester.room(rest);
        let step = room / S::from_u32(TRIED);
        let mut low = S::ZERO;
        let (mut motion, mut period) = self.centred(rest, S::from_f64(LEAST) * room, drive, threshold);
        let falls_short = |motion: &Motion<S>, period: &Period<S>| {
            !(self.needs(motion, period, drive).drive >= drive.acceleration)
        };
        for number in 1..=TRIED {
            if !falls_short(&motion, &period) {
                break;
            }
            low = motion.amplitude;
            (motion, period) = self.centred(motion.mean, step * S::from_u32(number), drive, threshold);
        }
        if falls_short(&motion, &period) {
            // The largest motion needs less: beyond it.
            motion.amplitude *= S::from_f64(1.01);
            return (motion, period);
        }
        let mut high = motion.amplitude;
        for _ in 0..HALVINGS {
            let middle = S::from_f64(0.5) * (low + high);
            (motion, period) = self.centred(motion.mean, middle, drive, threshold);
            if self.needs(&motion, &period, drive).drive >= drive.acceleration {
                high = middle;
            } else {
                low = middle;
            }
        }
        (motion, period)
    }

    fn needs(&self, motion: &Motion<S>, period: &Period<S>, drive: &Drive<S>) -> Needs<S> {
        let [first, ..] = period.harmonics;
        self.harvester.needs(motion.amplitude, drive.omega, [first.re, first.im])
    }

    /// The motion of an amplitude in m with its mean position, sought from `mean`, and its period.
    fn centred(&self, mean: S, amplitude: S, drive: &Drive<S>, threshold: S) -> (Motion<S>, Period<S>) {
        let mut motion = Motion { mean, amplitude };
        let mut period = self.period(&motion, drive, threshold);
        let stiffness = drive.natural * drive.natural;
        for _ in 0..MOST_CENTRINGS {
            if drive.unbalanced(&motion, &period) <= S::from_f64(CENTRED) {
                break;
            }
            motion.mean += period.mean / stiffness;
            period = self.period(&motion, drive, threshold);
        }
        (motion, period)
    }

    /// The forces and the charge along a period, after a first one in which the play of the charge becomes periodic.
    fn period(&self, motion: &Motion<S>, drive: &Drive<S>, threshold: S) -> Period<S> {
        let [_, mut charge] = self.harvester.rest();
        let [turn_cosine, turn_sine] = TURN.map(S::from_f64);
        let turn = Complex::new(turn_cosine, turn_sine);
        let mut angle = Complex::new(S::ONE, S::ZERO);
        for _ in 0..POINTS {
            charge =
                self.played(charge, motion.mean + motion.amplitude * angle.re, angle.im < S::ZERO, threshold);
            angle = angle * turn;
        }
        let mut period = Period::NONE;
        let part = S::ONE / S::from_u32(POINTS as u32);
        angle = Complex::new(S::ONE, S::ZERO);
        for point in 0..POINTS {
            let position = motion.mean + motion.amplitude * angle.re;
            let forward = angle.im < S::ZERO;
            let before = charge;
            charge = self.played(charge, position, forward, threshold);
            period.passed += (charge - before).abs();
            let velocity = -drive.omega * motion.amplitude * angle.im;
            let turns = point == 0 || point == POINTS / 2;
            let force = if turns {
                // Friction changes its sign at a turning point.
                let [one, other] =
                    [true, false].map(|forward| self.force(forward, position, velocity, charge));
                S::from_f64(0.5) * (one + other)
            } else {
                self.force(forward, position, velocity, charge)
            };
            if point == 0 {
                period.charge_at_turn = charge;
            }
            let voltage = self.terminal(position, forward, charge).value;
            period.square += part * voltage * voltage;
            period.mean += part * force;
            let mut multiple = angle;
            for harmonic in &mut period.harmonics {
                *harmonic = *harmonic + multiple.scaled((part + part) * force);
                multiple = multiple * angle;
            }
            angle = angle * turn;
        }
        period
    }

    fn terminal(&self, position: S, forward: bool, charge: S) -> PortVoltage<S> {
        self.harvester.port_voltage(self.harvester.moving(forward, position), position, charge)
    }

    /// The charge after a move to a position in m: the bridge keeps the voltage within `±threshold`.
    fn played(&self, charge: S, position: S, forward: bool, threshold: S) -> S {
        let terminal = self.terminal(position, forward, charge);
        let excess = if terminal.value > threshold {
            terminal.value - threshold
        } else if terminal.value < -threshold {
            terminal.value + threshold
        } else {
            S::ZERO
        };
        charge - excess / terminal.by_charge
    }

    /// All forces per mass but that of the base, in m/s².
    fn force(&self, forward: bool, position: S, velocity: S, charge: S) -> S {
        let mode = self.harvester.moving(forward, position);
        let state = [position, velocity, charge];
        let [_, rate, _] = System::<S, 3, 0>::flow(&self.harvester.flow(mode), &state, S::ZERO);
        rate
    }
}

impl<S: Scalar> Period<S> {
    const NONE: Self = Self {
        mean: S::ZERO,
        harmonics: [Complex::ZERO; 3],
        passed: S::ZERO,
        square: S::ZERO,
        charge_at_turn: S::ZERO,
    };
}

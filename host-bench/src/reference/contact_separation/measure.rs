//! Meters and energy ledger of a reference run.

use diffsol::error::DiffsolError;

use super::flight::Piece;
use super::hold::Hold;
use super::physics::{Motion, Physics};
use crate::outcome::{
    CONTACT_SEPARATION_COLUMNS, ContactSeparationOutcome, Recording, StoreOutcome, with_store,
};
use crate::reference::base::LocalBase;
use crate::reference::integrals::Integrals;
use crate::reference::recorder::Recorder;
use crate::reference::root::far_side;
use crate::scene_file::{ForceLaw, Scene};

/// Columns of a recording with a store.
const WITH_STORE: [&str; 8] = with_store(CONTACT_SEPARATION_COLUMNS);

/// Everything that is summed or compared along a run.
#[derive(Debug)]
pub(super) struct Meters<'a> {
    physics: &'a Physics,
    recorder: Option<Recorder>,
    /// Whole run.
    total: Integrals,
    /// Measuring window.
    window: Integrals,
    base_work_magnitude: f64,
    impact_loss: f64,
    start_energy: [f64; 2],
    peak_stored_energy: f64,
    in_window: bool,
    highest_gap: f64,
    lowest_gap: f64,
    highest_voltage: f64,
    impacts: u64,
    highest_impact_speed: f64,
    first_impact: Option<f64>,
    stuck: f64,
}

impl<'a> Meters<'a> {
    pub(super) fn new(physics: &'a Physics, start: &Motion, record_every: Option<f64>) -> Self {
        let start_energy = [physics.mechanical_energy(start), physics.electrical_energy(start)];
        Self {
            physics,
            recorder: record_every.map(Recorder::new),
            total: Integrals::default(),
            window: Integrals::default(),
            base_work_magnitude: 0.0,
            impact_loss: 0.0,
            start_energy,
            peak_stored_energy: start_energy[0] + start_energy[1],
            in_window: false,
            highest_gap: f64::NEG_INFINITY,
            lowest_gap: f64::INFINITY,
            highest_voltage: 0.0,
            impacts: 0,
            highest_impact_speed: f64::NEG_INFINITY,
            first_impact: None,
            stuck: 0.0,
        }
    }

    /// Whether what follows lies in the measuring window.
    pub(super) fn set_in_window(&mut self, in_window: bool) {
        self.in_window = in_window;
    }

    /// Looks at one step of a flight that began at `start` seconds.
    pub(super) fn watch(
        &mut self,
        start: f64,
        base: &LocalBase,
        piece: &Piece<'_>,
    ) -> Result<(), DiffsolError> {
        let ends = [(piece.from, (piece.motion)(piece.from)?), (piece.to, (piece.motion)(piece.to)?)];
        self.look_at_stored(&ends[1].1);
        // The base's power changes sign twice a period; what one step around that loses is far below
        // what the denominator of a residual asks for.
        let before = (piece.integrals)(piece.from)?.base_work;
        self.base_work_magnitude += ((piece.integrals)(piece.to)?.base_work - before).abs();
        if self.in_window {
            for (_, motion) in &ends {
                self.compare(motion);
            }
            for turn in piece.turns {
                self.compare(&(piece.motion)(*turn)?);
            }
            let slope = |t: f64| -> Result<f64, DiffsolError> {
                Ok(self.physics.voltage_slope(&(piece.motion)(t)?, base.at(t)))
            };
            let at_ends = ends.map(|(t, motion)| self.physics.voltage_slope(&motion, base.at(t)));
            if (at_ends[0] > 0.0) != (at_ends[1] > 0.0) {
                let peak = far_side(slope, piece.from, piece.to)?;
                self.compare(&(piece.motion)(peak)?);
            }
        }
        self.record_until(start + piece.to, |time| {
            let local = (time - start).clamp(piece.from, piece.to);
            let motion = (piece.motion)(local)?;
            Ok((motion, self.physics.voltage(&motion), base.at(local), 0.0))
        })
    }

    /// Looks at the first `elapsed` seconds of a hold that began at `start` seconds.
    pub(super) fn watch_hold(
        &mut self,
        start: f64,
        elapsed: f64,
        hold: &Hold<'_>,
    ) -> Result<(), DiffsolError> {
        self.add(&hold.integrals(elapsed));
        self.look_at_stored(&hold.motion(elapsed));
        if self.in_window {
            self.stuck += elapsed;
            self.highest_gap = self.highest_gap.max(0.0);
            self.lowest_gap = self.lowest_gap.min(0.0);
            // The voltage only falls.
            self.highest_voltage = self.highest_voltage.max(hold.load_voltage(0.0).abs());
        }
        self.record_until(start + elapsed, |time| {
            let local = (time - start).clamp(0.0, elapsed);
            Ok((hold.motion(local), hold.load_voltage(local), hold.base.at(local), 1.0))
        })
    }

    /// Adds the integrals over a stretch.
    pub(super) fn add(&mut self, stretch: &Integrals) {
        self.total.add(stretch);
        if self.in_window {
            self.window.add(stretch);
        }
    }

    /// An impact at `time` seconds that takes `loss` joules from the mass.
    pub(super) fn impact(&mut self, time: f64, speed: f64, loss: f64) {
        self.impact_loss += loss;
        self.first_impact.get_or_insert(time);
        if self.in_window {
            self.impacts += 1;
            self.highest_impact_speed = self.highest_impact_speed.max(speed);
        }
    }

    fn compare(&mut self, motion: &Motion) {
        // An impact is taken on its far side, by one rounding; the gap there is zero.
        let gap = motion.gap.max(0.0);
        self.highest_gap = self.highest_gap.max(gap);
        self.lowest_gap = self.lowest_gap.min(gap);
        self.highest_voltage = self.highest_voltage.max(self.physics.voltage(motion).abs());
    }

    fn record_until(
        &mut self,
        time: f64,
        at: impl Fn(f64) -> Result<(Motion, f64, f64, f64), DiffsolError>,
    ) -> Result<(), DiffsolError> {
        let Self { recorder: Some(recorder), physics, .. } = self else { return Ok(()) };
        recorder.until(time, |due| {
            let (motion, voltage, base, stuck) = at(due)?;
            let charge = physics.charge(&motion);
            let mut row = vec![due, motion.gap, motion.velocity, charge, voltage, base, stuck];
            row.extend(physics.store.map(|store| store.voltage(&motion.bridge)));
            Ok(row)
        })
    }

    /// Compares the energy stored with the largest so far.
    fn look_at_stored(&mut self, motion: &Motion) {
        let harvester = self.physics.mechanical_energy(motion) + self.physics.electrical_energy(motion);
        // Of a store that is not empty at the start, what it has gained or given.
        let moved = self.store_gain(motion).abs();
        self.peak_stored_energy = self.peak_stored_energy.max(harvester + moved);
    }

    /// What a store has gained since the start, in J.
    fn store_gain(&self, motion: &Motion) -> f64 {
        self.physics.store.map_or(0.0, |store| store.gained(&motion.bridge))
    }

    /// What is left over in the ledger of a store in J: what it has gained against what has entered and left.
    fn store_remainder(&self, end: &Motion) -> f64 {
        let is_store = self.physics.store.is_some_and(|store| store.capacitance.is_finite());
        if is_store { self.store_gain(end) - self.total.stored() } else { 0.0 }
    }

    /// Energy in J into the load: a resistor, or a store or bus behind its diodes.
    fn delivered(&self, integrals: &Integrals) -> f64 {
        match self.physics.store {
            None => self.physics.load_power(integrals.voltage_squared),
            Some(_) => integrals.into_store,
        }
    }

    /// What the run has to say about a store.
    fn store_outcome(&self, end: &Motion) -> Option<StoreOutcome> {
        let Integrals { diode_loss, leaked, drawn, .. } = self.total;
        let store = self.physics.store?;
        Some(store.outcome(store.voltage(&end.bridge), [diode_loss, leaked, drawn]))
    }

    /// What is left over in the ledger, over the larger of `∫ |base power| dt` and the peak stored energy.
    ///
    /// Mechanical ledger: energy of mass and spring against the work of the base, the damper, the
    /// electrostatic force and the impacts. Electrical ledger: `d/dt E_el = F_field v − V²/R`, true for
    /// any motion; behind a bridge, less what enters diodes and store. Under the force law that conserves energy
    /// the two close together; under the other one each closes by itself, and the larger remainder counts, that
    /// of a store's own ledger included.
    fn energy_residual(&self, end: &Motion, force_law: ForceLaw) -> Option<f64> {
        let total = &self.total;
        let mechanical = self.physics.mechanical_energy(end)
            - self.start_energy[0]
            - (total.base_work - total.damper_loss - total.surface_work - self.impact_loss);
        let electrical = self.physics.electrical_energy(end)
            - self.start_energy[1]
            - (total.field_work - self.delivered(total) - total.diode_loss);
        let left = match force_law {
            ForceLaw::GapField => (mechanical + electrical).abs(),
            ForceLaw::TransferredCharge => mechanical.abs().max(electrical.abs()),
        };
        let left = left.max(self.store_remainder(end).abs());
        let scale = self.base_work_magnitude.max(self.peak_stored_energy);
        (scale > 0.0).then(|| left / scale)
    }

    /// Closes the books at the motion at the end of the run.
    pub(super) fn close(self, scene: &Scene, force_law: ForceLaw, end: &Motion) -> Totals {
        let window = scene.run.window_s();
        let delivered = self.delivered(&self.window);
        let store = self.store_outcome(end);
        let periods = scene.excitation.single_frequency().map(|frequency| frequency * window);
        Totals {
            energy_residual: self.energy_residual(end, force_law),
            delivered_energy: delivered,
            mean_power: delivered / window,
            rms_voltage: (self.window.voltage_squared / window).sqrt(),
            mean_voltage: self.window.voltage / window,
            peak_voltage: self.highest_voltage,
            particular: ContactSeparationOutcome {
                peak_gap_m: Some(self.highest_gap),
                min_gap_m: Some(self.lowest_gap),
                impacts: self.impacts,
                impacts_per_period: periods.map(|periods| self.impacts as f64 / periods),
                max_impact_speed_m_per_s: (self.impacts > 0).then_some(self.highest_impact_speed),
                first_impact_s: self.first_impact,
                stuck_fraction: Some(self.stuck / window),
            },
            store,
            recording: self.recorder.map(|recorder| Recording {
                columns: if store.is_some() { &WITH_STORE } else { &CONTACT_SEPARATION_COLUMNS },
                rows: recorder.rows,
            }),
        }
    }
}

/// The sums at the end of a run, in SI units.
#[derive(Debug)]
pub(super) struct Totals {
    pub(super) energy_residual: Option<f64>,
    pub(super) delivered_energy: f64,
    pub(super) mean_power: f64,
    pub(super) rms_voltage: f64,
    pub(super) mean_voltage: f64,
    pub(super) peak_voltage: f64,
    pub(super) particular: ContactSeparationOutcome,
    pub(super) store: Option<StoreOutcome>,
    pub(super) recording: Option<Recording>,
}

//! Integrals over time that the integrator carries beside a motion.

/// Integrals over a stretch of motion; those behind a bridge stay zero without one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Integrals {
    /// `∫ V² dt` in V² s.
    pub(super) voltage_squared: f64,
    /// `∫ V dt` in V s.
    pub(super) voltage: f64,
    /// Work of the base on the motion in J.
    pub(super) base_work: f64,
    /// Loss in the damper in J.
    pub(super) damper_loss: f64,
    /// What else the motion gives away in J: work against the electrostatic force between plates, loss in the
    /// friction between patches.
    pub(super) surface_work: f64,
    /// Work in J of the electrostatic force that conserves energy, whether it acts or not.
    pub(super) field_work: f64,
    /// Energy in J that enters a store or bus.
    pub(super) into_store: f64,
    /// Loss in J in the diodes before it.
    pub(super) diode_loss: f64,
    /// Energy in J that leaks from a store.
    pub(super) leaked: f64,
    /// Energy in J that a node draws from it.
    pub(super) drawn: f64,
}

/// Number of integrals without a bridge: the first of them.
pub(super) const WITHOUT_BRIDGE: usize = 6;

/// Number of integrals.
pub(super) const ALL: usize = 10;

impl Integrals {
    /// In the order of the fields.
    pub(super) fn to_array(self) -> [f64; ALL] {
        [
            self.voltage_squared,
            self.voltage,
            self.base_work,
            self.damper_loss,
            self.surface_work,
            self.field_work,
            self.into_store,
            self.diode_loss,
            self.leaked,
            self.drawn,
        ]
    }

    /// From the first of them, the others zero.
    pub(super) fn of(values: &[f64]) -> Self {
        let at = |index: usize| values.get(index).copied().unwrap_or(0.0);
        Self {
            voltage_squared: at(0),
            voltage: at(1),
            base_work: at(2),
            damper_loss: at(3),
            surface_work: at(4),
            field_work: at(5),
            into_store: at(6),
            diode_loss: at(7),
            leaked: at(8),
            drawn: at(9),
        }
    }

    /// Adds those of a later stretch.
    pub(super) fn add(&mut self, later: &Self) {
        self.add_scaled(1.0, later);
    }

    /// Adds others times a weight.
    pub(super) fn add_scaled(&mut self, weight: f64, others: &Self) {
        let mut sums = self.to_array();
        for (sum, other) in sums.iter_mut().zip(others.to_array()) {
            *sum += weight * other;
        }
        *self = Self::of(&sums);
    }

    /// What a store has gained by them, in J.
    pub(super) fn stored(&self) -> f64 {
        self.into_store - self.leaked - self.drawn
    }
}

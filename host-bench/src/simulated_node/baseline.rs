//! Baselines of a node: what a firmware engineer writes without a library. Their parameters are those of a node by the voltage.

use harvester_scene::market::Reservoir;
use model_core::node::{IncomeOfTime, Task, VoltageParameters, Wake};

use super::Strategy;
use super::settings::Settings;

/// Seconds from one reading to the next of the difference of two readings.
const EVERY: u32 = 300;
/// Seconds of a slot, slots of a day, and weight of the days before.
const SLOT: u32 = 1800;
const SLOTS: usize = 48;
const WEIGHT: f64 = 0.5;

/// How a baseline knows its income, and when it acts.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rule {
    /// The difference of two readings, each five minutes; an action runs when it leaves the reserve.
    Difference,
    /// A. Kansal, J. Hsu, S. Zahedi, M. B. Srivastava, *Power management in energy harvesting sensor networks*, ACM Trans.
    /// Embed. Comput. Syst. 6 (2007): the income of a slot of the day is an exponentially weighted mean of that slot on earlier
    /// days, here of the difference of two readings. The next slot spends what it expects and what is stored above the reserve.
    /// A slot without a day before expects the slot before. Of each slot its mean and the mean square of its errors.
    Ewma(Vec<Option<[f64; 2]>>),
    /// An action each so many seconds, without a reading.
    Fixed(u32),
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Baseline {
    parameters: VoltageParameters<1>,
    reservoir: Reservoir,
    rule: Rule,
    second: u32,
    /// Second of the last reading, of the last action, and of the beginning of the hour.
    read: u32,
    ran: u32,
    began: u32,
    /// Stored energy by the last reading, at the beginning of the hour or slot, and spent since, in J.
    energy: f64,
    first: f64,
    spent: f64,
    /// Estimated over the slots of the hour, with its variance; seconds between actions in the slot.
    estimated: [f64; 2],
    period: u32,
    readings: u32,
    hour: Option<IncomeOfTime>,
}

impl Rule {
    /// Slots without a day before.
    pub(super) fn ewma() -> Self {
        Self::Ewma(vec![None; SLOTS])
    }
}

impl Baseline {
    pub(super) fn new(settings: &Settings, rule: Rule) -> Self {
        let period = if let Rule::Fixed(period) = rule { period } else { u32::MAX };
        Self {
            parameters: settings.parameters(),
            reservoir: settings.reservoir(1.0),
            rule,
            second: 0,
            read: 0,
            ran: 0,
            began: 0,
            energy: 0.0,
            first: 0.0,
            spent: 0.0,
            estimated: [0.0; 2],
            period,
            readings: 0,
            hour: None,
        }
    }

    /// The energy in J of a voltage in V.
    fn at(&self, voltage: f64) -> f64 {
        self.reservoir.energy_j(voltage)
    }

    fn least(&self) -> f64 {
        self.at(self.parameters.storage.lock_out_voltage.into()) + f64::from(self.parameters.reserve)
    }

    /// The income since the start, with what was drawn and its variance.
    fn income(&self, begin: u32) -> [f64; 2] {
        let VoltageParameters { converter, standing_power, tolerances, .. } = &self.parameters;
        let drawn = f64::from(*standing_power) * f64::from(self.second - begin);
        let leaking = self.reservoir.leaking(self.energy);
        let leaked = 0.5 * leaking * (self.energy + self.first) * f64::from(self.second - begin);
        let income = self.energy - self.first + drawn + self.spent + leaked;
        // Two readings with noise and rounding, the standing power, the leakage, the capacitance.
        let cell = f64::from(converter.full_scale) / f64::from(1_u32 << converter.bits);
        let of_voltage = f64::from(converter.noise).powi(2) + cell * cell / 12.0;
        let slopes =
            [self.energy, self.first].map(|energy| self.reservoir.slope(self.reservoir.voltage_v(energy)));
        let of_readings = of_voltage * slopes.iter().map(|slope| slope * slope).sum::<f64>();
        let of_draw = f64::from(tolerances.standing) * drawn;
        let of_leakage = f64::from(tolerances.leakage) * leaked;
        let of_capacitance = f64::from(tolerances.capacitance) * (self.energy - self.first);
        let variance = of_readings + of_draw.powi(2) + of_capacitance.powi(2) + of_leakage.powi(2);
        let efficiency = self.reservoir.charging_efficiency();
        [income.max(0.0) / efficiency, variance / (efficiency * efficiency)]
    }

    fn close(&mut self, [energy, variance]: [f64; 2]) {
        let seconds = self.second - self.began;
        let bound = (2.5 * variance.sqrt()) as f32;
        self.hour = Some(IncomeOfTime { seconds, energy: energy as f32, bound, silent: 0 });
        self.began = self.second;
    }

    /// Ends a slot that began with the last reading, and plans the next one.
    fn end_slot(&mut self) {
        let seconds = f64::from(self.second - self.read).max(1.0);
        let [income, variance] = self.income(self.read);
        let (power, index) = (income / seconds, |second: u32| (second / SLOT) as usize % SLOTS);
        let VoltageParameters { standing_power, actions: [action], .. } = self.parameters;
        let Rule::Ewma(slots) = &mut self.rule else { return };
        let slot = &mut slots[index(self.read)];
        let [mean, square] = slot.unwrap_or([power, variance / (seconds * seconds)]);
        let mean_error = WEIGHT * square + (1.0 - WEIGHT) * (power - mean).powi(2);
        let known = [WEIGHT * mean + (1.0 - WEIGHT) * power, mean_error];
        *slot = Some(known);
        let [next, _] = slots[index(self.second)].unwrap_or(known);
        let [estimated, of_estimate] = self.estimated;
        self.estimated = [estimated + known[0] * seconds, of_estimate + known[1] * seconds * seconds];
        if self.second - self.began >= 3600 {
            self.close(self.estimated);
            self.estimated = [0.0; 2];
        }
        let above = self.energy - self.least();
        let runs = ((next - f64::from(standing_power)) * f64::from(SLOT) + above) / f64::from(action.energy);
        self.period = if runs > 0.0 { (f64::from(SLOT) / runs) as u32 } else { u32::MAX };
        self.period = self.period.max(action.every);
        (self.first, self.spent) = (self.energy, 0.0);
    }

    fn take(&mut self, code: u32) {
        let converter = self.parameters.converter;
        let cell = f64::from(converter.full_scale) / f64::from(1_u32 << converter.bits);
        self.energy = self.at(f64::from(code) * cell);
        if self.readings == 0 {
            self.first = self.energy;
        }
        match self.rule {
            Rule::Ewma(_) if self.readings > 0 => self.end_slot(),
            Rule::Difference if self.second - self.began >= 3600 => {
                let income = self.income(self.began);
                self.close(income);
                (self.first, self.spent) = (self.energy, 0.0);
            }
            _ => {}
        }
        (self.read, self.readings) = (self.second, self.readings + 1);
        self.spent += f64::from(self.parameters.reading);
    }
}

impl Strategy for Baseline {
    fn wake(&mut self, now: u32, code: Option<u32>, _: bool) -> Wake {
        self.second = now;
        let reads = !matches!(self.rule, Rule::Fixed(_));
        if let Some(code) = code.filter(|_| reads) {
            self.take(code);
        }
        let VoltageParameters { actions: [action], .. } = self.parameters;
        let energy = f64::from(action.energy);
        let (to_reading, rest) = match self.rule {
            Rule::Difference => (EVERY, action.every),
            Rule::Ewma(_) => (SLOT, self.period),
            Rule::Fixed(_) => (u32::MAX, self.period),
        };
        let due = self.read.saturating_add(to_reading).saturating_sub(now).max(1);
        if self.rule == Rule::Difference && self.energy - energy <= self.least() {
            return Wake { task: Task::Sleep, again_in: due, read: true };
        }
        let rested = now - self.ran;
        if rested < rest {
            let again_in = due.min(rest - rested);
            return Wake { task: Task::Sleep, again_in, read: reads && again_in == due };
        }
        (self.ran, self.energy, self.spent) = (now, self.energy - energy, self.spent + energy);
        Wake { task: Task::Run(0), again_in: 0, read: false }
    }

    fn last_hour(&self) -> Option<IncomeOfTime> {
        self.hour
    }

    fn spent(&self) -> f64 {
        f64::from(self.readings) * f64::from(self.parameters.reading)
    }
}

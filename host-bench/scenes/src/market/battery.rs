//! The energy of a storage over its voltage, in double precision and without the core: integrals of the voltage over the charge by
//! the state of charge, and their inverse by bisection.

use super::Battery;

/// What holds the energy of a node: a capacitor, alone or beside a battery.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reservoir {
    /// Capacitance in F.
    pub capacitance_f: f64,
    /// Leakage resistance of the capacitor in Ω.
    pub leakage_ohm: f64,
    pub battery: Option<Battery>,
}

impl Battery {
    /// With so many times the charge, and a resistance that has the same drop at so many times the current.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.charge_c.0 *= factor;
        self.resistance_ohm.0 /= factor;
        self
    }

    /// That of the core, with a charge as stated.
    pub fn of_core(&self) -> model_core::energy::Battery {
        model_core::energy::Battery {
            points: self.open_circuit,
            charge: self.charge_c.0 as f32,
            resistance: self.resistance_ohm.0 as f32,
            charging_efficiency: self.charging_efficiency.0 as f32,
            self_discharge: self.self_discharge_per_s.0 as f32,
            tolerance: self.tolerance.0 as f32,
        }
    }

    /// Lowest and highest voltage of the points in V.
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.open_circuit.first(), self.open_circuit.last()]
            .map(|point| point.map_or(0.0, |end| end[1].into()))
    }

    /// The integral of the voltage over the charge in J, from the first point to a voltage in V, and dQ/dV in F there.
    fn integral(&self, voltage: f64) -> [f64; 2] {
        let (mut energy, mut slope) = (0.0, 0.0);
        for points in self.open_circuit.windows(2) {
            let [[from, low], [to, high]] = [points[0], points[1]].map(|point| point.map(f64::from));
            slope = self.charge_c.0 * (to - from) / (high - low);
            let end = voltage.min(high);
            energy += 0.5 * (low + end) * slope * (end - low);
            if voltage <= high {
                break;
            }
        }
        [energy, slope]
    }
}

impl Reservoir {
    /// Stored energy in J at an open-circuit voltage in V.
    pub fn energy_j(&self, voltage: f64) -> f64 {
        let of_battery = self.battery.map_or(0.0, |battery| battery.integral(voltage)[0]);
        0.5 * self.capacitance_f * voltage * voltage + of_battery
    }

    /// Open-circuit voltage in V at a stored energy in J.
    pub fn voltage_v(&self, energy: f64) -> f64 {
        let Some(battery) = &self.battery else { return (2.0 * energy / self.capacitance_f).max(0.0).sqrt() };
        let [mut low, mut high] = battery.ends();
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            *(if self.energy_j(middle) < energy { &mut low } else { &mut high }) = middle;
        }
        0.5 * (low + high)
    }

    /// Derivative of the energy by the voltage in J/V, at a voltage in V.
    pub fn slope(&self, voltage: f64) -> f64 {
        voltage * self.differential_f(voltage)
    }

    /// Derivative of the charge by the voltage in F, at a voltage in V.
    pub fn differential_f(&self, voltage: f64) -> f64 {
        self.capacitance_f + self.battery.map_or(0.0, |battery| battery.integral(voltage)[1])
    }

    /// Part of the stored energy in J that is lost in a second, in 1/s.
    pub fn leaking(&self, energy: f64) -> f64 {
        let Some(battery) = &self.battery else { return 2.0 / (self.leakage_ohm * self.capacitance_f) };
        let beside = self.voltage_v(energy).powi(2) / (self.leakage_ohm * energy);
        battery.self_discharge_per_s.0 + beside
    }

    /// Part of the harvested energy that a battery stores.
    pub fn charging_efficiency(&self) -> f64 {
        self.battery.map_or(1.0, |battery| battery.charging_efficiency.0)
    }
}

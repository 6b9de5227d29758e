//! `[node.parts]`, and what the parts take: asleep, for a burst, for a reading of the storage, for an action.

use super::super::document::SceneError;
use super::super::key::{Table, Value, between, number, other, whole};
use super::super::scene::{Action, EstimationCost, PartFigure};
use super::super::section::Section;
use crate::market::{Accelerometer, Clock, Code, Cost, CostModel, Figure, Processor, Radio};

/// `[node.parts]`.
pub(super) static PARTS: Table = Table::of(&[
    other("processor", Value::Part(Processor::words), "The microcontroller"),
    other(
        "clock",
        Value::Part(clocks),
        "The processor's own clock, or one that switches the supply of all else",
    )
    .or_said("`own`; required for `sam-d21`"),
    other("accelerometer", Value::Part(Accelerometer::words), "The accelerometer").or_said("none"),
    other("radio", Value::Part(Radio::words), "The radio").or_said("none"),
]);

const EVERY: super::super::key::Key =
    number("every_s", "s", between(1.0, 86_400.0), "Time from one to the next that is wished for");

/// `[node.burst]`.
pub(super) static BURST: Table = Table::of(&[
    whole("samples", "", between(1.0, 65_536.0), "Samples of a burst"),
    number("rate_hz", "Hz", between(0.1, 1e5), "Samples per second")
        .limit("at most the highest known rate of the accelerometer"),
    number("instructions", "", between(0.0, 1e9), "Instructions for all samples"),
    other("code", Value::Words(&["filter", "trajectory"]), "Kind of these instructions").or_said("`filter`"),
    EVERY,
]);

/// `[node.voltage_reading]`.
pub(super) static READING: Table = Table::of(&[EVERY]);

#[derive(Debug, Clone, Copy)]
pub(super) struct Parts {
    /// With an accelerometer in any case; a scene without one has no burst.
    model: CostModel,
    accelerometer: Option<Accelerometer>,
    radio: Option<Radio>,
}

fn clocks() -> Vec<&'static str> {
    [vec!["own"], Clock::words()].concat()
}

/// Reads `[node.parts]`.
pub(super) fn parts(section: &mut Section<'_>) -> Result<Option<Parts>, SceneError> {
    let Some(mut table) = section.optional_table("parts")? else { return Ok(None) };
    let processor = table.part("processor", Processor::words, Processor::named)?;
    let clock =
        if table.has("clock") { table.part("clock", clocks, |word| Some(Clock::named(word)))? } else { None };
    let accelerometer = table
        .has("accelerometer")
        .then(|| table.part("accelerometer", Accelerometer::words, Accelerometer::named))
        .transpose()?;
    let radio = table.has("radio").then(|| table.part("radio", Radio::words, Radio::named)).transpose()?;
    let model = CostModel::new(processor, accelerometer.unwrap_or(Accelerometer::all()[0]));
    let model = clock.map_or(model, |clock| model.gated_by(clock));
    if model.standing_power().is_none() {
        let reason = "its current asleep is not known; name a clock that switches its supply off";
        return Err(table.refuse("processor", reason));
    }
    table.finish()?;
    Ok(Some(Parts { model, accelerometer, radio }))
}

/// What a burst or a reading takes by its parts, in J; the names are those of the results.
fn costs(cost: &Cost, conversion: f64) -> Vec<(&'static str, f64)> {
    vec![
        ("computing_j", cost.computing),
        ("sensor_j", cost.sensor),
        ("transfer_j", cost.transfer),
        ("wake_up_j", cost.wake_up),
        ("waiting_j", cost.waiting),
        ("conversion_j", conversion),
    ]
}

impl Parts {
    /// Power in W between wake-ups.
    pub(super) fn asleep(&self) -> f64 {
        self.model.standing_power().unwrap_or(0.0)
    }

    /// Reads `[node.burst]`.
    pub(super) fn burst(&self, table: &mut Section<'_>) -> Result<EstimationCost, SceneError> {
        let every_s = table.number("every_s")?;
        let samples = table.whole_number("samples")? as u32;
        let rate = table.number("rate_hz")?;
        let instructions = table.number("instructions")?;
        let code = if table.has("code") {
            table.choice("code", &[("filter", Code::Filter), ("trajectory", Code::Trajectory)])?
        } else {
            Code::Filter
        };
        let Some(sensor) = self.accelerometer else {
            let reason = "needs an accelerometer; name one in node.parts.accelerometer";
            return Err(table.refuse("samples", reason));
        };
        if sensor.power(rate).is_none() {
            let reason =
                format!("must be at most {}, the highest known rate of {}", sensor.rates_hz[1], sensor.name);
            return Err(table.refuse("rate_hz", reason));
        }
        let Some(cost) = self.model.burst(samples, rate, instructions, code) else {
            let reason = format!("the current of {} between samples is not known", self.model.processor.name);
            return Err(table.refuse("samples", reason));
        };
        let computing_s = self.model.processor.computing_time(instructions, code);
        Ok(EstimationCost {
            action: Action {
                name: "burst".to_owned(),
                energy_j: cost.total(),
                duration_s: self.model.burst_time(samples, rate) + computing_s,
                every_s,
            },
            costs: costs(&cost, 0.0),
        })
    }

    pub(super) fn voltage_reading(&self, table: &mut Section<'_>) -> Result<EstimationCost, SceneError> {
        let start = self.model.start_energy();
        let cost = Cost { computing: 0.0, sensor: 0.0, transfer: 0.0, wake_up: start, waiting: 0.0 };
        let conversion = self.model.adc.reading_j.0;
        Ok(EstimationCost {
            action: Action {
                name: "voltage_reading".to_owned(),
                energy_j: cost.total() + conversion,
                duration_s: self.model.adc.duration_s.0,
                every_s: table.number("every_s")?,
            },
            costs: costs(&cost, conversion),
        })
    }

    /// Reads what an action states by parts: energy in J and duration in s; `None` if it states nothing so. Each is an
    /// upper bound: the processor wakes up for each action.
    pub(super) fn action(&self, table: &mut Section<'_>) -> Result<Option<[f64; 2]>, SceneError> {
        let (mut energy, mut duration, mut stated) = (self.model.start_energy(), 0.0, false);
        if table.has("packet_bytes") {
            let bytes = table.whole_number("packet_bytes")? as u32;
            let Some(radio) = self.radio else {
                return Err(table.refuse("packet_bytes", "needs a radio; name one in node.parts.radio"));
            };
            let (Some(joules), Some(seconds)) = (radio.packet(bytes), radio.packet_time(bytes)) else {
                let reason =
                    format!("must be at most {}, the longest packet of {}", radio.most_bytes, radio.name);
                return Err(table.refuse("packet_bytes", reason));
            };
            (energy, duration, stated) = (energy + joules, duration + seconds, true);
        }
        if table.has("adc_readings") {
            let count = table.whole_number("adc_readings")? as f64;
            energy += count * self.model.adc.reading_j.0;
            (duration, stated) = (duration + count * self.model.adc.duration_s.0, true);
        }
        if let Some(instructions) = table.optional_number("instructions")? {
            energy += self.model.processor.computing(instructions, Code::Filter);
            (duration, stated) =
                (duration + self.model.processor.computing_time(instructions, Code::Filter), true);
        }
        Ok(stated.then_some([energy, duration]))
    }

    /// The figures that the energies come from.
    pub(super) fn figures(&self) -> Vec<PartFigure> {
        let mut all = Vec::new();
        let mut add = |part: &str, quantity: &'static str, figure: Figure| {
            all.push(PartFigure {
                part: part.to_owned(),
                quantity,
                value: figure.0,
                evidence: figure.1,
                source: figure.2,
            });
        };
        let processor = &self.model.processor;
        add(processor.name, "energy_per_cycle_j", processor.energy_per_cycle_j);
        add(processor.name, "clock_hz", processor.clock_hz);
        add(processor.name, "wake_up_s", processor.wake_up_s);
        if let Some(sleep) = processor.sleep_a {
            add(processor.name, "sleep_a", sleep);
        }
        if let Some((clock, start)) = &self.model.gate {
            add(clock.name, "current_a", clock.current_a);
            add("cold start", "decoupling_f", start.decoupling_f);
            add("cold start", "time_s", start.time_s);
        }
        if let Some(sensor) = &self.accelerometer {
            add(sensor.name, "slow_current_a", sensor.slow_current_a);
            add(sensor.name, "fast_current_a", sensor.fast_current_a);
            add("bus", "transfer_per_bit_j", self.model.transfer_per_bit);
        }
        add("ADC", "reading_j", self.model.adc.reading_j);
        if let Some(radio) = &self.radio {
            add(radio.name, "transmitting_a", radio.transmitting_a);
            add(radio.name, "ramp_up_s", radio.ramp_up_s);
            add(radio.name, "overhead_s", radio.overhead_s);
            add(radio.name, "bit_rate_hz", radio.bit_rate_hz);
        }
        all
    }
}

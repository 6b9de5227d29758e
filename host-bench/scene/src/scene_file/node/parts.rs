//! `[node.parts]`, and what the parts take: asleep, for a listen, for a reading of the storage, for an action.

use model_core::energy::cost::{
    Accelerometer, Adc, Asleep, Clock, Code, Cost, CostModel, Evidence, Figure, Processor, Radio,
};

use super::super::bounds::between;
use super::super::document::SceneError;
use super::super::key::{Table, Value, number, other, whole};
use super::super::scene::{Action, Knowing, PartFigure};
use super::super::section::Section;

/// The words of the parts: their names in lower case with hyphens.
const PROCESSORS: [&str; 9] =
    ["nrf52832", "nrf52840", "apollo3", "nrf54l15", "efr32xg22", "stm32l051", "sam-l21", "sam-d21", "cc2340"];
const CLOCKS: [&str; 4] = ["own", "ab18x5-crystal", "ab18x5-calibrated", "ab18x5-rc"];
const ACCELEROMETERS: [&str; 6] = ["adxl362", "adxl367", "bma400", "lis2dw12", "lis2dh12", "iis3dwb"];
const RADIOS: [&str; 3] = ["nrf52832-0-dbm", "sx1261-fsk-14-dbm", "sx1261-lora-sf7-14-dbm"];

/// `[node.parts]`.
pub(super) static PARTS: Table = Table::of(&[
    other("processor", Value::Words(&PROCESSORS), "The microcontroller"),
    other(
        "clock",
        Value::Words(&CLOCKS),
        "The processor's own clock, or one that switches the supply of all else",
    )
    .or_said("`own`; required for `sam-d21`"),
    other("accelerometer", Value::Words(&ACCELEROMETERS), "The accelerometer").or_said("none"),
    other("radio", Value::Words(&RADIOS), "The radio").or_said("none"),
]);

const EVERY: super::super::key::Key =
    number("every_s", "s", between(1.0, 86_400.0), "Time from one to the next that is wished for");

/// `[node.listen]`.
pub(super) static LISTEN: Table = Table::of(&[
    whole("samples", "", between(1.0, 65_536.0), "Samples of a burst"),
    number("rate_hz", "Hz", between(0.1, 1e5), "Samples per second")
        .limit("at most the highest known rate of the accelerometer"),
    number("instructions", "", between(0.0, 1e9), "Instructions for all samples"),
    other("code", Value::Words(&["filter", "trajectory"]), "Kind of these instructions").or_said("`filter`"),
    EVERY,
]);

/// `[node.voltage_reading]`.
pub(super) static READING: Table = Table::of(&[EVERY]);

/// The named parts of a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parts {
    /// With an accelerometer in any case; a scene without one has no listen.
    model: CostModel<f64>,
    accelerometer: Option<Accelerometer<f64>>,
    radio: Option<Radio<f64>>,
    adc: Adc<f64>,
}

/// The word for a part in a scene file: its name in lower case with hyphens.
fn word(name: &str) -> String {
    name.to_lowercase().replace(' ', "-")
}

/// The part that a key names.
fn choice<T: Copy>(
    table: &mut Section<'_>,
    key: &'static str,
    all: impl IntoIterator<Item = (&'static str, T)>,
) -> Result<T, SceneError> {
    let parts: Vec<(String, T)> = all.into_iter().map(|(name, part)| (word(name), part)).collect();
    let words: Vec<(&str, T)> = parts.iter().map(|(word, part)| (word.as_str(), *part)).collect();
    table.choice(key, &words)
}

/// Reads `[node.parts]`.
pub(super) fn parts(section: &mut Section<'_>) -> Result<Option<Parts>, SceneError> {
    let Some(mut table) = section.optional_table("parts")? else { return Ok(None) };
    let processor = choice(&mut table, "processor", Processor::all().map(|part| (part.name, part)))?;
    let clock = if table.has("clock") {
        let own = std::iter::once(("own", None));
        choice(&mut table, "clock", own.chain(Clock::all().map(|part| (part.name, Some(part)))))?
    } else {
        None
    };
    let accelerometer = if table.has("accelerometer") {
        Some(choice(&mut table, "accelerometer", Accelerometer::all().map(|part| (part.name, part)))?)
    } else {
        None
    };
    let radio = if table.has("radio") {
        Some(choice(&mut table, "radio", Radio::all().map(|part| (part.name, part)))?)
    } else {
        None
    };
    let model = CostModel::new(processor, accelerometer.unwrap_or_else(Accelerometer::adxl362));
    let model = clock.map_or(model, |clock| model.gated_by(clock));
    if model.standing_power().is_none() {
        let reason = "its current asleep is not known; name a clock that switches its supply off";
        return Err(table.refuse("processor", reason));
    }
    table.finish()?;
    Ok(Some(Parts { model, accelerometer, radio, adc: Adc::twelve_bits() }))
}

/// What a listen or a reading takes by its parts, in J; the names are those of the results.
fn costs(cost: &Cost<f64>, conversion: f64) -> Vec<(&'static str, f64)> {
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

    /// Reads `[node.listen]`.
    pub(super) fn listen(&self, table: &mut Section<'_>) -> Result<Knowing, SceneError> {
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
                format!("must be at most {}, the highest known rate of {}", sensor.fast.rate, sensor.name);
            return Err(table.refuse("rate_hz", reason));
        }
        let Some(cost) = self.model.listen(samples, rate, instructions, code) else {
            let reason = format!("the current of {} between samples is not known", self.model.processor.name);
            return Err(table.refuse("samples", reason));
        };
        let computing_s = self.computing_time(instructions, code);
        Ok(Knowing {
            action: Action {
                name: "listen".to_owned(),
                energy_j: cost.total(),
                duration_s: self.model.listen_time(samples, rate) + computing_s,
                every_s,
            },
            costs: costs(&cost, 0.0),
        })
    }

    /// Reads `[node.voltage_reading]`.
    pub(super) fn voltage_reading(&self, table: &mut Section<'_>) -> Result<Knowing, SceneError> {
        let start = self.model.start_energy();
        let cost = Cost { computing: 0.0, sensor: 0.0, transfer: 0.0, wake_up: start, waiting: 0.0 };
        let conversion = self.adc.reading.value;
        Ok(Knowing {
            action: Action {
                name: "voltage_reading".to_owned(),
                energy_j: cost.total() + conversion,
                duration_s: self.adc.duration.value,
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
            energy += count * self.adc.reading.value;
            (duration, stated) = (duration + count * self.adc.duration.value, true);
        }
        if let Some(instructions) = table.optional_number("instructions")? {
            energy += self.model.processor.computing(instructions, Code::Filter);
            (duration, stated) = (duration + self.computing_time(instructions, Code::Filter), true);
        }
        Ok(stated.then_some([energy, duration]))
    }

    /// Time of instructions in s.
    fn computing_time(&self, instructions: f64, code: Code) -> f64 {
        let processor = &self.model.processor;
        instructions * processor.cycles_per_instruction(code).value / processor.clock.value
    }

    /// The figures that the energies come from.
    pub(super) fn figures(&self) -> Vec<PartFigure> {
        let mut all = Vec::new();
        let mut add = |part: &str, quantity: &'static str, figure: Figure<f64>| {
            all.push(PartFigure {
                part: part.to_owned(),
                quantity,
                value: figure.value,
                source: figure.source,
                evidence: match figure.evidence {
                    Evidence::Confirmed => "confirmed",
                    Evidence::Secondary => "secondary",
                    Evidence::Unconfirmed => "unconfirmed",
                    Evidence::Estimated => "estimated",
                },
            });
        };
        let processor = &self.model.processor;
        add(processor.name, "energy_per_cycle_j", processor.energy_per_cycle);
        add(processor.name, "clock_hz", processor.clock);
        add(processor.name, "wake_up_s", processor.wake_up);
        if let Some(sleep) = processor.sleep {
            add(processor.name, "sleep_a", sleep);
        }
        if let Asleep::Gated(clock, start) = &self.model.asleep {
            add(clock.name, "current_a", clock.current);
            add("cold start", "decoupling_f", start.decoupling);
            add("cold start", "time_s", start.time);
        }
        if let Some(sensor) = &self.accelerometer {
            add(sensor.name, "slow_current_a", sensor.slow.current);
            add(sensor.name, "fast_current_a", sensor.fast.current);
            add("bus", "transfer_per_bit_j", self.model.transfer_per_bit);
        }
        add("ADC", "reading_j", self.adc.reading);
        if let Some(radio) = &self.radio {
            add(radio.name, "transmitting_a", radio.transmitting);
            add(radio.name, "ramp_up_s", radio.ramp_up);
            add(radio.name, "overhead_s", radio.overhead);
            add(radio.name, "bit_rate_hz", radio.bit_rate);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_the_library_has_its_word() {
        let words = |names: &[&'static str]| names.iter().map(|name| word(name)).collect::<Vec<_>>();
        assert_eq!(words(&Processor::<f64>::all().map(|part| part.name)), PROCESSORS);
        assert_eq!(words(&Accelerometer::<f64>::all().map(|part| part.name)), ACCELEROMETERS);
        assert_eq!(words(&Radio::<f64>::all().map(|part| part.name)), RADIOS);
        assert_eq!(words(&Clock::<f64>::all().map(|part| part.name)), CLOCKS[1..]);
    }
}

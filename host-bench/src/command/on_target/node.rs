//! The node on its simulated plant: its estimates of the day, and their cost.

use std::time::Duration;

use firmware_example::node::parts::{BURST, RATE};
use firmware_example::node::{Entry, IMAGE_BYTES, State, Work};
use harvester_scene::market::{self, Accelerometer, Code, CostModel, Evidence, Instructions, Processor};
use model_core::node::IncomeOfTime;
use serde_json::{Value, json};

use super::{Output, announce, on_each};
use crate::on_target::Error;
use crate::on_target::node::{self, Bare, Call, Followed, calls};
use crate::on_target::qemu::Core;

pub(super) fn report(cores: &[Core], limit: Duration, output: &mut Output) -> Result<(), Error> {
    let measured = on_each(cores, |core| {
        announce(core);
        Ok((core, node::follow(core, limit)?, node::bare(core, true, limit)?))
    })?;
    for (core, found, bare) in &measured {
        hours(*core, found, output);
        let shares = estimation(*core, found, output);
        tier(*core, "map", &found.bare, &shares, output);
        tier(*core, "voltage", bare, &of_voltage(*core, bare), output);
    }
    measured.iter().try_for_each(|(core, found, bare)| stated(*core, &found.bare, bare))
}

/// Fails where [`market::node_instructions`] does not state what was measured.
fn stated(core: Core, map: &Bare, voltage: &Bare) -> Result<(), Error> {
    let of_core = match core {
        Core::M0 => market::Core::M0Plus,
        Core::M4f => market::Core::M4f,
        Core::M3 | Core::M7 | Core::M33 => return Ok(()),
    };
    let of = |bare: &Bare, name| call(bare, name).map_or(f64::NAN, |call| call.counts[1]);
    let calls = |name| call(map, name).map_or(f64::NAN, |call| call.counts[0]);
    let samples = calls("block") / PARTS * SAMPLES;
    let block = PARTS * of(map, "block") + of(map, "wake");
    let Instructions { reading, sample, block: of_block } = market::node_instructions(of_core);
    for (name, stated, measured) in [
        ("reading", reading, of(voltage, "reading")),
        ("sample", sample, calls("samples") * of(map, "samples") / samples),
        ("block", of_block, block),
    ] {
        if !((stated / measured - 1.0).abs() <= MOST_OFF) {
            let what = format!("node_instructions.{name} is {stated}, at most 5 % from {measured:.1}");
            return Err(Error::Core { core, what });
        }
    }
    Ok(())
}

/// Samples of a burst, calls that evaluate one, and how far the stated instructions may be off.
const SAMPLES: f64 = 640.0;
const PARTS: f64 = 3.0;
const MOST_OFF: f64 = 0.05;

/// The estimate of the node, and the truth.
struct EstimatedIncome {
    /// Second of the day at its end, and when it began.
    end: u32,
    estimated: IncomeOfTime,
    /// In J.
    income: f64,
}

impl EstimatedIncome {
    fn error(&self) -> f64 {
        f64::from(self.estimated.energy) - self.income
    }

    fn is_inside(&self) -> bool {
        self.error().abs() <= f64::from(self.estimated.bound)
    }

    /// Mean powers in W: estimated, bound, and true.
    fn powers(&self) -> [f64; 3] {
        let seconds = f64::from(self.estimated.seconds.max(1));
        [self.estimated.energy.into(), self.estimated.bound.into(), self.income]
            .map(|energy: f64| energy / seconds)
    }

    fn cells(&self, name: String) -> Vec<String> {
        let mut cells = vec![name];
        cells.extend(self.powers().map(|power| format!("{:.3}", 1e6 * power)));
        let error = if self.income > 0.0 {
            format!("{:+.2} %", 100.0 * self.error() / self.income)
        } else {
            "-".to_owned()
        };
        cells.extend([error, if self.is_inside() { "yes" } else { "no" }.to_owned()]);
        cells
    }

    fn json(&self, core: Core, case: &str) -> Value {
        let [estimated, bound, truth] = self.powers();
        json!({
            "core": core.to_string(),
            "variant": "node",
            "case": case,
            "end_s": self.end,
            "duration_s": self.estimated.seconds,
            "estimated_w": estimated,
            "bound_w": bound,
            "income_w": truth,
            "silent_s": self.estimated.silent,
        })
    }
}

/// Energy in J of whole pJ.
fn joules(energy: u64) -> f64 {
    energy as f64 * 1e-12
}

/// Prints the income of each hour and of the day.
fn hours(core: Core, found: &Followed, output: &mut Output) {
    let entries = &found.whole.entries;
    let hours: Vec<EstimatedIncome> = entries
        .iter()
        .filter_map(|entry| match entry {
            Entry::Hour(hour) => Some(EstimatedIncome {
                end: hour.second,
                estimated: hour.estimated,
                income: joules(hour.income),
            }),
            _ => None,
        })
        .collect();
    let last = entries.iter().rev().find_map(|entry| match entry {
        Entry::State(state) => Some(state),
        _ => None,
    });
    let Some(last) = last else { return };
    let all = EstimatedIncome { end: last.second, estimated: last.estimated, income: joules(last.income) };
    let clock = |second: u32| format!("{:02}:{:02}", second / 3600, second % 3600 / 60);
    let mut rows: Vec<Vec<String>> = hours.iter().map(|hour| hour.cells(clock(hour.end))).collect();
    rows.push(all.cells("the day".to_owned()));
    let note = day_note(core, found, &hours, last, &all);
    let header = vec!["until", "estimated", "bound", "true", "error", "inside"];
    output.table(header, rows, 1, &note);
    hours.iter().for_each(|hour| output.objects.push(hour.json(core, "hour")));
    let Bare { size: bare, memory, .. } = &found.bare;
    let mut day = all.json(core, "day");
    let more = json!({
        "readings": last.instruments[0],
        "bursts": last.instruments[1],
        "share_of_income": f64::from(last.estimation) / all.income,
        "losses_of_power": found.losses,
        "flash_bytes": bare.flash,
        "ram_bytes": bare.static_ram,
        "flash_bytes_with_plant": found.size.flash,
        "ram_bytes_with_plant": found.size.static_ram,
        "stack_bytes": memory.stack,
        "ram_with_stack_bytes": bare.static_ram + memory.stack,
        "state_bytes": memory.state,
        "stack_bytes_with_plant": found.stack,
        "image_bytes": IMAGE_BYTES,
    });
    if let (Value::Object(day), Value::Object(more)) = (&mut day, more) {
        day.extend(more);
    }
    output.objects.push(day);
}

/// What stands below the hours of a day.
fn day_note(
    core: Core,
    found: &Followed,
    hours: &[EstimatedIncome],
    last: &State,
    all: &EstimatedIncome,
) -> String {
    let with_income = hours.iter().filter(|hour| hour.income > 0.0);
    let inside = hours.iter().filter(|hour| hour.is_inside()).count();
    let [readings, bursts] = last.instruments;
    let [measured, transmitted] = last.ran;
    let Bare { size: bare, memory, .. } = &found.bare;
    let ram = bare.static_ram + memory.stack;
    format!(
        "{core}. Income in uW until that time of the day, estimated with its bound, and that of the plant. Inside: {inside} of {} hours, of which
{} have an income. {readings} readings, {bursts} bursts, {measured} measurements, {transmitted} transmissions.
By its own books the node spent {:.2} % of the income on estimating it.
{} losses of power; after each the node came to the same bits. Each logged value has the host's bits.
The node on a board takes {} bytes of flash, map included, and two pages for images of {IMAGE_BYTES} bytes. RAM: {} bytes, of which
static {}, state {}, image {}; the rest is stack.
With the log, the simulated memory and the plant: flash {}, static RAM {}, stack {}.",
        hours.len(),
        with_income.count(),
        100.0 * f64::from(last.estimation) / all.income,
        found.losses,
        bare.flash,
        ram,
        bare.static_ram,
        memory.state,
        memory.image,
        found.size.flash,
        found.size.static_ram,
        found.stack,
    )
}

/// Income in W by which the share of the node by the voltage is stated, and its readings in an hour, the one at its end included.
const INCOME: f64 = 2.9e-6;
const READINGS: f64 = 12.0;

/// The shares of the income that the readings of a node by the voltage take, on the parts that have the core.
fn of_voltage(core: Core, bare: &Bare) -> Vec<(&'static str, f64)> {
    let [_, reading, _] = instructions(bare);
    let share = |part: Processor| {
        let energy = CostModel::new(part, Accelerometer::named("adxl362")?).reading(reading);
        Some((part.name, READINGS * energy / (3600.0 * INCOME)))
    };
    parts(core).into_iter().filter_map(share).collect()
}

/// The calls of a kind.
fn call<'a>(bare: &'a Bare, name: &str) -> Option<&'a Call> {
    bare.calls.iter().find(|call| call.name == name)
}

/// Instructions of a boot, of a reading in the mean, and of the largest call.
fn instructions(bare: &Bare) -> [f64; 3] {
    let of = |name| call(bare, name).map_or(0.0, |call| call.counts[1]);
    [of("boot"), of("reading"), bare.calls.iter().fold(0.0, |largest, call| call.counts[2].max(largest))]
}

/// Prints the size and the calls of a tier on a board.
fn tier(core: Core, tier: &str, bare: &Bare, shares: &[(&'static str, f64)], output: &mut Output) {
    let [boot, reading, largest] = instructions(bare);
    let ram = bare.size.static_ram + bare.memory.stack;
    let rows = shares.iter().map(|(part, share)| {
        let counts = [bare.size.flash as f64, ram as f64, boot, reading, largest];
        let cells = counts.into_iter().map(|count| format!("{count:.0}"));
        [tier.to_owned(), (*part).to_owned()]
            .into_iter()
            .chain(cells)
            .chain([format!("{:.3} %", 100.0 * share)])
            .collect()
    });
    let note = format!(
        "{core}. A node on a board: bytes, with the deepest stack in the RAM, and instructions of calls."
    );
    let header = vec!["tier", "part", "flash", "RAM", "boot", "reading", "largest call", "of the income"];
    output.table(header, rows.collect(), 2, &note);
    let rows = bare.calls.iter().map(|call| {
        [call.name.clone()].into_iter().chain(call.counts.map(|count| format!("{count:.0}"))).collect()
    });
    let note = format!(
        "{core}, {tier}. Calls of the node: instructions in the mean and of the largest one, and stack in bytes."
    );
    output.table(vec!["call", "number", "mean", "largest", "stack"], rows.collect(), 1, &note);
    for Call { name, counts: [number, mean, largest, stack] } in &bare.calls {
        output.objects.push(json!({
            "tier": tier,
            "core": core.to_string(),
            "call": name,
            "calls": number,
            "mean_instructions": mean,
            "largest_instructions": largest,
            "call_stack_bytes": stack,
        }));
    }
    for (part, share) in shares {
        output.objects.push(json!({
            "tier": tier,
            "core": core.to_string(),
            "part": part,
            "flash_bytes": bare.size.flash,
            "ram_bytes": ram,
            "stack_bytes": bare.memory.stack,
            "boot_instructions": boot,
            "reading_instructions": reading,
            "largest_call_instructions": largest,
            "share_of_income": share,
        }));
    }
}

/// Prints the energy of estimating the income on the parts that have the core, by the counted instructions.
fn estimation(core: Core, found: &Followed, output: &mut Output) -> Vec<(&'static str, f64)> {
    let of = |work: Work| {
        let counted = found.counted.iter().find(|counted| counted.work == work.name());
        counted.map_or([f64::NAN; 2], |counted| [counted.instructions, counted.calls])
    };
    let ([of_readings, number], [of_bursts, number_of_bursts]) = (of(Work::Reading), of(Work::Burst));
    let (reading, burst) = (of_readings / number, (of(Work::Samples)[0] + of_bursts) / number_of_bursts);
    let readings = f64::from(calls(&found.whole, Work::Reading).calls);
    let bursts = f64::from(calls(&found.whole, Work::Burst).calls);
    let income = joules(found.whole.world.plant().income);
    let lines: Vec<(Processor, [f64; 3])> = parts(core)
        .into_iter()
        .filter_map(|part| {
            let model = CostModel::new(part, Accelerometer::named("adxl362")?);
            let reading = model.reading(reading);
            let burst = model.burst(BURST, RATE.into(), burst, Code::Filter)?.total();
            Some((part, [reading, burst, (readings * reading + bursts * burst) / income]))
        })
        .collect();
    let rows = lines.iter().map(|(part, [reading, burst, share])| {
        vec![
            marked(part),
            format!("{:.2}", 1e6 * reading),
            format!("{:.2}", 1e6 * burst),
            format!("{:.3} %", 100.0 * share),
        ]
    });
    if lines.is_empty() {
        return Vec::new();
    }
    let note = format!(
        "{core}. Energy in uJ by the instructions of the day, with sensor, transfer, wake-ups and converter: {readings} readings
and {bursts} bursts in the day. {UNCONFIRMED} marks an energy per cycle that was not confirmed."
    );
    output.table(vec!["part", "a reading", "a burst", "of the income"], rows.collect(), 1, &note);
    for (part, [reading, burst, share]) in &lines {
        output.objects.push(json!({
            "core": core.to_string(),
            "variant": "node",
            "case": "estimation",
            "part": part.name,
            "reading_j": reading,
            "burst_j": burst,
            "share_of_income": share,
        }));
    }
    lines.iter().map(|(part, [.., share])| (part.name, *share)).collect()
}

const UNCONFIRMED: &str = "*";

/// The processors that have `core`; a Cortex-M0 stands for M0+, which executes the same instructions.
fn parts(core: Core) -> Vec<Processor> {
    let kind = match core {
        Core::M0 => market::Core::M0Plus,
        Core::M4f => market::Core::M4f,
        Core::M33 => market::Core::M33,
        Core::M3 | Core::M7 => return Vec::new(),
    };
    Processor::all().iter().filter(|part| part.core == kind).copied().collect()
}

/// The name of a part, marked if its energy per cycle was not confirmed.
fn marked(part: &Processor) -> String {
    let mark = if part.energy_per_cycle_j.1 == Evidence::Confirmed { "" } else { UNCONFIRMED };
    format!("{}{mark}", part.name)
}

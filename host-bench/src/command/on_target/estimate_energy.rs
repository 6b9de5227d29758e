//! The energy of an estimate on the parts that have the measured core.

use harvester_scene::market::{self, Accelerometer, Code, Cost, CostModel, Evidence, Processor};
use serde_json::{Value, json};

use super::output::Output;
use super::rows::Row;
use crate::on_target::core::Core;

/// What a node that steps the model does for its estimate of each second.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    name: String,
    /// Samples of the accelerometer in a second.
    samples: u32,
    /// Instructions in a second.
    instructions: f64,
    code: Code,
}

impl Estimate {
    /// A workload that is fed samples, by its measured row.
    pub(super) fn sampled(row: &Row, code: Code) -> Self {
        let counted = row.counted();
        let name = row.workload.name.clone();
        let samples = (counted.steps as f64 / counted.seconds).round() as u32;
        Self { name, samples, instructions: counted.instructions_per_second(), code }
    }
}

/// Prints the energy of each estimate on each part with `core`.
pub(super) fn report(core: Core, estimates: &[Estimate], output: &mut Output) {
    let rows: Vec<Line> = estimates
        .iter()
        .flat_map(|estimate| parts(core).into_iter().filter_map(|part| Line::new(estimate, part)))
        .collect();
    if rows.is_empty() {
        return;
    }
    let header = vec![
        "part",
        "accelerometer",
        "estimate",
        "computing",
        "sensor",
        "transfer",
        "wake-ups",
        "uJ per estimate",
    ];
    let note = format!(
        "{core}. Energy in uJ of an estimate once a second from an accelerometer that always runs. Sleep is not in it.
{UNCONFIRMED} marks an energy per cycle that was not confirmed."
    );
    output.table(header, rows.iter().map(|line| line.cells()).collect(), 3, &note);
    for line in &rows {
        output.object(line.json(core));
    }
}

pub(super) const UNCONFIRMED: &str = "*";

/// The processors that have `core`; a Cortex-M0 stands for M0+, which executes the same instructions.
pub(super) fn parts(core: Core) -> Vec<Processor> {
    let kind = match core {
        Core::M0 => market::Core::M0Plus,
        Core::M4f => market::Core::M4f,
        Core::M33 => market::Core::M33,
        Core::M3 | Core::M7 => return Vec::new(),
    };
    Processor::all().iter().filter(|part| part.core == kind).copied().collect()
}

/// The name of a part, marked if its energy per cycle was not confirmed.
pub(super) fn marked(part: &Processor) -> String {
    let mark = if part.energy_per_cycle_j.1 == Evidence::Confirmed { "" } else { UNCONFIRMED };
    format!("{}{mark}", part.name)
}

/// An estimate on a part.
#[derive(Debug)]
struct Line<'a> {
    estimate: &'a Estimate,
    processor: Processor,
    accelerometer: Accelerometer,
    cost: Cost,
}

impl<'a> Line<'a> {
    /// With the accelerometer of least power at the rate of the samples; `None` where there is none.
    fn new(estimate: &'a Estimate, processor: Processor) -> Option<Self> {
        let rate = f64::from(estimate.samples);
        let (accelerometer, _) = Accelerometer::all()
            .iter()
            .filter_map(|part| part.power(rate).map(|power| (part, power)))
            .min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let model = CostModel::new(processor, *accelerometer);
        let cost = model.follow(estimate.samples, rate, estimate.instructions, estimate.code)?;
        Some(Self { estimate, processor, accelerometer: *accelerometer, cost })
    }

    fn cells(&self) -> Vec<String> {
        // An accelerometer that always runs has no supply that is switched off, and no waiting.
        let Cost { computing, sensor, transfer, wake_up, waiting: _ } = self.cost;
        let mut cells =
            vec![marked(&self.processor), self.accelerometer.name.to_owned(), self.estimate.name.clone()];
        cells.extend(
            [computing, sensor, transfer, wake_up, self.cost.total()]
                .map(|joules| format!("{:.2}", 1e6 * joules)),
        );
        cells
    }

    fn json(&self, core: Core) -> Value {
        json!({
            "core": core.to_string(),
            "part": self.processor.name,
            "accelerometer": self.accelerometer.name,
            "case": self.estimate.name,
            "energy_per_estimate_j": self.cost.total(),
            "computing_j": self.cost.computing,
            "sensor_j": self.cost.sensor,
            "transfer_j": self.cost.transfer,
            "wake_up_j": self.cost.wake_up,
        })
    }
}

//! What each part of a scene costs: the bench without it.

use std::time::Duration;

use firmware_example::workload::Workload;
use firmware_example::workload::bump_stop::{parts::GAP, scenes as bump_stop};
use firmware_example::workload::contact_separation::{parts, scenes as contact_separation};
use firmware_example::workload::sliding::scenes as sliding;

use super::table;
use crate::on_target::accuracy::{self, Yardstick};
use crate::on_target::build::Binary;
use crate::on_target::core::Core;
use crate::on_target::{self, Error, native};
use crate::scene_file::{
    BumpStop, ContactSeparationParameters, Coupling, ForceLaw, Load, Restitution, SlidingParameters,
};

/// Measures each variant of each scene and prints a table of each.
///
/// # Errors
///
/// If a firmware cannot be built, run, or trusted.
pub(super) fn report(core: Core, limit: Duration) -> Result<(), Error> {
    report_contact_separation(core, limit)?;
    println!();
    report_sliding(core, limit)?;
    println!();
    report_bump_stop(core, limit)
}

fn report_contact_separation(core: Core, limit: Duration) -> Result<(), Error> {
    type Change = fn(&mut ContactSeparationParameters);
    let no_capacitance: Change = |parameters| parameters.parasitic_capacitance_f = 0.0;
    let one_coefficient: Change = |parameters| {
        let coefficient = f64::from(parts::CONSTANT.coefficient);
        parameters.restitution = Restitution::Constant { coefficient };
    };
    let both: Change = |parameters| {
        parameters.parasitic_capacitance_f = 0.0;
        let coefficient = f64::from(parts::CONSTANT.coefficient);
        parameters.restitution = Restitution::Constant { coefficient };
    };
    let same: Change = |_| {};
    let mut variants = Variants { core, limit, whole: None, rows: Vec::new() };
    let mut add = |left_out, binary, native, change: Change| {
        let scene = accuracy::contact_separation(&contact_separation::IMPACTING, 0.0, change)?;
        variants.add(left_out, binary, native, Yardstick::mean_power(&scene)?)
    };
    use contact_separation as scenes;
    add("nothing", "bench", boxed(scenes::bench())?, same)?;
    add("parasitic capacitance", "without_parasitic", boxed(scenes::without_parasitic())?, no_capacitance)?;
    add("sticking", "without_sticking", boxed(scenes::without_sticking())?, same)?;
    add(
        "velocity-dependent restitution",
        "without_law_of_speed",
        boxed(scenes::without_law_of_speed())?,
        one_coefficient,
    )?;
    add("error control", "without_error_control", boxed(scenes::without_error_control())?, same)?;
    add("all of these", "without_any", boxed(scenes::without_any())?, both)?;
    variants.print("left out");
    println!("{core}. Contact-separation, the bench's run, 3 s with impacts; without error control a fixed");
    println!(
        "step of {} ms. Error: of the mean power against the reference of the same variant.",
        scenes::FIXED_STEP * 1e3
    );
    println!("The law of restitution works at impacts only, so a step without it costs the same.");
    println!(
        "Instructions as QEMU executes them, which are not cycles. Flash in bytes, over an empty firmware."
    );
    Ok(())
}

fn report_sliding(core: Core, limit: Duration) -> Result<(), Error> {
    type Change = fn(&mut SlidingParameters, &mut Load);
    let same: Change = |_, _| {};
    let frictionless: Change = |parameters, _| {
        parameters.static_friction_active = 0.0;
        parameters.static_friction_inert = 0.0;
        parameters.kinetic_friction_active = 0.0;
        parameters.kinetic_friction_inert = 0.0;
    };
    let open: Change = |_, load| *load = Load::Resistor { resistance_ohm: f64::INFINITY };
    let shorted: Change = |_, load| *load = Load::Resistor { resistance_ohm: 0.0 };
    let gap_field: Change = |parameters, _| parameters.force_law = ForceLaw::GapField;
    let mut variants = Variants { core, limit, whole: None, rows: Vec::new() };
    let mut add = |variant, binary, native, plan, change: Change| {
        let scene = accuracy::sliding(plan, 0.0, change)?;
        variants.add(variant, binary, native, Yardstick::mean_power(&scene)?)
    };
    use sliding as scenes;
    let plan = &scenes::SLIDING;
    add("whole", "sliding", boxed(scenes::bench())?, plan, same)?;
    add(
        "without friction",
        "sliding_without_friction",
        boxed(scenes::without_friction())?,
        &scenes::GENTLE,
        frictionless,
    )?;
    add(
        "without sticking",
        "sliding_without_sticking",
        boxed(scenes::without_sticking())?,
        &scenes::MOVING,
        same,
    )?;
    add("load open", "sliding_open", boxed(scenes::open())?, plan, open)?;
    add("load shorted", "sliding_shorted", boxed(scenes::shorted())?, plan, shorted)?;
    add("force of the field", "sliding_gap_field", boxed(scenes::gap_field())?, &scenes::STRONG, gap_field)?;
    add("TR-BDF2, fixed step", "sliding_implicit", boxed(scenes::implicit())?, plan, same)?;
    add(
        "TR-BDF2 with error control",
        "sliding_with_error_control",
        boxed(scenes::with_error_control())?,
        plan,
        same,
    )?;
    variants.print("variant");
    println!(
        "{core}. Sliding, 0.36 g at 18.373 Hz, 3 s from rest; without friction 0.1 g, or the discs would"
    );
    println!(
        "part; without sticking in motion from the start; with the force of the field 0.8 g at 16 Hz, or the"
    );
    println!(
        "slider would not let go. Runge-Kutta 4 with a step of {} ms; TR-BDF2 with one of {} ms, or with a",
        scenes::STEP * 1e3,
        scenes::IMPLICIT_STEP * 1e3
    );
    println!(
        "tolerance of {}. Error: of the mean power, against the independent reference of",
        scenes::TOLERANCE
    );
    println!(
        "the same variant; an open or a shorted load has none. Instructions as QEMU executes them, which"
    );
    println!("are not cycles. Flash and stack in bytes, flash over an empty firmware.");
    Ok(())
}

fn report_bump_stop(core: Core, limit: Duration) -> Result<(), Error> {
    type Change = fn(&mut BumpStop, &mut Load);
    let same: Change = |_, _| {};
    let no_stop: Change = |model, _| model.stop = None;
    let one_way: Change = |model, _| model.parameters.coupling = Coupling::OneWay;
    let open: Change = |_, load| *load = Load::Resistor { resistance_ohm: f64::INFINITY };
    let mut variants = Variants { core, limit, whole: None, rows: Vec::new() };
    let mut add = |variant, binary, native, change: Change| {
        let scene = accuracy::bump_stop(&bump_stop::IMPACTING, GAP, 0.5, change)?;
        variants.add(variant, binary, native, Yardstick::rms_voltage(&scene)?)
    };
    use bump_stop as scenes;
    add("whole", "bump_stop", boxed(scenes::bench())?, same)?;
    add("without stop and rod", "bump_stop_without_stop", boxed(scenes::without_stop())?, no_stop)?;
    add("one-way coupling", "bump_stop_one_way", boxed(scenes::one_way())?, one_way)?;
    add("load open", "bump_stop_open", boxed(scenes::open())?, open)?;
    add("one length of step", "bump_stop_single_rate", boxed(scenes::single_rate())?, same)?;
    variants.print("variant");
    println!(
        "{core}. Bump-stop, four modes of the beam and one of the rod, 20 m/s2 at 220 Hz, a gap of 10 um, 2 s"
    );
    println!(
        "from rest; steps of {} us near contact and {} us in free flight. Error: of the RMS voltage from 0.5 s",
        scenes::SHORT * 1e6,
        scenes::LONG * 1e6
    );
    println!(
        "on, against the reference of the same variant with the same modes; the motion is weakly chaotic,"
    );
    println!("and a run of this length scatters by some per cent. Instructions as QEMU executes them, which");
    println!("are not cycles. Flash and stack in bytes, flash over an empty firmware.");
    Ok(())
}

/// The rows of a table.
struct Variants {
    core: Core,
    limit: Duration,
    /// Flash of the first one.
    whole: Option<u64>,
    rows: Vec<[String; 8]>,
}

impl Variants {
    /// Measures `binary`, whose workload the host has too.
    fn add(
        &mut self,
        name: &str,
        binary: &'static str,
        mut native: Box<dyn Workload>,
        yardstick: Yardstick,
    ) -> Result<(), Error> {
        let measurement = on_target::measure(self.core, Binary::new(binary), self.limit)?;
        native::compare_all(self.core, &measurement.workloads, &mut [&mut *native])?;
        let Some(workload) = measurement.workloads.first() else {
            return Err(Error::Other { core: self.core, what: format!("{binary} has no workload") });
        };
        let whole = workload.whole();
        let base = *self.whole.get_or_insert(measurement.flash);
        self.rows.push([
            name.to_owned(),
            measurement.flash.to_string(),
            format!("{:+}", measurement.flash.cast_signed() - base.cast_signed()),
            workload.stack.to_string(),
            whole.steps.to_string(),
            format!("{:.0}", whole.instructions_per_step()),
            format!("{:.0}", whole.instructions_per_second()),
            yardstick.error(workload),
        ]);
        Ok(())
    }

    fn print(self, first: &str) {
        let header = [
            first,
            "flash",
            "difference",
            "stack",
            "steps",
            "instructions per step",
            "per simulated second",
            "error",
        ];
        println!("{}", table(header, self.rows, 1));
    }
}

fn boxed(workload: Option<impl Workload + 'static>) -> Result<Box<dyn Workload>, Error> {
    native::accepted(workload).map(|workload| Box::new(workload) as _)
}

//! The log of the node on its simulated plant, beside the host's run of the same node.

use std::time::Duration;

use firmware_example::node::{Count, End, Entry, LOSSES, NoMeter, Part, World, cycle};

use super::build::Binary;
use super::image::Size;
use super::qemu::Core;
use super::{Error, Firmware, decode, qemu};

/// The processor of the node on `core`.
pub fn part(core: Core) -> Part {
    match core {
        Core::M0 | Core::M3 => Part::Stm32l051,
        Core::M4f | Core::M7 | Core::M33 => Part::Nrf52832,
    }
}

/// What a run of the node on the host came to.
#[derive(Debug, Clone)]
pub struct Native {
    /// The log.
    pub entries: Vec<Entry>,
    /// The world at the end of the day.
    pub world: World,
}

/// Runs the node of a day on the host, with the first so many of the losses of power.
///
/// # Errors
///
/// If the node cannot go on.
pub fn native(part: Part, losses: usize) -> Result<Native, Error> {
    let mut entries = Vec::new();
    let mut world = World::new(losses);
    loop {
        match cycle(part, &mut world, &NoMeter, &mut |entry| entries.push(*entry)) {
            Ok(End::PowerLost) => {}
            Ok(End::Day) => return Ok(Native { entries, world }),
            Err(reason) => return Err(Error::Host(format!("the node fails: {reason:?}"))),
        }
    }
}

/// Compares the log of a node that lost its power with that of one that did not: after each start the log repeats what
/// follows the image, and it ends as the other does. Gives the number of entries that were repeated.
///
/// # Errors
///
/// At the first difference, in words.
pub fn same_day(restarted: &[Entry], whole: &[Entry]) -> Result<usize, String> {
    let (mut next, mut repeated) = (0_usize, 0);
    for entry in restarted {
        if let Entry::Resumed { sequence: resumed, .. } = entry {
            let image = |entry: &Entry| matches!(entry, Entry::Image { sequence, .. } if sequence == resumed);
            let place = whole.iter().position(image).ok_or_else(|| format!("no image {resumed}"))?;
            repeated += next.saturating_sub(place + 1);
            next = place + 1;
            continue;
        }
        if whole.get(next) != Some(entry) {
            return Err(format!("after a loss of power: {entry}, without one: {:?}", whole.get(next)));
        }
        next += 1;
    }
    if next == whole.len() { Ok(repeated) } else { Err(format!("it ends at entry {next}")) }
}

/// Work of the node on a core.
#[derive(Debug, Clone, PartialEq)]
pub struct Counted {
    /// Its name in the log.
    pub work: String,
    /// Calls.
    pub calls: f64,
    /// Samples of the accelerometer that they took in.
    pub samples: f64,
    /// Instructions of all of them.
    pub instructions: f64,
}

/// A node that was followed through its day.
#[derive(Debug, Clone)]
pub struct Followed {
    /// The log without a loss of power.
    pub whole: Native,
    /// Losses of power on the core.
    pub losses: usize,
    /// What the node cost.
    pub counted: Vec<Counted>,
    /// Deepest stack in bytes.
    pub stack: u64,
    /// The whole firmware, with the simulated plant.
    pub size: Size,
    /// The same node on a board in place of the plant, and without a log: what a user would flash.
    pub bare: Bare,
}

/// The program of a node on a board, of one tier.
#[derive(Debug, Clone)]
pub struct Bare {
    /// Its size.
    pub size: Size,
    /// Its RAM.
    pub memory: Memory,
    /// Each kind of call that it makes.
    pub calls: Vec<Call>,
}

/// Calls of a kind.
#[derive(Debug, Clone)]
pub struct Call {
    /// Its name in the log.
    pub name: String,
    /// Calls, instructions in the mean and of the largest one, and stack in bytes.
    pub counts: [f64; 4],
}

/// A line "call NAME NUMBER TICKS LARGEST STACK".
fn call(line: &str, per_tick: f64) -> Option<Call> {
    let mut words = line.strip_prefix("call ")?.split(' ');
    let name = words.next()?.to_owned();
    let mut next = || words.next()?.parse::<f64>().ok();
    let [number, ticks, largest, stack] = [next()?, next()?, next()?, next()?];
    (number > 0.0)
        .then(|| Call { name, counts: [number, ticks * per_tick / number, largest * per_tick, stack] })
}

/// Builds the program of a node on a board for `core`, `by_voltage` alone or with bursts, and runs it on registers in memory for at
/// most `time_limit`.
///
/// # Errors
///
/// When it cannot be built or run.
pub fn bare(core: Core, by_voltage: bool, time_limit: Duration) -> Result<Bare, Error> {
    let of = |name| Binary { variant: by_voltage.then_some("voltage"), ..Binary::new(name) };
    let size = Firmware::build(core, of("node_bare"))?.check()?;
    let firmware = Firmware::build(core, of("node_stack"))?;
    let log = qemu::run(core, &firmware.path, time_limit)?;
    let lines = super::decode::messages(&firmware.path, &log).map_err(|error| Error::on(core, error))?;
    let count = |name: &str| {
        let found = lines.iter().find_map(|line| line.strip_prefix(name)?.parse::<u64>().ok());
        found.ok_or_else(|| Error::on(core, decode::Error::Incomplete))
    };
    let per_tick = core.hardware().instructions_per_tick();
    Ok(Bare {
        size,
        memory: Memory {
            stack: count("bytes stack ")?,
            state: count("bytes state ")?,
            image: count("bytes image ")?,
        },
        calls: lines.iter().filter_map(|line| call(line, per_tick)).collect(),
    })
}

/// RAM of a node on a board, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Memory {
    /// Deepest stack over some days, with all of the below.
    pub stack: u64,
    /// Its state.
    pub state: u64,
    /// The buffer of an image, only while the node resumes or saves.
    pub image: u64,
}

/// Runs the node on `core` for at most `time_limit`, with its losses of power, compares its log with the host's, and that one
/// with a day without losses.
///
/// # Errors
///
/// When the node cannot be built or run, or a log differs.
pub fn follow(core: Core, time_limit: Duration) -> Result<Followed, Error> {
    let firmware = Firmware::build(core, Binary::new("node"))?;
    let size = firmware.check()?;
    let bare = bare(core, false, time_limit)?;
    let log = qemu::run(core, &firmware.path, time_limit)?;
    let messages = super::decode::messages(&firmware.path, &log).map_err(|error| Error::on(core, error))?;
    let (counts, found): (Vec<_>, Vec<_>) =
        messages.into_iter().partition(|message| message.starts_with("count "));

    let expected = native(part(core), LOSSES.len())?;
    let lines: Vec<String> = expected.entries.iter().map(Entry::to_string).collect();
    decode::same(&found, &lines).map_err(|what| Error::on(core, what))?;
    let whole = native(part(core), 0)?;
    same_day(&expected.entries, &whole.entries).map_err(|what| Error::on(core, what))?;

    let per_tick = core.hardware().instructions_per_tick();
    let mut counted = counts
        .iter()
        .map(|line| count(line, per_tick).ok_or_else(|| Error::on(core, decode::Error::Record(line.clone()))))
        .collect::<Result<Vec<_>, _>>()?;
    let stack = counted.pop().ok_or_else(|| Error::on(core, decode::Error::Incomplete))?;
    let stack = (stack.instructions / per_tick).round() as u64;
    Ok(Followed { losses: expected.world.losses(), whole, counted, stack, size, bare })
}

/// A line "count WORK CALLS SAMPLES TICKS".
fn count(line: &str, per_tick: f64) -> Option<Counted> {
    let mut words = line.split(' ').skip(1);
    let work = words.next()?.to_owned();
    let mut number = || words.next()?.parse::<f64>().ok();
    Some(Counted { work, calls: number()?, samples: number()?, instructions: number()? * per_tick })
}

/// Calls of a kind in a day without losses of power.
pub fn calls(native: &Native, work: firmware_example::node::Work) -> Count {
    native.world.counts().get(work as usize).copied().unwrap_or_default()
}

//! Years of a node: nights, weekends, seasons, ageing, clock steps, power losses and updates.
//!
//! The income of an hour is one of a few that the full model gives, each computed once. A node is driven by `Runner`, with an image
//! after each hour that it reports.

mod quarter;

use harvester_scene::market::Processor;
use model_core::clock::Instant;
use model_core::excitation::{Excitation, Sine};
use model_core::node::{Board, Fault, Outage, Runner, Tier};
use model_core::scalar::{Mathematics, Polynomial};

use super::compared::Storage;
use super::harvester::{Kind, tone};
use super::plant::{GRAVITY, NOISE_COUNTS};
use super::settings::{CELL, CONVERTER_NOISE, Settings, UNIT};
use super::{Source, Tiered};
use crate::embedded::Deviation;
use crate::method::Failure;
use crate::run::each;
use quarter::Hours;
pub use quarter::{Quarter, Stress};

const HOUR: u64 = 3600;
const DAY: u64 = 24 * HOUR;
/// A quarter of a year in s.
const QUARTER: u64 = 365 * DAY / 4;
/// Amplitudes in m/s² and frequencies in Hz of the machine.
const MOTIONS: [[f64; 2]; 8] =
    [[0.6, 20.0], [0.8, 20.2], [1.0, 20.3], [1.2, 19.9], [1.5, 20.1], [1.8, 20.4], [2.2, 19.8], [0.5, 20.1]];
/// Leakage resistance times capacitance of a capacitor in s, and bytes of a slot of memory.
const LEAKING: f64 = 1e6;
const SLOT: usize = 2048;

/// What shakes a harvester for years, and what it gives in W.
struct Machine {
    sines: Vec<Sine<f64>>,
    powers: Vec<f64>,
}

impl Machine {
    /// The power of each motion in its second minute, of a harvester that is off.
    fn new() -> Result<Self, Failure> {
        let (mut sines, mut powers) = (Vec::new(), Vec::new());
        for [amplitude, hertz] in MOTIONS {
            let off = Deviation { charge: 0.95, damping: 1.2, ..Deviation::NONE };
            let minutes = Kind::ContactSeparation
                .minutes(&[tone(amplitude, hertz), tone(amplitude, hertz)], &|_| off)?;
            powers.push(minutes[1] / 60.0);
            sines.extend(Sine::new(amplitude, hertz, 0.3));
        }
        Ok(Self { sines, powers })
    }

    /// The motion at a second: still at night and at weekends; else one of all, which changes within the hour.
    fn motion(second: u64) -> Option<usize> {
        let (day, hour) = (second / DAY, second / HOUR);
        let works = day % 7 < 5 && (6..22).contains(&(hour % 24));
        works.then(|| {
            let mut random = Source::of_seed(hour);
            let changes = (60.0 * random.uniform(0.0, 1.0)) as u64 <= second / 60 % 60;
            let mut of = Source::of_seed(hour + u64::from(changes));
            (of.uniform(0.0, MOTIONS.len() as f64)) as usize % MOTIONS.len()
        })
    }
}

/// A node's hardware over years.
struct Site<'a> {
    machine: &'a Machine,
    stress: Stress,
    still_nights: bool,
    end: u64,
    /// In J: energies of a reading, a burst and an action; at the lock-out, the turn-on and the highest voltage. In W: asleep.
    costs: [f64; 3],
    levels: [f64; 3],
    standing: f64,
    /// Part of the energy that leaks in a second, and energy of a V².
    leaking: f64,
    half: f64,
    rate: f64,
    energy: f64,
    is_off: bool,
    /// True second, and the clock less that.
    second: u64,
    ahead: i64,
    income: f64,
    estimation: f64,
    /// Second of the last reading, and hours without one.
    read: u64,
    frozen: u32,
    random: Source,
    slots: [[u8; SLOT]; 2],
    /// Second of the start of a burst, and samples taken.
    burst: Option<(u64, u32)>,
}

impl<'a> Site<'a> {
    fn new(
        machine: &'a Machine,
        settings: &Settings,
        of_burst: f64,
        stress: Stress,
        still: bool,
        end: u64,
    ) -> Self {
        let parameters = settings.parameters();
        let storage = parameters.storage;
        let half = 0.5 * f64::from(storage.capacitor.capacitance);
        let levels = [storage.lock_out_voltage, storage.turn_on_voltage, storage.highest_voltage];
        Self {
            machine,
            stress,
            still_nights: still,
            end,
            costs: [parameters.reading.into(), of_burst, parameters.actions[0].energy.into()],
            levels: levels.map(|voltage| half * f64::from(voltage).powi(2)),
            standing: 1.1 * f64::from(parameters.standing_power),
            leaking: 1.0 / (half * f64::from(storage.capacitor.leakage_resistance)),
            half,
            rate: settings.rate(),
            energy: half * 9.0,
            is_off: false,
            second: 0,
            ahead: 0,
            income: 0.0,
            estimation: 0.0,
            read: 0,
            frozen: 0,
            random: Source::of_seed(7),
            slots: [[0xff; SLOT]; 2],
            burst: None,
        }
    }

    fn clock(&self) -> u32 {
        self.second.saturating_add_signed(self.ahead) as u32
    }

    /// Power of the harvester in W, and the leakage over that of the data sheet.
    fn conditions(&self) -> [f64; 2] {
        let year: f64 = Polynomial::sine_of_turns((self.second % (365 * DAY)) * (u64::MAX / (365 * DAY)));
        let power = Machine::motion(self.second).map_or(0.0, |motion| self.machine.powers[motion]);
        let part = self.second as f64 / self.end as f64;
        match self.stress {
            Stress::Temperature => [power * (1.0 - 0.1 * year), 1.0 + 0.6 * year],
            Stress::Ageing => [power * (1.0 - 0.2 * part), 1.0],
            _ => [power, 1.0],
        }
    }

    fn pass(&mut self, until: u64) {
        let was_off = self.is_off;
        while self.second < until && self.is_off == was_off {
            let seconds = (60 - self.second % 60).min(until - self.second) as f64;
            let [power, leakage] = self.conditions();
            let draw = if self.is_off { 0.0 } else { self.standing };
            self.energy += seconds * (power - draw - leakage * self.leaking * self.energy);
            self.energy = self.energy.min(self.levels[2]);
            self.income += seconds * power;
            self.second += seconds as u64;
            self.spend(0.0);
        }
    }

    fn turn_on(&mut self) {
        while self.energy < self.levels[1] && self.second < 2 * self.end {
            self.pass(self.second + 60);
        }
        self.is_off = false;
    }

    fn spend(&mut self, energy: f64) {
        self.energy -= energy;
        self.is_off |= self.energy <= self.levels[0];
    }
}

impl Board for Site<'_> {
    fn sleep(&mut self, seconds: u32, samples: u32) -> u32 {
        let until = match self.burst {
            Some((begin, taken)) => begin + (f64::from(taken + samples) / self.rate).ceil() as u64,
            None => u64::MAX,
        };
        self.pass((self.second + u64::from(seconds)).min(until));
        self.clock()
    }

    fn storage_code(&mut self) -> Option<u32> {
        self.spend(self.costs[0]);
        self.estimation += self.costs[0];
        self.frozen += ((self.second - self.read) / (2 * HOUR)) as u32;
        self.read = self.second;
        let noise = CONVERTER_NOISE * self.random.normal();
        let voltage = (self.energy / self.half).max(0.0).sqrt() + noise;
        (!self.is_off).then(|| (voltage / CELL).round().clamp(0.0, 4095.0) as u32)
    }

    fn start_sensor(&mut self) -> Result<(), Fault> {
        self.spend(self.costs[1]);
        self.estimation += self.costs[1];
        self.burst = Some((self.second, 0));
        Ok(())
    }

    fn stop_sensor(&mut self) {
        self.burst = None;
    }

    fn read_samples(&mut self, samples: &mut [i16]) -> Result<usize, Fault> {
        let (begin, taken) = self.burst.ok_or(Fault)?;
        let there = ((self.second - begin) as f64 * self.rate) as u32;
        let count = samples.len().min(there.saturating_sub(taken) as usize);
        let motion = Machine::motion(self.second);
        for (index, sample) in samples.iter_mut().enumerate().take(count) {
            let time = (begin % 60) as f64 + (f64::from(taken) + index as f64) / self.rate;
            let at = Instant::from_seconds(time).filter(|_| motion.is_some());
            let value = at.map_or(0.0, |at| self.machine.sines[motion.unwrap_or(0)].acceleration(at));
            let noise = if motion.is_none() && self.still_nights { 0.0 } else { self.random.normal() };
            *sample = ((value + GRAVITY) / UNIT + NOISE_COUNTS * noise).round() as i16;
        }
        self.burst = Some((begin, taken + count as u32));
        Ok(count)
    }

    fn run(&mut self, _: usize) {
        self.spend(self.costs[2]);
    }

    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.slots[slot][..bytes.len()]);
    }

    fn write_slot(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        self.slots[slot][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

/// What happens to a node: the gap after which it resumes, and whether it could not save before.
fn event<N: Tier>(
    runner: &mut Runner<'_, Site<'_>, N>,
    stress: Stress,
    events: &mut Source,
    buffer: &mut [u8],
) -> (Option<Outage>, bool)
where
    N::State: Copy,
{
    let kind = if stress == Stress::Updates { 0 } else { events.uniform(0.0, 4.0) as usize };
    if stress == Stress::Clock {
        runner.board_mut().ahead += events.uniform(-3600.0, 3600.0) as i64;
    }
    if !matches!(stress, Stress::Updates | Stress::PowerLoss) {
        return (None, false);
    }
    let refused = (stress == Stress::Updates || kind == 1) && runner.save(buffer).is_err();
    let site = runner.board_mut();
    if kind > 0 {
        let hours = events.uniform(1.0, 9.0);
        site.is_off = true;
        site.pass(site.second + (hours * 3600.0) as u64);
        site.turn_on();
    }
    let clock = site.clock();
    let gaps =
        [Outage::OnUntil(clock), Outage::OffUntil(clock), Outage::LockedOutUntil(clock), Outage::Unknown];
    (gaps.get(kind).copied(), refused)
}

/// The node anew on its board after a gap, and whether it found no image.
fn resumed<'n, 's, N: Tier>(
    runner: Runner<'n, Site<'s>, N>,
    node: &'n N,
    gap: Outage,
    buffer: &mut [u8],
) -> (Runner<'n, Site<'s>, N>, bool)
where
    N::State: Copy,
{
    let mut site = runner.into_board();
    // It was not on in the gap.
    (site.read, site.burst) = (site.second, None);
    let clock = site.clock();
    let mut runner = Runner::new(site, node, clock);
    let is_refused = runner.resume(buffer, gap).is_err();
    (runner, is_refused)
}

/// The quarters of a node that lives on a site, and at times as its next version.
fn live<N: Tier>(mut quarter: Quarter, nodes: &[Tiered<N>; 2], site: Site<'_>, scale: f64) -> Vec<Quarter>
where
    N::State: Copy,
{
    let (stress, end, mut quarters, mut buffer) = (site.stress, site.end, Vec::new(), [0; SLOT]);
    let mut events = Source::of_seed(11);
    // The version; income at the last reported hour, and income without an estimate; income and estimation at the start of the quarter.
    let (mut version, mut reported, mut unreported, mut begun) = (0, 0.0, 0.0, [0.0; 2]);
    let (mut last, mut hours, mut next) = (None, Hours::default(), 5 * DAY);
    let mut runner = Runner::new(site, &nodes[0].node, 0);
    while (quarters.len() as u64) < end / QUARTER && runner.board().second < 2 * end {
        runner.step();
        let (mut gap, now) = (None, runner.board().second);
        if runner.board().is_off {
            runner.board_mut().turn_on();
            gap = Some(Outage::LockedOutUntil(runner.board().clock()));
        } else if runner.is_idle() && now >= next {
            let every = if stress == Stress::Updates { 30 * DAY } else { 5 * DAY };
            next = now + every + events.uniform(0.0, 0.4 * every as f64) as u64;
            version = if stress == Stress::Updates { 1 - version } else { version };
            let (happened, refused) = event(&mut runner, stress, &mut events, &mut buffer);
            (gap, quarter.refused_images) = (happened, quarter.refused_images + u32::from(refused));
        }
        if let Some(gap) = gap {
            if gap == Outage::Unknown {
                unreported += runner.board().income - reported;
                reported = runner.board().income;
            }
            let is_refused;
            (runner, is_refused) = resumed(runner, &nodes[version].node, gap, &mut buffer);
            quarter.refused_images += u32::from(is_refused && last.is_some());
        }
        let hour = (nodes[version].hour)(runner.state());
        if !runner.is_idle() || hour == last {
            continue;
        }
        last = hour;
        let Site { income, estimation, frozen, .. } = *runner.board();
        if let Some(hour) = hour {
            quarter.count(hour, income - reported, &mut hours);
        }
        reported = income;
        quarter.refused_images += u32::from(runner.save(&mut buffer).is_err());
        if now >= u64::from(quarter.quarter) * QUARTER {
            let sum = (nodes[version].overall)(&nodes[version].node, runner.state());
            quarters.push(Quarter {
                sum_estimated_j: scale * f64::from(sum.energy),
                sum_bound_j: scale * f64::from(sum.bound),
                sum_true_j: scale * (income - unreported),
                share: (estimation - begun[1]) / (income - begun[0]),
                frozen_hours: frozen,
                ..hours.close(quarter)
            });
            (begun, runner.board_mut().frozen) = ([income, estimation], 0);
            quarter = quarter.next();
        }
    }
    quarters
}

/// The whole quarters of both tiers on some storages over so many days. Hours of the same numbers in turn count once.
///
/// # Errors
/// If a shipped scene cannot be read or stepped.
pub fn years(days: u32, storages: &[Storage]) -> Result<Vec<Quarter>, Failure> {
    let machine = Machine::new()?;
    let motions = (0..7 * 1440).filter_map(|minute| Machine::motion(60 * minute));
    let minute = motions.map(|motion| machine.powers[motion]).sum::<f64>() / (7.0 * 24.0);
    let mut cases = Vec::new();
    for &storage in storages {
        for still in [false, true] {
            for stress in Stress::ALL {
                cases.extend(["voltage", "map"].map(|tier| (storage, still, stress, tier)));
            }
        }
    }
    let of_case = |&(of, still_nights, stress, tier): &(Storage, bool, Stress, &'static str)| {
        let Storage { name: storage, capacitance: capacitance_f, leakage, .. } = of;
        let leakage = if leakage.is_finite() { leakage } else { LEAKING / capacitance_f };
        let base = Settings::new(
            Kind::ContactSeparation,
            Processor::named("nrf52832").expect("a part"),
            capacitance_f,
            0.1,
        );
        let base = Settings { leakage, gain: 0.3, ..base }.scaled(&[minute]);
        let [action, standing, reserve] = [1.01 * base.action, 0.99 * base.standing, 0.99 * base.reserve];
        let next = Settings { action, standing, reserve, ..base };
        let quarter =
            Quarter { tier, storage, capacitance_f, still_nights, stress, quarter: 1, ..Quarter::default() };
        let nodes = [base.map(), next.map()];
        let of_burst = f64::from(nodes[0].node.parameters().bursts.energy);
        let site = Site::new(&machine, &base, of_burst, stress, still_nights, u64::from(days) * DAY);
        if tier == "map" {
            live(quarter, &nodes, site, base.scale)
        } else {
            live(quarter, &[base.voltage(), next.voltage()], site, base.scale)
        }
    };
    let quarters = each(&cases, of_case);
    Ok(quarters.concat())
}

//! The node on a tank whose energy is counted in double precision, second by second.

use super::*;
use crate::energy::{Capacitor, StorageParameters};
use crate::node::{Board, Converter, Fault, Runner, TaskLedger, Thresholds, TickClock};
use core::num::NonZero;

pub(super) const STATED: VoltageParameters<2> = VoltageParameters {
    storage: StorageParameters {
        capacitor: Capacitor { capacitance: 10e-3, leakage_resistance: 10e6 },
        charging_efficiency: 0.8,
        discharging_efficiency: 0.9,
        highest_voltage: 4.5,
        lock_out_voltage: 1.8,
        turn_on_voltage: 2.2,
    },
    converter: Converter { bits: 12, full_scale: 5.0, noise: 0.6e-3 },
    standing_power: 1e-6,
    reading: 0.3e-6,
    intervals: [60, 300],
    tolerances: Tolerances::EXACT,
    largest_power: 100e-6,
    reserve: 40e-3,
    actions: [Regular { energy: 300e-6, every: 60 }, Regular { energy: 3e-3, every: 600 }],
};
/// In flash.
static NODE: VoltageNode<2> = node(STATED);

const fn node(parameters: VoltageParameters<2>) -> VoltageNode<2> {
    match parameters.build() {
        Ok(node) => node,
        Err(_) => panic!("within bounds"),
    }
}

/// Without actions that it could afford.
static IDLE: VoltageNode<2> =
    node(VoltageParameters { actions: [Regular { energy: 1.0, every: 60 }; 2], ..STATED });

/// How the tank differs from what is stated.
#[derive(Clone, Copy)]
struct Off {
    capacitance: f64,
    leakage: f64,
    standing: f64,
    action: f64,
    charging: f64,
    reference: f64,
}

/// Before anything is known.
const FIRST: Wake = Wake { task: Task::Sleep, again_in: 0, read: true };
const NOT: Off =
    Off { capacitance: 1.0, leakage: 1.0, standing: 1.0, action: 1.0, charging: 1.0, reference: 1.0 };

#[derive(Clone)]
struct Tank {
    off: Off,
    /// Income in W by the second.
    income: fn(u32) -> f64,
    second: u32,
    energy: f64,
    harvested: f64,
    shunted: f64,
    random: u64,
    ran: [u32; 2],
    /// Hours in all and inside their bounds; the sum of bounds over the truth.
    hours: [u32; 2],
    silent: u32,
    begun: f64,
    wake: Wake,
    /// Whether actions are entered in the ledger, as done or failed.
    enters: Option<bool>,
    ledger: TaskLedger<2>,
    learnt: LearntCapacitance,
    /// Sum of the bounds of the hours after the first day in J.
    bounds: f64,
}

/// Normal with the variance 1, as the sum of twelve even numbers.
pub(in crate::node) fn normal(random: &mut u64) -> f64 {
    let mut normal = -6.0;
    for _ in 0..12 {
        *random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        normal += (*random >> 11) as f64 / (1_u64 << 53) as f64;
    }
    normal
}

impl Tank {
    fn new(off: Off, income: fn(u32) -> f64) -> Self {
        let energy = 0.5 * 10e-3 * off.capacitance * 9.0;
        let (ran, hours) = ([0; 2], [0; 2]);
        Self {
            off,
            income,
            second: 0,
            energy,
            harvested: 0.0,
            shunted: 0.0,
            random: 7,
            ran,
            hours,
            silent: 0,
            begun: 0.0,
            wake: FIRST,
            enters: None,
            ledger: TaskLedger::EMPTY,
            learnt: LearntCapacitance::new(&VoltageParameters {
                tolerances: Tolerances { capacitance: 0.115, ..Tolerances::EXACT },
                ..STATED
            }),
            bounds: 0.0,
        }
    }

    fn code(&mut self) -> u32 {
        let normal = normal(&mut self.random);
        let voltage = (self.energy * 200.0 / self.off.capacitance).sqrt() * self.off.reference;
        ((voltage + 0.6e-3 * normal) / 5.0 * 4096.0).round() as u32
    }

    fn live(&mut self, seconds: u32, is_on: bool) {
        let full = 0.5 * 10e-3 * self.off.capacitance * 4.5 * 4.5;
        for _ in 0..seconds {
            let income = (self.income)(self.second);
            let voltage_squared = self.energy * 200.0 / self.off.capacitance;
            let standing = if is_on { 1e-6 * self.off.standing / 0.9 } else { 0.0 };
            self.energy +=
                0.8 * self.off.charging * income - standing - voltage_squared * self.off.leakage / 10e6;
            self.shunted += (self.energy - full).max(0.0);
            self.energy = self.energy.min(full);
            self.harvested += income;
            self.second += 1;
        }
    }

    /// Runs the node up to a second, and until it is idle.
    fn run(&mut self, node: &VoltageNode<2>, state: &mut VoltageState<2>, until: u32) {
        let mut last = state.last_hour();
        while self.second < until || self.wake.task != Task::Sleep {
            let (readings, mut code, mut ran) = (state.readings(), None, None);
            match self.wake.task {
                Task::Run(index) => {
                    let (energy, before) = ([300e-6, 3e-3][index], self.code());
                    self.energy -= energy * self.off.action / 0.9;
                    let (energy, codes) = (energy as f32, [before, self.code()]);
                    self.learnt.learn(&STATED, [energy, 0.01 * energy], 0.0, [0.0; 2], codes);
                    self.ran[index] += 1;
                    ran = self.enters.map(|has_failed| (index, has_failed));
                }
                _ => {
                    self.live(self.wake.again_in, true);
                    code = self.wake.read.then(|| self.code());
                }
            }
            self.wake = node.wake(state, self.second, code);
            self.energy -= f64::from(state.readings() - readings) * 0.3e-6 / 0.9;
            if let Some((index, has_failed)) = ran {
                let used = [300e-6, 3e-3][index] * self.off.action;
                self.ledger.enter(node, state, index, used as f32, has_failed).expect("within bounds");
            }
            self.ledger.watch(node, state);
            assert!(self.energy > 0.5 * 10e-3 * self.off.capacitance * 1.8 * 1.8, "{} s", self.second);
            if state.last_hour() != last {
                last = state.last_hour();
                self.judge(last.expect("an hour"));
            }
        }
    }

    fn judge(&mut self, hour: IncomeOfTime) {
        let truth = self.harvested - self.begun;
        self.begun = self.harvested;
        let is_inside = (f64::from(hour.energy) - truth).abs() <= f64::from(hour.bound);
        self.hours = [self.hours[0] + 1, self.hours[1] + u32::from(is_inside)];
        self.silent += u32::from(hour.silent > 0);
        self.bounds += if self.second > 90_000 { f64::from(hour.bound) } else { 0.0 };
    }
}

/// By day 9 to 15 µW from hour to hour, by night nothing.
fn day(second: u32) -> f64 {
    if second / 3600 % 24 < 20 { 9e-6 + 2e-6 * f64::from(second / 3600 % 4) } else { 0.0 }
}

#[test]
fn the_hours_and_the_sum_of_thirty_days_are_inside_their_bounds_whatever_part_is_off() {
    let exact = Tolerances::EXACT;
    for (off, tolerances) in [
        // Entered as done for more, and as failed for less.
        (Off { action: 1.2, ..NOT }, exact),
        (Off { action: 0.4, ..NOT }, exact),
        (NOT, exact),
        (Off { standing: 1.2, ..NOT }, Tolerances { standing: 0.12, ..exact }),
        (Off { standing: 0.8, ..NOT }, Tolerances { standing: 0.12, ..exact }),
        (Off { action: 1.05, ..NOT }, Tolerances { action: 0.03, ..exact }),
        (Off { capacitance: 0.8, ..NOT }, Tolerances { capacitance: 0.115, ..exact }),
        (Off { capacitance: 1.2, ..NOT }, Tolerances { capacitance: 0.115, ..exact }),
        (Off { charging: 0.9, ..NOT }, Tolerances { charging: 0.06, ..exact }),
        (Off { leakage: 2.0, ..NOT }, Tolerances { leakage: 0.6, ..exact }),
        (Off { reference: 1.02, ..NOT }, Tolerances { reference: 0.012, ..exact }),
    ] {
        let node = node(VoltageParameters { tolerances, ..STATED });
        let enters = (tolerances == exact && off.action != 1.0).then_some(off.action < 1.0);
        let mut tank = Tank { enters, ..Tank::new(off, day) };
        let mut state = node.start(0);
        tank.run(&node, &mut state, 5 * 86_400);
        let first = node.overall(&state);
        tank.run(&node, &mut state, 30 * 86_400);
        let sum = node.overall(&state);
        let error = (f64::from(sum.energy) - tank.harvested).abs();
        assert!(error <= f64::from(sum.bound), "{sum:?} {} {tolerances:?}", tank.harvested);
        let [hours, inside] = tank.hours;
        assert!(
            hours > 700 && f64::from(inside) >= 0.97 * f64::from(hours),
            "{inside} of {hours}, {tolerances:?}"
        );
        // What is wrong with a part stays wrong: the bound does not average it out.
        let relative = |income: IncomeOfTime| income.bound / income.energy;
        let Tolerances { standing, action, charging, leakage, .. } = tolerances;
        let is_lasting = standing + action + charging + leakage > 0.0;
        let status = node.status(&state);
        assert!(status.power_bound >= 0.999 * BOUND * charging * status.power, "{status:?}");
        assert!(!is_lasting || relative(sum) > 0.9 * relative(first), "{first:?} {sum:?}");
        // The actions are what the income pays for, and leave the reserve.
        assert!(tank.ran[0] > 15_000, "{:?}", tank.ran);
        for (index, task) in tank.ledger.tasks.iter().enumerate().filter(|_| enters.is_some()) {
            let counts = [tank.ran[index], 0];
            assert_eq!(
                enters.map(|_| [task.done, task.failed]),
                enters.map(|failed| if failed { [0, counts[0]] } else { counts })
            );
            let used = f64::from(tank.ran[index]) * [300e-6, 3e-3][index] * off.action;
            assert!((f64::from(task.energy) - used).abs() < 1e-6 * used, "{task:?} {used}");
        }
    }
}

#[test]
fn a_node_with_the_learnt_capacitance_has_the_smaller_bound_and_goes_on() {
    for capacitance in [0.8, 1.2] {
        let tolerances = Tolerances { capacitance: 0.115, action: 0.01, ..Tolerances::EXACT };
        let stated = VoltageParameters { tolerances, ..STATED };
        let mut tank = Tank::new(Off { capacitance, action: 1.01, ..NOT }, day);
        let (before, mut state) = (node(stated), node(stated).start(0));
        tank.run(&before, &mut state, 86_400 + 1800);
        let learnt = tank.learnt.parameters(stated);
        let [found, off] = [learnt.storage.capacitor.capacitance, learnt.tolerances.capacitance];
        assert!(
            (f64::from(found) / (10e-3 * capacitance) - 1.0).abs() < 0.03 && off < 0.012,
            "{found} {off}"
        );
        let (after, code) = (node(learnt), tank.code());
        // The same hours, by both.
        let mut other = (tank.clone(), state);
        tank.wake = after.wake_after(&mut state, Outage::Unknown, Some(code));
        tank.run(&after, &mut state, 3 * 86_400);
        other.0.run(&before, &mut other.1, 3 * 86_400);
        assert!(tank.hours[0] > 70 && tank.hours[1] + 1 >= tank.hours[0], "{:?}", tank.hours);
        let sum = after.overall(&state);
        assert!((f64::from(sum.energy) - tank.harvested).abs() <= f64::from(sum.bound), "{sum:?}");
        assert!(tank.bounds < 0.6 * other.0.bounds, "{} {}", tank.bounds, other.0.bounds);
    }
}

/// A storage at 3 V, and its second.
struct Steady(u32);

impl Board for Steady {
    fn sleep(&mut self, seconds: u32, _: u32) -> u32 {
        self.0 += seconds;
        self.0
    }
    fn storage_code(&mut self) -> Option<u32> {
        Some(2458)
    }
    fn run(&mut self, _: usize) {}
    fn read_slot(&mut self, _: usize, _: &mut [u8]) {}
    fn write_slot(&mut self, _: usize, _: &[u8]) -> Result<(), Fault> {
        Ok(())
    }
}

#[test]
fn a_runner_goes_on_with_another_capacitance_and_no_income_from_it() {
    let mut half = *IDLE.parameters();
    half.storage.capacitor = Capacitor { capacitance: 5e-3, leakage_resistance: 10e6 };
    let (half, mut runner) = (node(half), Runner::new(Steady(0), &IDLE, 0));
    while runner.board().0 < 8000 {
        runner.step();
    }
    let (before, stored) = (IDLE.overall(runner.state()), IDLE.status(runner.state()).energy);
    let mut runner = runner.with_node(&half);
    let (after, of_half) = (half.overall(runner.state()), half.status(runner.state()).energy);
    assert!((after.energy - before.energy).abs() < 1e-6 && before.energy > 5e-3, "{after:?} {before:?}");
    assert!((of_half / stored - 0.5).abs() < 0.01, "{of_half} {stored}");
    let hour = runner.state().last_hour();
    while runner.state().last_hour() == hour {
        runner.step();
    }
    // 1.11 µW of the standing power and 0.9 µW of the leakage, of which four fifths of the income are stored.
    let hour = runner.state().last_hour().expect("an hour");
    assert!((hour.energy - 9.05e-3).abs() < 1.5e-3, "{hour:?}");
}

#[test]
fn the_whole_error_of_an_hour_is_that_of_its_readings() {
    // 24 µJ a reading by noise and cell at 3 V: two of them of 29 mJ.
    let mut tank = Tank::new(NOT, |_| 10e-6);
    let mut state = NODE.start(0);
    tank.run(&NODE, &mut state, 20 * 3600);
    let hour = state.last_hour().expect("an hour");
    assert!(hour.bound < 2.5 * 1.5 * 24e-6 / 0.8 && hour.bound > 5e-6, "{hour:?}");
    assert!(tank.hours[0] == 19 && tank.hours[1] >= 18, "{:?}", tank.hours);
    tank.run(&NODE, &mut state, 20 * 3600 + 130);
    let now = NODE.status(&state);
    assert!((now.power - 10e-6).abs() < now.power_bound && now.power_bound < 0.6e-6, "{now:?}");
    let stored = tank.energy - 8e-6 * f64::from(now.energy_age);
    assert!(now.source == PowerSource::Voltage && now.power_age == now.energy_age && now.energy_age > 60);
    assert!((f64::from(now.energy) - stored).abs() < 0.1e-3 && (5e-6..0.1e-3).contains(&now.energy_bound));
    assert!((f64::from(now.voltage) - (200.0 * stored).sqrt()).abs() < 3e-3, "{now:?}");
    let charge = (stored - 5e-3 * 1.8 * 1.8) / (5e-3 * (4.5 * 4.5 - 1.8 * 1.8));
    assert!((f64::from(now.charge) - charge).abs() < 3e-3 && (now.room - 0.085).abs() < 0.1e-3, "{now:?}");
    // Before the first reading nothing is affordable.
    let mut cold = NODE.start(0);
    let affordable = |state: &_, index| NODE.action(state, index).map(|action| action.is_affordable);
    let Status { source, power_bound, energy_bound, .. } = NODE.status(&cold);
    assert_eq!((source, power_bound, energy_bound), (PowerSource::Unknown, 100e-6, f32::INFINITY));
    assert_eq!([affordable(&cold, 1), affordable(&cold, 2)], [Some(false), None]);
    NODE.wake(&mut cold, 0, Some(2949));
    assert!(affordable(&cold, 1) == Some(true) && NODE.status(&cold).energy_bound < 0.1e-3);
}

#[test]
fn a_full_storage_is_silent_and_its_bound_has_what_is_shunted() {
    let mut tank = Tank::new(NOT, |second| if second < 20_000 { 20e-6 } else { 40e-6 });
    let mut state = IDLE.start(0);
    tank.run(&IDLE, &mut state, 12 * 3600);
    assert_eq!(state.last_reading(), Some(StoreReading::Silent));
    assert!(tank.shunted > 0.3 && tank.silent >= 8, "{} {}", tank.shunted, tank.silent);
    assert_eq!(tank.hours[0], tank.hours[1]);
    let now = IDLE.status(&state);
    assert!(
        now.source == PowerSource::Assumed
            && now.charge > 0.99
            && (now.power - 40e-6).abs() < now.power_bound
    );
    // An action of 1 J each minute is refused each minute.
    for task in tank.ledger.tasks {
        assert_eq!([task.refused, task.done, task.failed], [tank.second / 60, 0, 0]);
    }
    let mut refused =
        |index, used| tank.ledger.enter(&IDLE, &mut state, index, used, true).expect_err("bad").field;
    assert_eq!([refused(2, 0.0), refused(0, -1.0), refused(1, f32::NAN)], ["index", "used", "used"]);
    let sum = IDLE.overall(&state);
    assert!(
        (f64::from(sum.energy) - tank.harvested).abs() <= f64::from(sum.bound),
        "{sum:?} {}",
        tank.harvested
    );
}

#[test]
fn the_income_of_a_gap_is_inside_its_bound() {
    for (gap, is_on) in [
        (Outage::OnUntil as fn(u32) -> Outage, true),
        (Outage::OffUntil, false),
        (Outage::LockedOutUntil, false),
        (|_| Outage::Unknown, false),
    ] {
        let mut tank = Tank::new(NOT, day);
        let mut state = NODE.start(0);
        tank.run(&NODE, &mut state, 6 * 3600 + 1000);
        let image = state;
        if gap(0) != Outage::OffUntil(0) {
            // What is done after the image is lost.
            tank.run(&NODE, &mut state, 6 * 3600 + 2800);
        }
        let begun = tank.harvested;
        tank.live(3000, is_on);
        state = image;
        let before = NODE.overall(&state);
        let code = tank.code();
        tank.wake = NODE.wake_after(&mut state, gap(tank.second), Some(code));
        let clock = tank.second - state.second;
        assert_eq!(clock, if gap(0) == Outage::Unknown { tank.second - image.second } else { 0 });
        let after = NODE.overall(&state);
        // Of the gap that no clock knows nothing is said.
        let truth = if clock > 0 {
            0.0
        } else {
            tank.harvested - begun + f64::from(after.seconds - before.seconds - 3000) * day(22_600)
        };
        let (income, bound) = (f64::from(after.energy - before.energy), f64::from(after.bound));
        assert!((income - truth).abs() <= bound && bound < 0.5, "{:?}: {income} {truth} {bound}", gap(1));
        tank.second -= clock;
        tank.begun = tank.harvested;
        let first = state.last_hour();
        while state.last_hour() == first {
            tank.run(&NODE, &mut state, tank.second + 60);
        }
        let hours = tank.hours;
        tank.run(&NODE, &mut state, tank.second + 4 * 3600);
        assert_eq!(tank.hours[1] - hours[1], tank.hours[0] - hours[0], "{:?}", gap(1));
    }
}

#[test]
fn a_clock_that_goes_back_does_not_stop_the_node() {
    let mut tank = Tank::new(NOT, |_| 10e-6);
    let mut state = NODE.start(50_000);
    tank.second = 50_000;
    tank.run(&NODE, &mut state, 50_000 + 4 * 3600 + 100);
    let (hours, ran) = (tank.hours, tank.ran);
    tank.second -= 40_000;
    tank.run(&NODE, &mut state, 10_000 + 4 * 3600 + 8000);
    // Of the interval in which the clock was set nothing is said.
    assert!(tank.hours[0] > hours[0] && tank.hours[1] + 1 >= tank.hours[0], "{:?}", tank.hours);
    assert!(tank.ran[0] > ran[0] + 20);
}

#[test]
fn a_glitch_is_refused_and_a_lasting_change_is_taken_after_a_second_reading() {
    let mut tank = Tank::new(NOT, |_| 10e-6);
    let mut state = IDLE.start(0);
    tank.run(&IDLE, &mut state, 4000);
    let stored = state.energy();
    for code in [0, 3300, 4095, 1700] {
        let mut glitched = state;
        let wake = IDLE.wake(&mut glitched, tank.second + 1, Some(code));
        assert_eq!(glitched.last_reading(), Some(StoreReading::Refused), "{code}");
        assert!((glitched.energy() - stored).abs() < 1e-3);
        if code > 0 {
            assert_eq!(wake, Wake { task: Task::Sleep, again_in: 1, read: true });
            let mut changed = glitched;
            IDLE.wake(&mut changed, tank.second + 2, Some(code));
            assert!((changed.energy() - IDLE.element.per_code * (code * code) as f32).abs() < 4e-3, "{code}");
        }
        let right = tank.code();
        IDLE.wake(&mut glitched, tank.second + 2, Some(right));
        assert!((glitched.energy() - stored).abs() < 1e-3, "{code}");
    }
    // A converter that does not answer is asked as often as one that does, and each attempt is booked.
    let (readings, mut second) = (state.readings(), tank.second);
    while second < tank.second + 40 * 3600 {
        second += IDLE.wake(&mut state, second, None).again_in;
    }
    assert!((470..490).contains(&(state.readings() - readings)), "{state:?}");
    assert_eq!(state.last_reading(), Some(StoreReading::Refused));
}

#[test]
fn a_cold_start_ends_in_a_verdict_and_lasts_as_long_as_it_says() {
    let [weak, strong]: [fn(u32) -> f64; 2] = [|_| 1e-6, |_| 12e-6];
    for (income, expected) in [(weak, Verdict::Fades), (strong, Verdict::LivesOn)] {
        let mut tank = Tank { energy: 5e-3 * 2.2 * 2.2, ..Tank::new(NOT, income) };
        let mut state = IDLE.start(0);
        assert_eq!((IDLE.status(&state).verdict, IDLE.status(&state).endurance), (Verdict::Open, 0.0));
        let code = tank.code();
        tank.wake = IDLE.wake(&mut state, 0, Some(code));
        let first = IDLE.status(&state);
        tank.run(&IDLE, &mut state, 1);
        assert_eq!([first.verdict, IDLE.status(&state).verdict], [Verdict::Open, expected]);
        // 8 mJ above the lock-out, of which 1.6 µW leave at first and 1.4 µW at last.
        let mut dark = Tank { energy: 5e-3 * 2.2 * 2.2, ..Tank::new(NOT, |_| 0.0) };
        dark.live(first.endurance as u32, true);
        assert!(dark.energy > 5e-3 * 1.8 * 1.8 && first.endurance > 4500.0, "{first:?}");
        dark.live(first.endurance as u32 / 8, true);
        assert!(dark.energy < 5e-3 * 1.8 * 1.8, "{first:?}");
    }
}

#[test]
fn a_mode_holds_between_its_thresholds_and_is_the_lowest_without_a_known_energy() {
    let (mut modes, first) = (Thresholds::new([[0.1, 0.2], [0.5, 0.6]]), IDLE.status(&IDLE.start(0)));
    let mut at = |charge, energy_bound| modes.mode(&Status { charge, energy_bound, ..first });
    let found = [0.15, 0.25, 0.15, 0.05, 0.9, 0.55, 0.45, 0.05, 0.7].map(|charge| at(charge, 0.0));
    assert_eq!((found, at(0.9, f32::INFINITY)), ([0, 1, 1, 0, 2, 2, 1, 0, 2], 0));
}

#[test]
fn a_wake_is_due_at_the_first_tick_of_its_second() {
    let (clock, wake) =
        (TickClock(NonZero::<u64>::MIN.saturating_add(32_767)), Wake { again_in: 300, ..FIRST });
    let due = clock.due(7, &wake);
    let seconds = [due - 1, due, due + 32_767, u64::MAX].map(|tick| clock.second(tick));
    assert_eq!(seconds, [306, 307, 307, u32::MAX]);
    assert_eq!(clock.due(u32::MAX, &wake), 32_768 * u64::from(u32::MAX));
}

#[test]
fn an_image_with_the_largest_count_of_readings_in_turn_closes_its_hour() {
    let mut tank = Tank::new(NOT, |_| 10e-6);
    let mut state = IDLE.start(0);
    tank.run(&IDLE, &mut state, 24 * 3600 - 200);
    for hour in 24..48 {
        tank.run(&IDLE, &mut state, hour * 3600 - 200);
        state.repeated = u32::MAX;
        tank.run(&IDLE, &mut state, hour * 3600 + 200);
        assert_eq!(state.repeated, 0);
    }
}

#[test]
fn a_code_is_that_of_the_nearest_voltage() {
    for bits in [4, 12, 16] {
        let (converter, codes) = (Converter { bits, full_scale: 3.3, noise: 0.0 }, 1_u32 << bits);
        for code in 0..codes {
            let near = [-0.45, 0.45].map(|off| 3.3 * (f64::from(code) + off) / f64::from(codes));
            assert_eq!(near.map(|voltage| converter.code(voltage as f32)), [code; 2]);
        }
        assert_eq!([-1.0, f32::NAN, 1e9].map(|voltage| converter.code(voltage)), [0, 0, codes - 1]);
    }
}

#[test]
fn parameters_are_refused_by_name_and_images_of_other_storages_too() {
    let refused = |change: fn(&mut VoltageParameters<2>)| {
        let mut parameters = STATED;
        change(&mut parameters);
        parameters.build().expect_err("out of bounds").field
    };
    assert_eq!(refused(|p| p.storage.capacitor.capacitance = f32::NAN), "capacitance");
    assert_eq!(refused(|p| p.storage.lock_out_voltage = 4.6), "lock_out_voltage");
    assert_eq!(refused(|p| p.converter.bits = 17), "bits");
    assert_eq!(refused(|p| p.intervals = [60, 30]), "intervals.1");
    assert_eq!(refused(|p| p.tolerances.capacitance = 0.31), "tolerances.capacitance");
    assert_eq!(refused(|p| p.actions[1].every = 0), "actions.1.every");
    // What was learnt survives an update of anything but the storage and its converter.
    let identity = |parameters: VoltageParameters<2>| {
        let mut fingerprint = Fingerprint::new();
        node(parameters).identify(&mut fingerprint);
        fingerprint.value()
    };
    let same = identity(STATED);
    let tolerances = Tolerances { standing: 0.1, ..Tolerances::EXACT };
    for updated in [
        VoltageParameters { standing_power: 1.01e-6, reading: 0.303e-6, reserve: 40.4e-3, ..STATED },
        VoltageParameters { intervals: [61, 303], tolerances, largest_power: 101e-6, ..STATED },
        VoltageParameters { actions: [Regular { energy: 303e-6, every: 61 }; 2], ..STATED },
    ] {
        assert_eq!(identity(updated), same);
    }
    let converter = Converter { full_scale: 5.05, ..STATED.converter };
    assert_ne!(identity(VoltageParameters { converter, ..STATED }), same);
}

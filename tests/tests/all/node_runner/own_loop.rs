//! A node that a firmware drives by its own loop, without `Runner`: each kind of power loss, by an image and by a state in RAM that
//! survived.

use super::power_downs::dear_node;
use super::*;
use model_core::node::{Progress, Task, Wake};
use model_core::snapshot::{Image, newest_image, read_image, save_image};

/// A firmware's own loop.
struct Firmware {
    node: &'static OneNode,
    board: Bench,
    state: OneState,
    wake: Wake,
    is_sampling: bool,
}

impl Firmware {
    fn new(mut board: Bench) -> Self {
        let node = dear_node();
        let mut state = node.start(board.second);
        let wake = node.wake(&mut state, board.second, board.storage_code());
        Self { node, board, state, wake, is_sampling: false }
    }

    fn step(&mut self) {
        let Self { node, board, state, wake, is_sampling } = self;
        match wake.task {
            Task::Run(action) => {
                board.run(action);
                *wake = node.wake(state, OneNode::second(state), None);
            }
            Task::Sleep => {
                let now = board.sleep(wake.again_in, 0);
                let code = wake.read.then(|| board.storage_code()).flatten();
                *wake = node.wake(state, now, code);
            }
            Task::Burst { samples } => {
                if !*is_sampling {
                    board.start_sensor().expect("it works");
                    *is_sampling = true;
                }
                let now = board.sleep(wake.again_in, samples.min(100));
                let mut buffer = [0; 100];
                let count = board.read_samples(&mut buffer).expect("it works");
                let (mut missing, mut left) = (samples, &buffer[..count]);
                while !left.is_empty()
                    && let Progress::More(samples) = node.samples(state, left)
                {
                    left = &left[(missing - samples) as usize..];
                    (missing, wake.task) = (samples, Task::Burst { samples });
                }
                if !left.is_empty() {
                    // It has enough.
                    board.stop_sensor();
                    *is_sampling = false;
                    *wake = node.wake(state, now, None);
                }
            }
        }
    }

    /// A wait of no time is a part of the evaluation of a burst.
    fn is_idle(&self) -> bool {
        self.wake.task == Task::Sleep && self.wake.again_in > 0
    }

    fn run_until(&mut self, second: u32) {
        while self.board.second < second || !self.is_idle() {
            self.step();
        }
    }

    /// After a reset the sensor is off, and the node goes on from its state.
    fn resume(&mut self, gap: Outage) {
        self.board.stop_sensor();
        self.is_sampling = false;
        let code = self.board.storage_code();
        self.wake = self.node.wake_after(&mut self.state, gap, code);
    }

    /// Runs for three hours, of which each is inside its bound.
    fn assert_hours_inside(&mut self) {
        let (end, mut last, mut hours) = (self.board.second + 3 * 3600, self.state.last_hour(), 0);
        while self.board.second < end {
            self.step();
            if self.state.last_hour() != last {
                last = self.state.last_hour();
                let hour = last.expect("an hour");
                assert_inside(hour);
                assert!(hours == 0 || hour.bound < 0.3 * hour.energy, "{hour:?}");
                hours += 1;
            }
        }
        assert!(hours >= 2);
    }
}

/// A kind of power loss: what happens to the board in it, and the gap that the firmware states.
type Loss = (&'static str, fn(&mut Bench), fn(u32) -> Outage);

fn losses() -> [Loss; 4] {
    [
        ("a reset", |_| (), Outage::OnUntil),
        ("off", |board| board.pass(900, POWER * 0.9), Outage::OffUntil),
        ("locked out", |board| board.pass(900, STORED), Outage::LockedOutUntil),
        ("no clock", |board| board.charge(POWER * 0.9, 900), |_| Outage::Unknown),
    ]
}

impl Bench {
    fn pass(&mut self, seconds: u32, power: f64) {
        self.second += seconds;
        self.charge(power, seconds);
    }
}

#[test]
fn a_loop_of_ones_own_has_the_bits_of_the_runner() {
    let mut firmware = Firmware::new(Bench::dear());
    let mut runner = OneRunner::new(Bench::dear(), dear_node(), 0);
    firmware.run_until(43_200);
    while runner.board().second < 43_200 || !runner.is_idle() {
        runner.step();
    }
    assert_eq!(firmware.board.ran, runner.board().ran);
    assert_eq!(firmware.state.last_hour(), runner.state().last_hour());
    assert_eq!(firmware.node.overall(&firmware.state), runner.node().overall(runner.state()));
}

#[test]
fn after_each_loss_of_power_the_node_goes_on_by_an_image_from_a_store_of_ones_own() {
    for (name, change, gap) in losses() {
        let mut firmware = Firmware::new(Bench::dear());
        firmware.run_until(21_600);
        let mut store = vec![0; model_core::snapshot::image_size::<OneNode>()];
        let size = save_image(firmware.node, &firmware.state, 7, &mut store).expect("room");
        assert_eq!(size, store.len());
        let before = firmware.state;
        change(&mut firmware.board);
        // The firmware begins anew; its RAM is lost.
        let mut firmware = Firmware::new(firmware.board);
        assert_eq!(read_image(firmware.node, &store, &mut firmware.state), Ok(7), "{name}");
        assert_eq!(firmware.state, before, "{name}");
        // The same by the library's two slots: the newest of both.
        let Image { state, slot, .. } = newest_image(firmware.node, [&[0xff; 64], &store]).expect("whole");
        assert!(state == before && slot == 1, "{name}");
        let second = firmware.board.second;
        firmware.resume(gap(second));
        firmware.assert_hours_inside();
        store[size / 2] ^= 1;
        assert!(read_image(firmware.node, &store, &mut firmware.state).is_err(), "{name}");
    }
}

#[test]
fn after_each_loss_of_power_the_node_goes_on_by_a_state_in_ram_even_within_a_burst() {
    for (name, change, gap) in losses() {
        for is_within in [false, true] {
            let mut firmware = Firmware::new(Bench::dear());
            firmware.run_until(21_600);
            while is_within && !(firmware.is_sampling && firmware.board.taken > 200) {
                firmware.step();
            }
            change(&mut firmware.board);
            let second = firmware.board.second;
            firmware.resume(gap(second));
            assert!(!matches!(firmware.wake.task, Task::Burst { .. }) || !is_within, "{name}");
            // The power now has its bound at once, and a useful one after the next reading.
            let power = |firmware: &Firmware| {
                let Status { power, power_bound, .. } = firmware.node.status(&firmware.state);
                [power, power_bound].map(f64::from)
            };
            let [found, bound] = power(&firmware);
            assert!((found - POWER).abs() <= bound, "{name} {found} {bound}");
            firmware.run_until(second + 600);
            let [found, bound] = power(&firmware);
            assert!((found - POWER).abs() <= bound && bound < POWER, "{name} {found} {bound}");
            firmware.assert_hours_inside();
        }
    }
}

//! The node that follows its harvester on the host: its storage, kept again in double precision beside it.
//!
//! That its bits on a microcontroller are those of the host is checked by `host-bench on-target --node` and `--leave-outs`.

use firmware_example::following::{
    Decision, FlashBoard, Following, Report, SLOT_BYTES, STORE_VOLTAGE, following,
};
use model_core::snapshot::{Image, SnapshotError};

/// The storage of the node as the documentation of `economy` has it: farads, ohms, volts when full, watts asleep.
const CAPACITANCE: f64 = 22e-6;
const LEAKAGE: f64 = 100e6;
const FULL: f64 = 4.2;
const ASLEEP: f64 = 0.3e-6;

/// What an action takes, in joules.
fn cost(decision: Decision) -> f64 {
    match decision {
        Decision::Sleep => 0.0,
        Decision::Measure => 4e-6,
        Decision::Transmit => 35e-6,
    }
}

/// Keeps the storage beside a node's reports and compares each second; gives all that came in.
fn keep(reports: impl Iterator<Item = Report>) -> (f64, [u32; 3]) {
    let energy = |voltage: f64| 0.5 * CAPACITANCE * voltage * voltage;
    let mut stored = energy(STORE_VOLTAGE.into());
    let (mut came_in, mut counts) = (0.0, [0; 3]);
    for report in reports {
        let harvested = f64::from(report.harvested);
        came_in += harvested;
        // A second in a thousand steps of leakage.
        for _ in 0..1000 {
            stored += 1e-3 * (harvested - ASLEEP - 2.0 * stored / (LEAKAGE * CAPACITANCE));
        }
        stored = stored.min(energy(FULL));
        counts[report.decision as usize] += 1;
        let off = (f64::from(report.stored) - stored).abs();
        assert!(off < 1e-3 * (came_in + energy(STORE_VOLTAGE.into())), "{report:?}: {stored:e} J");
        // What was decided is not yet spent in the report.
        stored -= cost(report.decision);
        assert!(stored > energy(1.9), "{report:?}: below the lock-out");
    }
    (came_in, counts)
}

fn follow(seconds: u32) -> (f64, [u32; 3]) {
    let mut node = Following::new(FlashBoard::default(), following().expect("valid")).expect("valid");
    let found = keep((0..seconds).map(|_| node.second().expect("the trace can be followed")));
    assert!(f64::from(node.power_manager().unexplained()).abs() < 1e-6 * found.0);
    found
}

fn assert_active(seconds: u32, (came_in, [asleep, measured, transmitted]): (f64, [u32; 3])) {
    assert_eq!(asleep + measured + transmitted, seconds);
    let mean = came_in / f64::from(seconds);
    assert!((0.5e-6..100e-6).contains(&mean), "{mean:e} W");
    // Once in ten seconds and once a minute, if the storage allows it.
    assert!(measured > seconds / 40 && transmitted > seconds / 600, "{measured} {transmitted}");
    println!("{seconds} s: {mean:.3e} W, {measured} measurements, {transmitted} transmissions");
}

#[test]
fn the_following_node_keeps_its_books_for_twenty_minutes() {
    assert_active(1200, follow(1200));
}

#[test]
#[ignore = "a minute in the release profile"]
fn the_following_node_keeps_its_books_for_a_day() {
    assert_active(86_400, follow(86_400));
}

/// Two slots of flash, of which images of a node are written by turns.
struct Flash([[u8; SLOT_BYTES]; 2]);

impl Flash {
    fn new() -> Self {
        Self([[0xff; SLOT_BYTES]; 2])
    }

    fn slots(&self) -> [&[u8]; 2] {
        self.0.each_ref().map(<[u8; SLOT_BYTES]>::as_slice)
    }

    /// The number of the next image and its slot, after the newest image.
    fn next(&mut self, newest: Option<Image<()>>) -> (u32, &mut [u8]) {
        let (sequence, slot) = newest.map_or((1, 0), |image| (image.next_sequence(), image.next_slot()));
        (sequence, &mut self.0[slot])
    }
}

/// The log and the final image of the node with a power-down after each of these numbers of seconds.
fn with_power_downs(every: u32) -> (Vec<Report>, [u8; SLOT_BYTES]) {
    let awake = |board| Following::new(board, following().expect("valid")).expect("valid");
    let (mut node, mut flash, mut newest) = (awake(FlashBoard::default()), Flash::new(), None);
    let mut log = Vec::new();
    for second in 1..=90 {
        log.push(node.second().expect("the trace can be followed"));
        if second % every == 0 {
            let (sequence, slot) = flash.next(newest);
            assert_eq!(sequence, second / every);
            node.save(sequence, slot).expect("room");
            node = awake(node.into_board());
            let image = node.resume(flash.slots()).expect("its own image");
            assert_eq!(image.sequence, sequence);
            newest = Some(image);
        }
    }
    let mut image = [0; SLOT_BYTES];
    node.save(0, &mut image).expect("room");
    (log, image)
}

#[test]
fn the_node_resumes_with_the_same_bits() {
    let whole = with_power_downs(1000);
    assert!(whole.0.iter().any(|report| report.decision == Decision::Transmit));
    assert_eq!(with_power_downs(1), whole);
    assert_eq!(with_power_downs(7), whole);
}

#[test]
fn a_torn_image_is_passed_over() {
    let board = FlashBoard::default();
    let mut node = Following::new(board, following().expect("valid")).expect("valid");
    let mut flash = Flash::new();
    assert_eq!(node.resume(flash.slots()), Err(SnapshotError::NotASnapshot));
    let first = Image { state: (), sequence: 6, slot: 0 };
    for newest in [Image { sequence: 5, slot: 1, ..first }, first] {
        node.second().expect("the trace can be followed");
        let (sequence, slot) = flash.next(Some(newest));
        node.save(sequence, slot).expect("room");
    }
    flash.next(Some(first)).1[100..].fill(0xff);
    assert_eq!(node.resume(flash.slots()), Ok(first));
}

#[test]
fn after_a_reset_the_numbers_of_the_images_continue_and_the_newest_is_resumed() {
    let start = || Following::new(FlashBoard::default(), following().expect("valid")).expect("valid");
    let mut flash = Flash::new();
    // Resets after different numbers of images, so that the slot of the newest is the first and the second.
    let mut images = 0;
    for images_until_reset in [3, 1, 2, 1, 5] {
        let mut node = start();
        let mut newest = node.resume(flash.slots()).ok();
        assert_eq!(newest.map(|image| image.sequence), (images > 0).then_some(images));
        for _ in 0..images_until_reset {
            images += 1;
            let report = node.second().expect("the trace can be followed");
            assert_eq!(report.second, images, "continues from the newest image");
            let (sequence, slot) = flash.next(newest);
            assert_eq!(sequence, images);
            node.save(sequence, slot).expect("room");
            let saved = newest;
            newest = start().resume(flash.slots()).ok();
            assert_eq!(newest.map(|image| image.sequence), Some(sequence));
            assert_ne!(newest.map(|image| image.slot), saved.map(|image| image.slot));
        }
    }
}

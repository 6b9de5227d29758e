//! Fuzz targets: changed copies of valid inputs, and calls in any order.
//!
//! `FUZZ_SEED` is a number that chooses the inputs, and `FUZZ_FACTOR` multiplies their number. With `FUZZ_SECONDS` each target runs
//! for so many seconds instead. A target that fails prints the seed of its input; `ARBTEST_SEED` with that seed and the name of the
//! test runs that input alone.

mod fuzz {
    mod calls;
    mod change;
    mod images;
    mod maps;
    #[cfg(unix)]
    mod rows;
    mod scenes;
    mod traces;
}

#[path = "../../model-core/tests/all/common/harvesters.rs"]
#[allow(dead_code)]
mod harvesters;

use std::io::Write;
use std::sync::{Mutex, Once, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use arbtest::arbitrary::Unstructured;
use arbtest::arbtest;
use cpu_time::ThreadTime;

/// Bytes from which an input is made.
const SIZE: u64 = 4096;
/// Most CPU seconds of an input, and most seconds until it is stopped.
const MOST_SECONDS: [f64; 2] = [2.0, 60.0];
/// Most resident memory of the process, and of each that it starts, in kB.
const MOST_MEMORY: u64 = 1_000_000;
/// Most CPU seconds of all targets with their usual number of inputs.
const MOST_OF_ALL: f64 = 25.0;

/// A target whose input runs: its name, the seed of the input and its start.
type Running = (&'static str, u64, Instant);

static RUNNING: Mutex<Vec<Running>> = Mutex::new(Vec::new());

fn number(variable: &str) -> Option<u64> {
    std::env::var(variable).ok().map(|text| text.parse().expect("a whole number"))
}

fn running(change: impl FnOnce(&mut Vec<Running>)) {
    change(&mut RUNNING.lock().unwrap_or_else(PoisonError::into_inner));
}

/// While it is there, the input of the target runs.
struct Run(&'static str);

impl Run {
    fn begin(name: &'static str, seed: u64) -> Self {
        running(|all| all.push((name, seed, Instant::now())));
        Self(name)
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        running(|all| all.retain(|(name, ..)| *name != self.0));
    }
}

/// SplitMix64.
fn mixed(number: u64) -> u64 {
    let z = number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Largest resident memory of the process so far in kB; 0 where the system does not tell.
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// CPU seconds of all threads and of the processes that they started; 0 where the system does not tell.
fn cpu_seconds() -> f64 {
    let all = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The second field is a name in parentheses. The fields 14 to 17 count hundredths of a second.
    let fields = all.rsplit(") ").next().unwrap_or_default().split(' ').skip(11).take(4);
    fields.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() * 1e-2
}

/// Stops the process if an input hangs or takes too much memory, by a thread that is started once.
fn watch() {
    static STARTED: Once = Once::new();
    let look = || loop {
        thread::sleep(Duration::from_millis(100));
        let is_late = |(.., since): &Running| since.elapsed().as_secs_f64() > MOST_SECONDS[1];
        running(|all| {
            if all.iter().any(is_late) || memory() > MOST_MEMORY {
                let told = |(name, seed, since): &Running| {
                    eprintln!("{name}, seed 0x{seed:016x}: {:?}, {} kB", since.elapsed(), memory());
                };
                all.iter().for_each(told);
                std::process::exit(1);
            }
        });
    };
    STARTED.call_once(|| drop(thread::spawn(look)));
}

/// Runs a target on so many inputs. `property` panics on a fault and says whether the input came past the parser; at least half
/// of them must.
fn fuzz(name: &'static str, usual: u64, mut property: impl FnMut(&mut Unstructured<'_>) -> bool) {
    watch();
    if std::env::var_os("ARBTEST_SEED").is_some() {
        return arbtest(|bytes| Ok(_ = property(bytes))).run();
    }
    let [seed, factor, seconds] = ["FUZZ_SEED", "FUZZ_FACTOR", "FUZZ_SECONDS"].map(number);
    let (seed, begin) = (seed.unwrap_or(1), Instant::now());
    let of_name = name.bytes().fold(seed, |hash, byte| mixed(hash ^ u64::from(byte)));
    let is_more = |done| match seconds {
        Some(seconds) => begin.elapsed().as_secs() < seconds,
        None => done < usual * factor.unwrap_or(1),
    };
    let (mut done, mut past, mut slowest) = (0, 0, Duration::ZERO);
    while is_more(done) {
        let input = mixed(of_name.wrapping_add(done)) << 32 | SIZE;
        let run = Run::begin(name, input);
        let start = ThreadTime::now();
        let mut judge = |bytes: &mut Unstructured<'_>| {
            past += u64::from(property(bytes));
            Ok(())
        };
        arbtest(&mut judge).seed(input).run();
        let taken = start.elapsed();
        drop(run);
        assert!(taken.as_secs_f64() < MOST_SECONDS[0], "{name}, seed 0x{input:016x}: {taken:?}");
        slowest = slowest.max(taken);
        done += 1;
    }
    let (share, memory, cpu) = (100.0 * past as f64 / done as f64, memory() / 1000, cpu_seconds());
    let (taken, slowest) = (begin.elapsed().as_secs_f64(), slowest.as_secs_f64() * 1e3);
    // Not by `println`, whose text a test that passes does not show.
    let told = format!(
        "fuzz {name}: {done} inputs of seed {seed}, {share:.1} % past the parser, {taken:.1} s, slowest {slowest:.1} ms; all \
         targets so far {cpu:.1} CPU s, {memory} MB\n"
    );
    std::io::stdout().write_all(told.as_bytes()).expect("standard output");
    assert!(2 * past >= done, "{name}: {past} of {done} past the parser");
    let is_usual = factor.is_none() && seconds.is_none();
    assert!(!is_usual || cpu < MOST_OF_ALL, "{cpu:.1} CPU s of all targets");
}

#[test]
fn overflow_is_checked_in_this_profile() {
    let sum = std::panic::catch_unwind(|| std::hint::black_box(i32::MAX) + std::hint::black_box(1));
    assert!(sum.is_err());
}

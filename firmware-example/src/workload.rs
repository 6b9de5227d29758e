//! The workloads of the bench. The host runs them too and compares the bits.

pub mod bump_stop;
pub mod contact_separation;
pub mod emitted;
pub mod estimators;
pub mod peer;
pub mod response_map;
pub mod run;
pub mod sliding;

/// A workload of the bench.
///
/// The bench uses it as `dyn Workload`, so that the code around it is the same machine code in `empty` and in
/// `bench`. The difference of the two sizes is the workload's.
pub trait Workload {
    /// One word, for the log.
    fn name(&self) -> &'static str;

    /// Runs up to the next sample. The bench measures this call only.
    fn advance(&mut self) -> Progress;

    /// The state as raw bits, for an exact comparison with the host.
    fn state(&self) -> &[u32];
}

/// Takes the workloads of a variant, one after the other. A variant gives `None` if a workload is refused.
pub type Visit<'a> = &'a mut dyn FnMut(&mut dyn Workload);

/// Gives a workload to `visit`; `None` if the workload was refused.
#[inline]
pub(crate) fn show<W: Workload>(visit: Visit<'_>, mut workload: Option<W>) -> Option<()> {
    // By reference: a move would put a second copy of the workload on the stack.
    visit(workload.as_mut()?);
    Some(())
}

/// The result of [`Workload::advance`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// The next sample.
    Sample {
        /// Steps since the last sample.
        steps: u32,
        /// Simulated microseconds since the last sample.
        simulated_us: u32,
    },
    /// There are no more samples.
    Finished,
    /// The model could not be stepped.
    Failed,
}

/// A variant of the bench.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    /// Its name, as the environment variable `HARVESTER_VARIANT` has it.
    pub name: &'static str,
    /// Gives its workloads, one after the other; `None` if one is refused.
    pub workloads: fn(Visit<'_>) -> Option<()>,
}

macro_rules! variants {
    ($($scene:ident :: $name:ident),* $(,)?) => {
        /// All variants. The first one is the default.
        pub const VARIANTS: &[Variant] = &[$(Variant {
            name: concat!(stringify!($scene), "::", stringify!($name)),
            workloads: crate::workload::$scene::$name,
        }),*];

        const UNKNOWN: &str = concat!(
            "HARVESTER_VARIANT is none of",
            $(" ", stringify!($scene), "::", stringify!($name),)*
        );
    };
}

variants! {
    contact_separation::bench,
    contact_separation::others,
    contact_separation::precision,
    sliding::bench,
    sliding::others,
    sliding::precision,
    bump_stop::bench,
    bump_stop::others,
    bump_stop::checked,
    bump_stop::precision,
    estimators::all,
    response_map::all,
    emitted::bench,
    peer::smooth,
}

/// The variant with that name, for a `const`.
///
/// # Panics
/// If there is none; in a `const` this is a compile error that lists the names.
#[must_use]
pub const fn named(name: &str) -> Variant {
    let mut index = 0;
    while index < VARIANTS.len() {
        if same(VARIANTS[index].name.as_bytes(), name.as_bytes()) {
            return VARIANTS[index];
        }
        index += 1;
    }
    panic!("{}", UNKNOWN)
}

/// `==` of slices is no `const fn`.
const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut index = 0;
    while index < a.len() && index < b.len() && a[index] == b[index] {
        index += 1;
    }
    index == a.len() && index == b.len()
}

//! The variants of the bench: each is a function of [`crate::workload`] that gives one or more workloads.

use crate::workload::Visit;

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

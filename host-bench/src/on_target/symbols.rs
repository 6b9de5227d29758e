//! What a single-precision firmware that cannot panic must not contain.

use super::image::Image;
use object::{Object, ObjectSymbol};

/// The functions of `image` that panic, or that calculate in double precision, which these cores do
/// in software and by the hundred instructions. None, if all is well.
///
/// That a panic function is absent says that nothing in the firmware can call it: the panic handler
/// does no formatting, which would bring some of its own.
#[must_use]
pub fn refused(image: &Image<'_>) -> Vec<String> {
    let mut names: Vec<String> = image
        .symbols()
        .filter(|symbol| symbol.is_definition())
        .filter_map(|symbol| symbol.name().ok())
        .map(|name| format!("{:#}", rustc_demangle::demangle(name)))
        .filter(|name| is_panic(name) || is_double(name))
        .collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Everything that panics goes through this module of `core`.
fn is_panic(name: &str) -> bool {
    name.contains("core::panicking::")
}

/// Arithmetic, comparison and conversion have two sets of names, the Arm ABI's and the older ones
/// with which `compiler_builtins` implements them.
fn is_double(name: &str) -> bool {
    let function = name.rsplit("::").next().unwrap_or(name);
    if let Some(abi) = function.strip_prefix("__aeabi_") {
        return abi.starts_with('d') || abi.starts_with("cd") || abi.ends_with("2d");
    }
    function.starts_with("__") && function.contains("df")
}

#[cfg(test)]
mod tests {
    use super::{is_double, is_panic};

    #[test]
    fn panics_are_known_by_their_module() {
        assert!(is_panic("core::panicking::panic_bounds_check"));
        assert!(is_panic("core::panicking::panic_const::panic_const_div_by_zero"));
        assert!(!is_panic("firmware_example::stop::panic"));
    }

    #[test]
    fn double_arithmetic_is_known_by_both_its_names() {
        for name in [
            "__aeabi_dadd",
            "__aeabi_cdcmple",
            "__aeabi_ul2d",
            "__aeabi_d2f",
            "__adddf3",
            "compiler_builtins::float::mul::__muldf3",
            "__truncdfsf2",
            "__floatunsidf",
        ] {
            assert!(is_double(name), "{name}");
        }
    }

    #[test]
    fn single_precision_and_integers_are_welcome() {
        for name in [
            "__aeabi_fadd",
            "__aeabi_ul2f",
            "__aeabi_f2iz",
            "__aeabi_uldivmod",
            "__aeabi_memcpy",
            "__addsf3",
            "__udivmoddi4",
            "model_core::integrate::step",
        ] {
            assert!(!is_double(name), "{name}");
        }
    }
}

//! The identity of the program: rows of different builds do not belong to one result.

use std::sync::OnceLock;
use std::{env, fs};

/// Offset and prime of the 64-bit hash of Fowler, Noll and Vo (FNV-1a).
const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0100_0000_01b3;

/// The version, and a hash of the executable file; `unknown` in its place if the file cannot be read.
pub(crate) fn build() -> &'static str {
    static BUILD: OnceLock<String> = OnceLock::new();
    BUILD.get_or_init(|| {
        let content = env::current_exe().and_then(fs::read);
        let hash =
            content.map_or_else(|_| "unknown".to_owned(), |content| format!("{:016x}", fnv_1a(&content)));
        format!("{}-{hash}", env!("CARGO_PKG_VERSION"))
    })
}

/// The 64-bit hash FNV-1a.
pub(crate) fn fnv_1a(content: &[u8]) -> u64 {
    content.iter().fold(OFFSET, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one_and_the_program_has_it() {
        // Test vectors of the authors.
        let vectors = [("", OFFSET), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)];
        for (text, hash) in vectors {
            assert_eq!(fnv_1a(text.as_bytes()), hash, "{text}");
        }
        assert!(
            build().starts_with(env!("CARGO_PKG_VERSION")) && !build().ends_with("unknown"),
            "{}",
            build()
        );
    }
}

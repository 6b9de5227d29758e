//! A shared library may have undefined symbols unless the linker is told otherwise; `memcpy` is the C library's.

fn main() {
    println!("cargo::rustc-link-arg-cdylib=-Wl,-z,defs");
    println!("cargo::rustc-link-arg-cdylib=-lc");
}

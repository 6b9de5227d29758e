#![doc = include_str!("../README.md")]
#![no_std]

#[cfg(armv6m)]
core::arch::global_asm!(include_str!("armv6m.s"));

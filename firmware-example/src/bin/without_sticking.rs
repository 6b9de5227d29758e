//! The bench without sticking.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::contact_separation::scenes::without_sticking);

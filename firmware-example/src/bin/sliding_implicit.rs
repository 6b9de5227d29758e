//! The sliding bench by TR-BDF2 with a fixed step.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::sliding::scenes::implicit);

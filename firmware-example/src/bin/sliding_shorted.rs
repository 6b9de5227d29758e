//! The sliding bench with the load shorted.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::sliding::scenes::shorted);

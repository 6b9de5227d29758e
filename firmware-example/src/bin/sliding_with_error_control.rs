//! The sliding bench by TR-BDF2 with error control.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::sliding::scenes::with_error_control);

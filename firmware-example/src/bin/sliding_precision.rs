//! The settled sliding scene at several tolerances and steps: `on-target --work-precision`.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_several_main!(firmware_example::workload::sliding::scenes::with_precision);

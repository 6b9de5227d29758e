//! What the sliding bench leaves out: stick-slip, TR-BDF2, the making of the coefficients.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_several_main!(firmware_example::workload::sliding::scenes::with_others);

//! The bump-stop bench without the voltage acting back on the beam.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::bump_stop::scenes::one_way);

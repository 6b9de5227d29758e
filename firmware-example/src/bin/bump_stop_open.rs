//! The bump-stop bench with the load open.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::bump_stop::scenes::open);

//! The bump-stop bench with one length of step.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::bump_stop::scenes::single_rate);

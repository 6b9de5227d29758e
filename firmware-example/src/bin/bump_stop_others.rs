//! What the bump-stop bench leaves out.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_several_main!(firmware_example::workload::bump_stop::scenes::with_others);

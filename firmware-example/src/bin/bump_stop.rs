//! The bump-stop scene, beside `bench`.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::bump_stop::scenes::bench);

//! The bump-stop scene at several lengths of step: `on-target --work-precision`.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_several_main!(firmware_example::workload::bump_stop::scenes::with_precision);

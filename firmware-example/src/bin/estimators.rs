//! The estimators of all scenes, sample by sample, and the closed forms.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_several_main!(firmware_example::workload::estimators::with_all);

//! The settled impacting scene at several tolerances and steps: `on-target --work-precision`.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_several_main!(
    firmware_example::workload::contact_separation::scenes::with_precision
);

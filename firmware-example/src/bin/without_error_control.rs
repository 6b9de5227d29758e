//! The bench without error control.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(
    firmware_example::workload::contact_separation::scenes::without_error_control
);

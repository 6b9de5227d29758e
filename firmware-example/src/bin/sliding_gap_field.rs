//! The sliding bench with the force of the field.

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::sliding::scenes::gap_field);

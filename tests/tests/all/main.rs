//! The tests that cross crates, in one binary, because each binary links all of the host.

mod accuracy;
mod bump_stop;
mod bump_stop_clamp;
mod bump_stop_figures;
mod bump_stop_paper;
mod bump_stop_store;
mod closed_form;
mod convergence;
mod dense_solve;
mod exponential_radau;
mod findings;
mod ledger;
mod limits;
mod on_target_bits;
mod published_rows;
mod rectified;
mod sensor_node;
mod sliding_agreement;
mod sliding_convergence;
mod sliding_limits;
mod sliding_parts;
mod sliding_rows;
mod small_voltages;
mod stability;
mod steady_state;
mod steady_state_scenes;

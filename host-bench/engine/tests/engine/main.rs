//! Tests of the embedded core on the host: one binary, because each would link all of it.

mod peaks;
mod sliding_sizes;
mod steady_state;
mod store_in_loop;
mod whole_day;

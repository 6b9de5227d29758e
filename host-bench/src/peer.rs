//! Textbook methods on the host, in double precision and with fixed steps, for comparison with the core's methods.

mod bump_stop;

pub(crate) use self::bump_stop::run as bump_stop;

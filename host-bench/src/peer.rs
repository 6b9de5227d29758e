//! Textbook methods on the host, in double precision and with fixed steps: what the core's method for a
//! scene is measured against.

mod bump_stop;

pub(crate) use self::bump_stop::run as bump_stop;

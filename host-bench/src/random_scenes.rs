//! Random scenes over the whole range of the bounds, each run with its accuracy statement and judged by runs that are
//! more accurate.
//!
//! A case follows from a seed and its number alone. It is a shipped scene with some of its keys changed, so that `run` of
//! the command line runs it too.

mod draw;
mod judge;
mod source;

pub use draw::Case;
pub use judge::{Class, Effort, Finding, judge};

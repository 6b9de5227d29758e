//! Whether a result is right within what it states, or says that it is not, or is a named error: over grids of stiff
//! and extreme scenes, and over random scenes.
//!
//! A case is a shipped scene with some of its keys changed, so that `run` of the command line runs it too. Its run is
//! judged with its accuracy statement by runs that are more accurate.

mod case;
mod chaos;
mod day;
mod exact;
mod grid;
mod judge;
mod page;
pub(crate) mod random;
mod rows;
mod summary;
mod twin;

pub use case::Case;
pub(crate) use day::{COLUMNS, Compared, DAY_S, pairs};
pub use exact::Quantity;
pub use grid::{Extent, Kind, grid};
pub use judge::{Class, Effort, Finding, Judge, judge};
pub(crate) use page::{CASES, page};
pub use random::{draw, draw_varied};
pub(crate) use rows::{Row, build, fnv_1a};
pub use summary::cause;
pub(crate) use summary::summary;

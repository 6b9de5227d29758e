//! What the tables of the keys say, as text: for people, as a page, as JSON, and as a schema for editors.

mod page;
mod rows;
mod schema;

pub use self::page::{markdown, text};
pub(crate) use self::rows::bounds;
pub use self::rows::{Row, rows};
pub use self::schema::schema;

use crate::scene_file::KEYS;

/// The names of the scenes.
#[must_use]
pub fn scenes() -> Vec<&'static str> {
    KEYS.kinds.iter().map(|kind| kind.word).collect()
}

#[cfg(test)]
mod tests;

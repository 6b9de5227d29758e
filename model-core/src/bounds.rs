//! Bounds of parameters, and the error of a parameter outside them.

use core::fmt;

use crate::scalar::Scalar;

/// The range of a parameter, ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bounds<S> {
    /// Smallest allowed value, in SI units.
    pub lowest: S,
    /// Largest allowed value, in SI units.
    pub highest: S,
}

/// A parameter outside its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct ParameterError<S> {
    /// Name of the field.
    pub field: &'static str,
    /// Value of the field in SI units.
    pub value: S,
    /// The allowed values.
    pub bounds: Bounds<S>,
}

impl<S: Scalar> fmt::Display for ParameterError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { field, value, bounds: Bounds { lowest, highest } } = self;
        if lowest == highest {
            write!(f, "{field} = {value:?} must be {lowest:?}")
        } else {
            write!(f, "{field} = {value:?} must be from {lowest:?} to {highest:?}")
        }
    }
}

impl<S: Scalar> core::error::Error for ParameterError<S> {}

/// The first of some numbers, with name, value, lowest and highest value, that is outside its bounds or not a number.
pub(crate) const fn first_outside(rows: &[(&'static str, f32, f32, f32)]) -> Option<ParameterError<f32>> {
    let mut rows = rows;
    while let [(field, value, lowest, highest), rest @ ..] = rows {
        if !(*value >= *lowest && *value <= *highest) {
            let bounds = Bounds { lowest: *lowest, highest: *highest };
            return Some(ParameterError { field, value: *value, bounds });
        }
        rows = rest;
    }
    None
}

/// States the bounds of the numbers of a struct: the table `BOUNDS`, and `check_numbers`, which refuses by it.
///
/// A row is `"name" = field: lowest, highest;` with the name that the error has. A field of type `Option<S>` is
/// checked where it is given.
macro_rules! bounded {
    ($type:ident<S $(, $parameter:ident)*>: $($name:literal = $($field:ident).+: $lowest:expr, $highest:expr;)+) => {
        impl<S: crate::scalar::Scalar $(, $parameter)*> $type<S $(, $parameter)*> {
            /// Name, as in [`ParameterError::field`](crate::bounds::ParameterError::field), and bounds of each number.
            pub const BOUNDS: &'static [(&'static str, crate::bounds::Bounds<f64>)] =
                &[$(($name, crate::bounds::Bounds { lowest: $lowest, highest: $highest })),+];

            fn check_numbers(&self) -> Result<(), crate::bounds::ParameterError<S>> {
                $(if let Some(value) = Option::<S>::from(self.$($field).+) {
                    crate::bounds::Bounds::new($lowest, $highest).check($name, value)?;
                })+
                Ok(())
            }
        }
    };
}
pub(crate) use bounded;

impl<S: Scalar> Bounds<S> {
    /// From `lowest` to `highest`, both literals of the source.
    #[must_use]
    #[inline]
    pub(crate) fn new(lowest: f64, highest: f64) -> Self {
        Self { lowest: S::from_f64(lowest), highest: S::from_f64(highest) }
    }

    /// The bounds of a table in this number type.
    pub(crate) fn of(table: Bounds<f64>) -> Self {
        Self::new(table.lowest, table.highest)
    }

    /// Refuses a value outside the bounds, and not-a-number.
    ///
    /// # Errors
    /// `field`, its value and these bounds.
    pub(crate) fn check(self, field: &'static str, value: S) -> Result<(), ParameterError<S>> {
        if value >= self.lowest && value <= self.highest {
            Ok(())
        } else {
            Err(ParameterError { field, value, bounds: self })
        }
    }
}

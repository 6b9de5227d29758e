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
    ($type:ident<S $(, $parameter:ident)*>: $($name:tt = $($field:ident).+: $lowest:expr, $highest:expr;)+) => {
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

/// Declares a struct of numbers once: its fields with their documentation, what [`bounded!`] makes, and for a host the macro
/// `$rows`, which hands its rows to another macro: `rows! { other! { tokens } }` is `other! { tokens [rows] }`, with rows as
/// `(field) key ("unit" "meaning" lowest highest);`.
///
/// A row is `field "symbol": key "unit" lowest..=highest "meaning";`, and before the `;` a bound by other parameters, if there
/// is one. The key is that of a scene file, the name of the number in errors is the field's after a prefix. The first token
/// is `$`, which a macro cannot write itself. Without a struct, rows begin with the name and a path to the field.
macro_rules! parameters {
    ($dollar:tt $rows:ident $prefix:literal $(#[$meta:meta])* $visible:vis struct $type:ident<S $(, $parameter:ident $(= $of:ty)?)*> {
        { $($field:ident $symbol:literal: $key:ident $unit:literal $lowest:literal..=$highest:literal $meaning:literal
            $($limit:literal)?;)+ }
        $($rest:tt)*
    }) => {
        $(#[$meta])*
        $visible struct $type<S $(, $parameter $(= $of)?)*> {
            $(#[doc = concat!($meaning, " ", $symbol, "; unit ", $unit, ", ", $lowest, " to ", $highest, ".")]
            pub $field: S,)+
            $($rest)*
        }
        crate::bounds::parameters! { $dollar $rows for $type<S $(, $parameter)*> {
            $((concat!($prefix, stringify!($field))) = $field:
                $key $unit $lowest..=$highest $meaning $($limit)?;)+
        } }
    };
    ($dollar:tt $rows:ident for $type:ident<S $(, $parameter:ident)*> { $(
        $name:tt = $($field:ident).+: $key:ident $unit:literal $lowest:literal..=$highest:literal $meaning:literal
        $($limit:literal)?;
    )+ }) => {
        crate::bounds::bounded! { $type<S $(, $parameter)*>: $($name = $($field).+: $lowest, $highest;)+ }

        #[doc(hidden)]
        #[macro_export]
        macro_rules! $rows {
            ($dollar($dollar call:ident)::+! { $dollar($dollar with:tt)* }) => {
                $dollar($dollar call)::+! { $dollar($dollar with)*
                    [$(($($field).+) $key ($unit $meaning $lowest $highest $($limit)?);)+]
                }
            };
        }
    };
}
pub(crate) use parameters;

/// `with_choices` of a struct of the rows and `choices`.
macro_rules! with_choices {
    ([$(($field:ident) $key:ident $meaning:tt;)+]) => {
        /// The same numbers with other components.
        #[must_use]
        pub fn with_choices<D>(self, choices: D) -> Parameters<S, D> {
            Parameters { $($field: self.$field,)+ choices }
        }
    };
}
pub(crate) use with_choices;

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

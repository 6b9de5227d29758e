//! One error for all of the library's fallible functions, for a caller that passes them on with `?`.

use core::fmt;

use crate::bounds::ParameterError;
use crate::energy::estimator::EstimatorError;
use crate::energy::response_map::MapError;
use crate::excitation::{ExcitationError, StreamError};
use crate::hybrid::StepError;
use crate::node::{NodeError, SaveError};
use crate::scalar::Scalar;
use crate::snapshot::SnapshotError;

/// Declares [`Error`], its conversions, and its text, which is that of the inner error.
macro_rules! errors {
    ($($(#[$doc:meta])+ $variant:ident($inner:ty),)+) => {
        /// Any error of this library. Each error of a function converts into it.
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[non_exhaustive]
        pub enum Error<S = f32> {
            $($(#[$doc])+ $variant($inner),)+
        }

        $(impl<S> From<$inner> for Error<S> {
            fn from(error: $inner) -> Self {
                Self::$variant(error)
            }
        })+

        impl<S: Scalar> fmt::Display for Error<S> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self {
                    $(Self::$variant(error) => error.fmt(f),)+
                }
            }
        }
    };
}

errors! {
    /// A parameter is outside its bounds.
    Parameter(ParameterError<S>),
    /// An excitation cannot be made.
    Excitation(ExcitationError),
    /// A stream of samples refused a sample.
    Stream(StreamError),
    /// A step failed.
    Step(StepError<S>),
    /// An estimator refused a setting or a sample.
    Estimator(EstimatorError<S>),
    /// A response map cannot be read.
    Map(MapError),
    /// A node cannot be made of its parts.
    Node(NodeError),
    /// An image or a snapshot cannot be read.
    Snapshot(SnapshotError),
    /// An image was not saved.
    Save(SaveError),
}

impl<S: Scalar> core::error::Error for Error<S> {}

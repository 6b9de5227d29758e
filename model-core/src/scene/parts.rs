//! Declares the component types of the `Choices` of a scene.

/// Declares `Parts` and implements it for `Choices`: each type parameter of `Choices` with its name and its bound.
macro_rules! parts {
    ($scalar:ident: $($(#[$doc:meta])* $parameter:ident = $name:ident: $bound:path,)+) => {
        /// The component types of [`Choices`].
        pub trait Parts<$scalar: Scalar>: Copy + Debug + PartialEq {
            $($(#[$doc])* type $name: $bound;)+

            /// The choices themselves.
            fn choices(&self) -> &Choices<$(Self::$name),+>;
        }

        impl<$scalar: Scalar, $($parameter: $bound),+> Parts<$scalar> for Choices<$($parameter),+> {
            $(type $name = $parameter;)+

            #[inline(always)]
            fn choices(&self) -> &Self {
                self
            }
        }
    };
}
pub(crate) use parts;

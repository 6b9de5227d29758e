//! Forwards the methods of an `Any…` type, chosen at run time, to the component of its variant.

/// Methods in the `impl` of a trait for an enum of components, one `match` for all of them:
/// `forward! { match { Self::None => NoDraw, Self::Power(draw) => draw } fn current(&self, voltage: S) -> S; }`
macro_rules! forward {
    (match $arms:tt $(
        $(#[$attribute:meta])*
        fn $method:ident(&self $(, $argument:ident: $type:ty)* $(,)?) $(-> $result:ty)?;
    )+) => {$(
        $(#[$attribute])*
        fn $method(&self $(, $argument: $type)*) $(-> $result)? {
            $crate::any::forward!(@ self $arms $method ($($argument),*))
        }
    )+};
    (@ $self:ident { $($variant:pat => $component:expr),+ $(,)? } $method:ident $arguments:tt) => {
        match $self { $($variant => $component.$method $arguments),+ }
    };
}
pub(crate) use forward;

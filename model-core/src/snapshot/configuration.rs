//! The configuration that a state belongs to, and tuples of configurations and states.

use super::{Fingerprint, Reader, Snapshot, Writer};

/// Parameters and settings to which a state belongs: a state is restored only into the same configuration.
///
/// A tuple of up to four configurations is the configuration of the tuple of their states, so that a node saves all
/// of its states in one image ([`save_image`](super::save_image)).
pub trait Configuration {
    /// The state.
    type State: Snapshot;

    /// Includes everything that determines the meaning of a state in a fingerprint.
    fn identify(&self, fingerprint: &mut Fingerprint);
}

impl<C: Configuration> Configuration for &C {
    type State = C::State;

    fn identify(&self, fingerprint: &mut Fingerprint) {
        C::identify(self, fingerprint);
    }
}

macro_rules! tuples {
    ($(($($part:ident $place:tt),+))*) => {$(
        impl<$($part: Configuration),+> Configuration for ($($part,)+) {
            type State = ($($part::State,)+);

            fn identify(&self, fingerprint: &mut Fingerprint) {
                $(self.$place.identify(fingerprint);)+
            }
        }

        /// One entry after the other.
        impl<$($part: Snapshot),+> Snapshot for ($($part,)+) {
            const BYTES: usize = 0 $(+ $part::BYTES)+;

            fn write(&self, out: &mut Writer<'_>) {
                $(self.$place.write(out);)+
            }

            fn read(from: &mut Reader<'_>) -> Self {
                ($($part::read(from),)+)
            }
        }
    )*};
}

tuples! { (A 0, B 1) (A 0, B 1, C 2) (A 0, B 1, C 2, D 3) }

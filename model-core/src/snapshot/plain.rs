//! Implements [`Snapshot`] for numbers, truth values, arrays and options.

use super::{Reader, Snapshot, Writer};

macro_rules! integers {
    ($($integer:ty),*) => {$(
        impl Snapshot for $integer {
            const BYTES: usize = size_of::<Self>();

            #[inline]
            fn write(&self, out: &mut Writer<'_>) {
                out.bytes(self.to_le_bytes());
            }

            #[inline]
            fn read(from: &mut Reader<'_>) -> Self {
                Self::from_le_bytes(from.bytes())
            }
        }
    )*};
}

integers!(u8, u16, u32, u64, i8, i16, i32, i64);

/// Largest magnitude of a number in a state, in any SI unit: its square is finite in `f32`, and no state comes near it.
const LARGEST: f64 = 1e15;

macro_rules! floats {
    ($($float:ty),*) => {$(
        /// The bits of the number; reading refuses a number that is not finite or above 10¹⁵ in magnitude.
        impl Snapshot for $float {
            const BYTES: usize = size_of::<Self>();

            #[inline]
            fn write(&self, out: &mut Writer<'_>) {
                self.to_bits().write(out);
            }

            #[inline(never)]
            fn read(from: &mut Reader<'_>) -> Self {
                let value = Self::from_bits(Snapshot::read(from));
                from.require(value.abs() <= LARGEST as Self);
                value
            }
        }
    )*};
}

floats!(f32, f64);

/// Zero bytes.
impl Snapshot for () {
    const BYTES: usize = 0;

    fn write(&self, _out: &mut Writer<'_>) {}

    fn read(_from: &mut Reader<'_>) -> Self {}
}

/// A byte that is 0 or 1.
impl Snapshot for bool {
    const BYTES: usize = 1;

    fn write(&self, out: &mut Writer<'_>) {
        u8::from(*self).write(out);
    }

    #[inline(never)]
    fn read(from: &mut Reader<'_>) -> Self {
        let byte = u8::read(from);
        from.require(byte <= 1);
        byte == 1
    }
}

/// Writes entries in order: one loop for each type of entries in place of one for each length.
#[inline(never)]
fn write_all<T: Snapshot>(entries: &[T], out: &mut Writer<'_>) {
    for entry in entries {
        entry.write(out);
    }
}

/// Reads entries in order, as [`write_all`] writes them.
#[inline(never)]
fn overwrite_all<T: Snapshot>(entries: &mut [T], from: &mut Reader<'_>) {
    for entry in entries {
        entry.overwrite(from);
    }
}

impl<T: Snapshot, const N: usize> Snapshot for [T; N] {
    const BYTES: usize = N * T::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        write_all(self, out);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        core::array::from_fn(|_| T::read(from))
    }

    fn overwrite(&mut self, from: &mut Reader<'_>) {
        overwrite_all(self, from);
    }
}

/// A byte, 1 with a value and 0 without, then the bytes of the value or of the default.
impl<T: Snapshot> Snapshot for Option<T>
where
    T: Default + PartialEq,
{
    const BYTES: usize = 1 + T::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.is_some().write(out);
        match self {
            Some(value) => value.write(out),
            None => T::default().write(out),
        }
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let is_some = bool::read(from);
        let bytes = from.left.get(..T::BYTES).unwrap_or(&[]);
        let value = T::read(from);
        // −0 equals 0, and has another byte.
        let is_default = value == T::default() && bytes.iter().all(|byte| byte & 0x80 == 0);
        from.require(is_some || is_default);
        is_some.then_some(value)
    }
}

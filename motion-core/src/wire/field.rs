use core::fmt;

use zerocopy::{ByteOrder, I16, I32, U16, U32};

use super::{Reader, Value, Writer};
use crate::fixed::Scaled;

/// A value of fixed size on the wire.
///
/// [`Display`](fmt::Display) is what a person reads, without the unit.
pub trait Field: Copy + Eq + Default + fmt::Debug + fmt::Display {
    /// Size in bytes.
    const SIZE: usize;
    /// Type on the wire, as documents name it.
    const WIRE: &'static str;
    /// Unit; empty if there is none.
    const UNIT: &'static str = "";

    /// Reads the field from the front of a body; `None` if the bytes end before the field does.
    fn read<O: ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self>;

    /// Writes the field; `None` if it does not fit.
    fn write<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()>;

    /// Raw value, as it stands on the wire.
    fn value(&self) -> Value<'_>;

    /// Logs the field.
    #[cfg(feature = "defmt")]
    #[doc(hidden)]
    fn log(&self, f: defmt::Formatter<'_>) {
        crate::format::value(f, self.value());
    }
}

macro_rules! numbers {
    ($($number:ident $size:literal $bytes:ty, $value:ident;)*) => {$(
        impl Field for $number {
            const SIZE: usize = $size;
            const WIRE: &'static str = stringify!($number);

            #[inline]
            fn read<O: ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self> {
                reader.array().map(|bytes| <$bytes>::from_bytes(bytes).get())
            }

            #[inline]
            fn write<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
                writer.array(<$bytes>::new(*self).to_bytes())
            }

            fn value(&self) -> Value<'_> {
                Value::$value((*self).into())
            }
        }
    )*};
}
numbers! {
    u16 2 U16::<O>, Unsigned;
    i16 2 I16::<O>, Signed;
    u32 4 U32::<O>, Unsigned;
    i32 4 I32::<O>, Signed;
}

impl Field for u8 {
    const SIZE: usize = 1;
    const WIRE: &'static str = "u8";

    #[inline]
    fn read<O: ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self> {
        reader.array().map(|[byte]| byte)
    }

    #[inline]
    fn write<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        writer.array([*self])
    }

    fn value(&self) -> Value<'_> {
        Value::Unsigned((*self).into())
    }
}

impl<T: Field, const SCALE: u32> Field for Scaled<T, SCALE>
where
    Self: Copy + Eq + Default + fmt::Debug + fmt::Display,
{
    const SIZE: usize = T::SIZE;
    const WIRE: &'static str = T::WIRE;

    #[inline]
    fn read<O: ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self> {
        T::read(reader).map(Self)
    }

    #[inline]
    fn write<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        self.0.write(writer)
    }

    fn value(&self) -> Value<'_> {
        self.0.value()
    }
}

/// Yes or no in one byte.
///
/// Zero means no, every other value means yes. The byte is kept and written back unchanged.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(transparent)]
pub struct Bool(pub u8);

impl Bool {
    /// No: 0.
    pub const FALSE: Self = Self(0);
    /// Yes: 1.
    pub const TRUE: Self = Self(1);

    /// Whether the byte means yes.
    #[must_use]
    pub const fn get(self) -> bool {
        self.0 != 0
    }
}

impl From<bool> for Bool {
    fn from(yes: bool) -> Self {
        Self(yes.into())
    }
}

impl fmt::Display for Bool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            0 => f.write_str("no"),
            1 => f.write_str("yes"),
            byte => write!(f, "yes ({byte})"),
        }
    }
}

impl fmt::Debug for Bool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Bool({self})")
    }
}

impl Field for Bool {
    const SIZE: usize = 1;
    const WIRE: &'static str = "u8";

    #[inline]
    fn read<O: ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self> {
        u8::read(reader).map(Self)
    }

    #[inline]
    fn write<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        self.0.write(writer)
    }

    fn value(&self) -> Value<'_> {
        self.0.value()
    }
}

/// `N` bytes without further structure. They print as hex.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[repr(transparent)]
pub struct Bytes<const N: usize>(pub [u8; N]);

impl<const N: usize> Default for Bytes<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

impl<const N: usize> fmt::Display for Bytes<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        super::print::hex(f, &self.0)
    }
}

impl<const N: usize> fmt::Debug for Bytes<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Bytes({self})")
    }
}

impl<const N: usize> Field for Bytes<N> {
    const SIZE: usize = N;
    const WIRE: &'static str = "bytes";

    #[inline]
    fn read<O: ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self> {
        reader.array().map(Self)
    }

    #[inline]
    fn write<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        writer.array(self.0)
    }

    fn value(&self) -> Value<'_> {
        Value::Bytes(&self.0)
    }
}

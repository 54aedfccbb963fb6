//! The two sides as types, and what the optional features add to their messages.

use motion_core::side;

use crate::{DeviceMessage, HostMessage};

side! {
    /// A client, where a type says whose messages are meant.
    ///
    /// ```
    /// # #[cfg(all(feature = "alloc", feature = "bytes"))] {
    /// use kos_proto::message::Empty;
    /// use kos_proto::{Host, HostMessage, Owned};
    ///
    /// let get = HostMessage::GetDeviceInfo(Empty { tail: &[] });
    /// let kept: Owned<Host> = Owned::new(&get)?;
    /// assert_eq!(kept.message(), get);
    ///
    /// let frame: Vec<u8> = get.to_vec()?;
    /// let mut buf = Vec::new();
    /// get.encode(&mut buf)?;
    /// assert_eq!(buf, frame);
    /// # }
    /// # Ok::<(), kos_proto::EncodeError>(())
    /// ```
    pub enum Host in BE: HostMessage();
    /// A device, where a type says whose messages are meant.
    pub enum Device in BE: DeviceMessage();
}

/// Frames as a `tokio_util` codec, with a buffer of `N` bytes, at least twice [`MAX_FRAME`](crate::frame::MAX_FRAME).
///
/// For other limits, name the framing: `motion_core::codec::Codec<Kos<1024>, 2048>`.
#[cfg(feature = "tokio")]
pub type Codec<const N: usize = { 2 * crate::frame::MAX_FRAME }> = motion_core::codec::Codec<crate::Kos, N>;

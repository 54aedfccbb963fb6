//! The two sides as types, and what the optional features add to their messages.

use motion_core::side;

use crate::{DeviceMessage, HostMessage};

side! {
    /// The master, where a type says whose messages are meant.
    ///
    /// ```
    /// # #[cfg(all(feature = "alloc", feature = "bytes"))] {
    /// use hoot_proto::message::Stop;
    /// use hoot_proto::{Address, Host, HostMessage, Owned};
    ///
    /// let stop = HostMessage::Stop(Stop {});
    /// let kept: Owned<Host> = Owned::new(&stop)?;
    /// assert_eq!(kept.message(), stop);
    ///
    /// let frame: Vec<u8> = stop.to_vec(Address::DEFAULT)?;
    /// let mut buf = Vec::new();
    /// stop.encode(Address::DEFAULT, &mut buf)?;
    /// assert_eq!(buf, frame);
    /// # }
    /// # Ok::<(), hoot_proto::EncodeError>(())
    /// ```
    pub enum Host in BE: HostMessage(to: crate::Address);
    /// A node, where a type says whose messages are meant.
    pub enum Device in BE: DeviceMessage();
}

/// Frames as a `tokio_util` codec, with a buffer of `N` bytes, at least twice [`MAX_FRAME`](crate::frame::MAX_FRAME).
///
/// For a node, or for other limits, name the framing: `motion_core::codec::Codec<Strict, 84>`.
#[cfg(feature = "tokio")]
pub type Codec<const N: usize = { 2 * crate::frame::MAX_FRAME }> = motion_core::codec::Codec<crate::Hoot, N>;

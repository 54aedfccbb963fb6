//! Both sides as types, and functions that optional features add to their messages.

use motion_core::side;

use crate::frame::{Hoot, ReplyEnvelope, RequestEnvelope};
use crate::lint::Context;
use crate::{DeviceMessage, HostMessage};

side! {
    /// Side of the master, where a type parameter selects the messages.
    ///
    /// ```
    /// # #[cfg(all(feature = "alloc", feature = "bytes"))] {
    /// use hoot_proto::message::Stop;
    /// use hoot_proto::{Address, Host, HostMessage, Owned};
    ///
    /// let stop = HostMessage::from(Stop {});
    /// let owned: Owned<Host> = Owned::new(&stop)?;
    /// assert_eq!(owned.message(), stop);
    ///
    /// let frame: Vec<u8> = stop.to_vec(Address::DEFAULT)?;
    /// let mut buf = Vec::new();
    /// stop.encode(Address::DEFAULT, &mut buf)?;
    /// assert_eq!(buf, frame);
    /// # }
    /// # Ok::<(), hoot_proto::EncodeError>(())
    /// ```
    pub enum Host in BE: HostMessage(to: crate::Address) by RequestEnvelope, or other, over Hoot, lint Context;
    /// Side of a node, where a type parameter selects the messages.
    pub enum Device in BE: DeviceMessage() by ReplyEnvelope, or other, over Hoot, lint Context;
}

//! Sides of the protocol as types, and the methods that optional features add to their messages.

use motion_core::side;

use crate::frame::Enclosed;
use crate::lint::Context;
use crate::{DeviceMessage, HostMessage};

side! {
    /// Side of Dragonframe, for type parameters that choose the messages of a side.
    ///
    /// ```
    /// # #[cfg(all(feature = "alloc", feature = "bytes"))] {
    /// use dmc_proto::message::HiRequest;
    /// use dmc_proto::{Host, HostMessage, MessageId, Owned};
    ///
    /// let hi = HostMessage::from(HiRequest::default());
    /// let kept: Owned<Host> = Owned::new(&hi)?;
    /// assert_eq!(kept.message(), hi);
    ///
    /// let frame: Vec<u8> = hi.to_vec(MessageId(1))?;
    /// let mut buf = Vec::new();
    /// hi.encode(MessageId(1), &mut buf)?;
    /// assert_eq!(buf, frame);
    /// # }
    /// # Ok::<(), dmc_proto::EncodeError>(())
    /// ```
    pub enum Host in LE: HostMessage(id: crate::MessageId) by Enclosed<true>, over crate::Dmc, lint Context<'_>;
    /// Side of a controller, for type parameters that choose the messages of a side.
    pub enum Device in LE: DeviceMessage(id: crate::MessageId) by Enclosed<false>, over crate::Dmc, lint Context<'_>;
}

//! Types that name the two sides, and the methods of their messages: decoding, encoding, and the methods that the
//! features add.

use motion_core::side;

use crate::lint::Context;
use crate::{DeviceMessage, HostMessage, Kos};

side! {
    /// Side of the client.
    ///
    /// ```
    /// # #[cfg(all(feature = "alloc", feature = "bytes"))] {
    /// use kos_proto::message::GetDeviceInfo;
    /// use kos_proto::{Host, HostMessage, Owned};
    ///
    /// let get = HostMessage::from(GetDeviceInfo::default());
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
    pub enum Host in BE: HostMessage() by Kos, over Kos, lint Context<'_>;
    /// Side of the device.
    pub enum Device in BE: DeviceMessage() by Kos, over Kos, lint Context<'_>;
}

//! Each side of each protocol, for the laws of messages.

use laws::message::Side;
use motion_core::lint::Lints;

macro_rules! sides {
    ($($(#[$meta:meta])* $name:ident: $message:ident of $protocol:ident, big endian $big_endian:literal;)*) => {$(
        $(#[$meta])*
        pub struct $name;

        impl Side for $name {
            type Message<'a> = $protocol::$message<'a>;
            const BIG_ENDIAN: bool = $big_endian;

            fn lint(message: &Self::Message<'_>) -> Lints {
                message.lint(&$protocol::lint::Context::default())
            }
        }
    )*};
}
sides! {
    /// A kOS client.
    KosHost: HostMessage of kos_proto, big endian true;
    /// A kOS device.
    KosDevice: DeviceMessage of kos_proto, big endian true;
    /// Dragonframe.
    DmcHost: HostMessage of dmc_proto, big endian false;
    /// A DMC controller.
    DmcDevice: DeviceMessage of dmc_proto, big endian false;
    /// A MoCoBus master.
    HootHost: HostMessage of hoot_proto, big endian true;
    /// A MoCoBus node.
    HootDevice: DeviceMessage of hoot_proto, big endian true;
}

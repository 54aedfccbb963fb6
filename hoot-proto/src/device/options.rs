//! What a node is, beside what its master sets.

use crate::frame::Address;
use crate::message::{Name, Version};
use crate::query::Profile;

/// What the node is from the start on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Options {
    /// Its address, 2 to 255. Default: [`Address::DEFAULT`], which is every new node's (hoot, section 1).
    pub address: Address,
    /// What it is called. Default: `DEFAULT` and three spaces, which is what a new node says (hoot, section 1.2).
    pub name: StoredName,
    /// Which firmware it answers like. Default: [`Profile::Sheet`], which the published sheet describes.
    pub profile: Profile,
    /// In what it copies firmware that harms or misleads. Default: in nothing.
    pub quirks: Quirks,
    /// After how many milliseconds without a command the dead-man stops the motors. Default: 1000 (hoot, section 4.3).
    pub dead_man: u16,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            address: Address::DEFAULT,
            name: StoredName::DEFAULT,
            profile: Profile::Sheet,
            quirks: Quirks::NONE,
            dead_man: 1000,
        }
    }
}

impl Options {
    /// The same at another address; the address stays as it is, if no node can have the new one.
    #[must_use]
    pub const fn with_address(self, address: Address) -> Self {
        if address.is_node() { Self { address, ..self } } else { self }
    }

    /// The same with another name.
    #[must_use]
    pub const fn with_name(self, name: StoredName) -> Self {
        Self { name, ..self }
    }

    /// The same as firmware of another age.
    #[must_use]
    pub const fn with_profile(self, profile: Profile) -> Self {
        Self { profile, ..self }
    }

    /// The same with other quirks.
    #[must_use]
    pub const fn with_quirks(self, quirks: Quirks) -> Self {
        Self { quirks, ..self }
    }

    /// The same with another dead-man time, at least 1 ms.
    #[must_use]
    pub const fn with_dead_man(self, dead_man: u16) -> Self {
        Self { dead_man: if dead_man == 0 { 1 } else { dead_man }, ..self }
    }

    /// What it says of its version: the first of its profile, and 6 where that is not known.
    #[must_use]
    pub const fn version(&self) -> Version {
        Version(match self.profile {
            Profile::January2015 => 32,
            Profile::V033 => 33,
            Profile::V035 => 35,
            Profile::V070 => 70,
            Profile::Unknown | Profile::Library20140925 | Profile::Sheet => 6,
        })
    }
}

/// Habits of firmware that harm or mislead, to be switched on where a simulator has to have them.
#[expect(clippy::struct_excessive_bools, reason = "each is a habit of its own")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub struct Quirks {
    /// Refuses the controller's stop in joystick mode (safety decision 2).
    pub refuses_stop: bool,
    /// Drops the top byte of numbers of 32 bits without sign, instead of refusing those that have one: 16,777,216 steps
    /// become a run without end (hoot, section 1.2; safety decision 3).
    pub drops_top_byte: bool,
    /// Reads the missing bytes of a move as zeros, which is a run without end, instead of refusing it (decision H-1).
    pub short_moves: bool,
    /// Answers some requests twice, as [`Profile::packets`] tells.
    pub answers_twice: bool,
    /// Hears nothing for 2.5 s after its address has changed, and blinks (hoot, section 2.5; decision H-2).
    pub is_deaf: bool,
}

impl Quirks {
    /// None.
    pub const NONE: Self =
        Self { refuses_stop: false, drops_top_byte: false, short_moves: false, answers_twice: false, is_deaf: false };

    /// All that firmware of the sheet's date has.
    pub const FIRMWARE: Self =
        Self { refuses_stop: true, drops_top_byte: true, short_moves: true, answers_twice: true, is_deaf: true };
}

/// What a node keeps of a name, and answers: ten bytes. Source: hoot, section 1.2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct StoredName(pub [u8; Name::MAX]);

impl StoredName {
    /// What a new node is called.
    pub const DEFAULT: Self = Self(*b"DEFAULT   ");
}

impl From<&Name> for StoredName {
    /// NULs inside are skipped, and the rest is filled up with them.
    fn from(name: &Name) -> Self {
        let mut stored = [0; Name::MAX];
        for (place, byte) in stored.iter_mut().zip(name.as_bytes().iter().filter(|&&byte| byte != 0)) {
            *place = *byte;
        }
        Self(stored)
    }
}

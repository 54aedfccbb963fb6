//! Options of a node: what it is, apart from what its master sets.

use motion_core::{flags, options};

use crate::frame::Address;
use crate::message::{Name, Version};
use crate::query::Profile;

options! {
    /// Options of a node.
    pub struct Options {
        /// Address of the node, 2 to 255; an address that no node can have counts as the default, which is the address of
        /// every new node (hoot, section 1).
        address with_address: Address = Address::DEFAULT, by node_address;
        /// Name of the node (hoot, section 1.2).
        name with_name: StoredName = StoredName::DEFAULT;
        /// Age of the firmware that the node answers like. The default is described by the published sheet.
        profile with_profile: Profile = Profile::SHEET;
        /// Habits of firmware that the node copies, although they harm or mislead.
        quirks with_quirks: Quirks = Quirks::NONE;
        /// Time without a command after which the dead-man stops the motors, in milliseconds (hoot, section 4.3).
        dead_man with_dead_man: u16 = 1000, in 1..=u16::MAX;
    }
}

const fn node_address(address: Address) -> Address {
    if address.is_node() { address } else { Address::DEFAULT }
}

impl Options {
    /// Version of the firmware, as the node answers it.
    #[must_use]
    pub const fn version(&self) -> Version {
        self.profile().number()
    }
}

flags! {
    /// Habits of firmware that harm or mislead, for simulators that need them.
    pub struct Quirks(u16) {
        /// Refuses the stop of the controller in joystick mode (safety decision 2).
        REFUSES_STOP = 1,
        /// Drops the top byte of unsigned numbers of 32 bits, instead of refusing numbers that have one: 16,777,216 steps
        /// become a run without end (hoot, section 1.2; safety decision 3).
        DROPS_TOP_BYTE = 2,
        /// Reads the missing bytes of a move as zeros, which is a run without end, instead of refusing it (decision H-1).
        SHORT_MOVES = 4,
        /// Answers some requests twice, as [`Profile::packets`] tells.
        ANSWERS_TWICE = 8,
        /// Does nothing else for 1.5 s before it starts a program, from v0.20 on, and for 1 to 2.5 s after its address has
        /// changed: [`DeviceMachine::blocking`](super::DeviceMachine::blocking) (hoot, section 2.5; decisions H-2 and H-63).
        BLOCKS = 16,
        /// Starts with the settings of firmware, takes settings as firmware does, and reads them back so (decision H-62).
        FIRMWARE_SETTINGS = 32,
        /// Sends motors at full speed, and forgets the speed that was set ([`Profile::sends_at_full_speed`]).
        SENDS_FAST = 64,
        /// Stops motors where firmware does: at the end limit and at the home, or nowhere ([`Profile::holds_limits`]).
        FIRMWARE_LIMITS = 128,
        /// Sets motors in motion by the speed of runs in joystick mode ([`Profile::joystick_moves`]).
        JOYSTICK_MOVES = 256,
        /// Changes microsteps unasked ([`Profile::sends_in_quarter_steps`], [`Profile::start_sets_microsteps`]).
        CHANGES_MICROSTEPS = 512,
        /// Takes directions as firmware does: the setting of the direction inverts nothing, nor does a negative speed invert a
        /// run that begins. A run at speed 0 ends.
        FIRMWARE_DIRECTIONS = 1024,
        /// Takes a picture on command with the exposure only, also without a camera; or takes none
        /// ([`Profile::exposes_on_command`]).
        EXPOSES_ALWAYS = 2048,
        /// Never goes on after a pause in the modes without stops ([`Profile::resumes_moves`]).
        NEVER_RESUMES = 4096,
        /// Takes up the backlash of a motor before the first move upwards and at each change of its direction: the position
        /// goes back by it, and the way becomes longer.
        TAKES_UP_BACKLASH = 8192,
        /// Stops for photos at the places of [`Plan::at_shot`](crate::program::Plan::at_shot), takes photos that nobody asked for, ends a time lapse and begins a video as firmware does
        /// ([`Profile::takes_one_more`], [`Profile::shoots_at_start`], [`Profile::shoots_at_end`],
        /// [`Profile::ends_with_motors`], [`Profile::outlasts_photos`], [`Profile::leads_in_videos_by_photos`], [`Profile::leads_in_lapses_by_time`]).
        FIRMWARE_PHOTOS = 16_384,
        /// Sends each enabled motor whose planned move has no travel to the stop of that move, which is 0 at first, when a
        /// program without stops begins; or never ends such a program ([`Profile::sends_without_travel`]).
        MOVES_ALL = 32_768,
    }
}

impl Quirks {
    /// No habits of firmware.
    pub const NONE: Self = Self(0);

    /// All habits, which firmware of the sheet's date has.
    pub const FIRMWARE: Self = Self(u16::MAX);
}

/// Name as a node stores and answers it: ten bytes. Source: hoot, section 1.2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct StoredName(pub [u8; Name::MAX]);

impl StoredName {
    /// Name of a new node.
    pub const DEFAULT: Self = Self(*b"DEFAULT   ");
}

impl From<&Name> for StoredName {
    /// Fills the name up with NULs.
    fn from(name: &Name) -> Self {
        let mut stored = [0; Name::MAX];
        for (place, byte) in stored.iter_mut().zip(name.as_bytes()) {
            *place = *byte;
        }
        Self(stored)
    }
}

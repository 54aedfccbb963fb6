//! Types that the answer to a query can have.

use super::Profile;
use crate::message::ValueType;

/// Types that the answer to a query can have: all that are accepted, and the one that firmware sends.
///
/// Source: hoot, sections 1.2, 2.2 to 2.4, and 3.
#[derive(Clone, Copy)]
pub(crate) enum Form {
    Byte,
    UInt,
    Int,
    Long,
    ULong,
    String,
    /// 16 bits without sign, which the sheet calls an Int.
    SheetInt,
    /// Yes or no, which the firmware sends in 16 bits.
    Wide,
    /// Yes or no, which some builds send in 16 bits.
    Promoted,
    /// Hundredths with sign.
    Hundredths,
    Version,
    LeadIn,
    MaxShots,
    SpeedOrSleep,
}

impl Form {
    #[inline]
    pub(super) const fn is_taken(self, found: ValueType) -> bool {
        match self {
            Self::Byte => matches!(found, ValueType::BYTE),
            Self::UInt => matches!(found, ValueType::UINT),
            Self::Int => matches!(found, ValueType::INT),
            Self::Long => matches!(found, ValueType::LONG | ValueType::ULONG),
            Self::ULong => matches!(found, ValueType::ULONG),
            Self::String => matches!(found, ValueType::STRING),
            Self::SheetInt => matches!(found, ValueType::UINT | ValueType::INT),
            Self::Wide | Self::Promoted => matches!(found, ValueType::BYTE | ValueType::INT),
            Self::Hundredths => matches!(found, ValueType::LONG | ValueType::ULONG | ValueType::FLOAT),
            Self::Version => matches!(found, ValueType::BYTE | ValueType::ULONG),
            Self::LeadIn => matches!(found, ValueType::UINT | ValueType::INT | ValueType::ULONG),
            Self::MaxShots => matches!(found, ValueType::UINT | ValueType::ULONG),
            Self::SpeedOrSleep => matches!(found, ValueType::BYTE | ValueType::ULONG | ValueType::FLOAT),
        }
    }

    pub(crate) const fn of(self, profile: Profile) -> ValueType {
        match self {
            Self::Byte => ValueType::BYTE,
            Self::UInt | Self::SheetInt => ValueType::UINT,
            Self::Int | Self::Wide => ValueType::INT,
            Self::Long => ValueType::LONG,
            Self::ULong => ValueType::ULONG,
            Self::String => ValueType::STRING,
            Self::Promoted => profile.motor_running(),
            Self::Hundredths => profile.hundredths(),
            Self::Version => profile.version_type(),
            Self::LeadIn => profile.lead_in(),
            Self::MaxShots => profile.max_shots(),
            Self::SpeedOrSleep => profile.query_117(),
        }
    }
}

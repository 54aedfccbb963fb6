//! Name of a node, and the command that sets it.

use core::fmt;

use motion_core::wire::{
    DecodeError, EncodeError, FieldView, Fields, Message, PartKind, Row, Value, Visitor, place, print, trim_nuls,
};

/// Name for a node: 1 to 10 bytes.
///
/// The node keeps NULs inside, and fills the rest up with NULs. Source: hoot, sections 1.2 and 2.1.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Name {
    bytes: [u8; Self::MAX],
    /// Number of bytes that count; the others are zero.
    len: u8,
}

impl Name {
    pub(crate) const MAX: usize = 10;

    /// Makes a name; `None` unless it has 1 to 10 bytes and no NUL, which the node would skip.
    #[must_use]
    pub fn new(name: &str) -> Option<Self> {
        if name.as_bytes().contains(&0) { None } else { Self::from_bytes(name.as_bytes()) }
    }

    /// Makes a name from the beginning of a text, cut between two characters and before a NUL; `None` if nothing is
    /// left.
    #[must_use]
    pub fn truncated(name: &str) -> Option<Self> {
        let end = name.as_bytes().iter().position(|&byte| byte == 0).unwrap_or(name.len()).min(Self::MAX);
        // A character has at most four bytes, so one of these four places is between two characters.
        let cut = (0..4).filter_map(|back| end.checked_sub(back)).find_map(|at| name.split_at_checked(at))?;
        Self::from_bytes(cut.0.as_bytes())
    }

    /// Makes a name from any 1 to 10 bytes, as a request contains them; otherwise `None`.
    ///
    /// Names that others sent may contain NULs, and even a break.
    #[must_use]
    pub fn from_bytes(name: &[u8]) -> Option<Self> {
        let mut bytes = [0; Self::MAX];
        bytes.get_mut(..name.len())?.copy_from_slice(name);
        let len = u8::try_from(name.len()).ok().filter(|&len| len > 0)?;
        Some(Self { bytes, len })
    }

    /// Bytes of the name, with its NULs.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.len.into()).unwrap_or(&self.bytes)
    }

    /// Text of the name without the NULs at its end, if it is UTF-8.
    #[must_use]
    pub fn as_str(&self) -> Option<&str> {
        core::str::from_utf8(trim_nuls(self.as_bytes())).ok()
    }
}

motion_core::__defmt! { as this: Name => Name<'x> { bytes: &'x [u8] = this.as_bytes(), } }

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print::text(f, trim_nuls(self.as_bytes()))
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Name({self})")
    }
}

motion_core::__logged! {
    /// Gives the node a name of 1 to 10 bytes. Source: hoot, section 2.1.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct SetName {
        /// Name for the node.
        pub name: Name,
    }
}

impl<'a> Message<'a> for SetName {
    const LAYOUT: &'static [Row] = &place([Row {
        name: "name",
        wire: "text[1..=10]",
        offset: None,
        size: 1,
        part: PartKind::Rest,
        unit: "",
        element: &[],
    }]);

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        let what = "SetName";
        match (Name::from_bytes(body), body.len()) {
            (Some(name), _) => Ok(Self { name }),
            (None, 0) => Err(DecodeError::Truncated { what, needed: 1, have: 0 }),
            (None, len) => Err(DecodeError::Trailing { what, extra: len.saturating_sub(Name::MAX) }),
        }
    }

    fn encoded_len(&self) -> usize {
        self.name.as_bytes().len()
    }

    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let needed = self.encoded_len();
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        out.get_mut(..needed).ok_or(small)?.copy_from_slice(self.name.as_bytes());
        Ok(needed)
    }
}

impl Fields for SetName {
    fn fields(&self, visitor: &mut dyn Visitor) {
        let value = Value::Text(self.name.as_bytes());
        visitor.visit(&FieldView { name: "name", unit: "", value, text: &self.name });
    }
}

motion_core::__message_features! { 'a [SetName] SetName }

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    #[test]
    fn a_name_is_never_cut_unasked() {
        assert_eq!(Name::new("0123456789").unwrap().as_bytes(), b"0123456789");
        for refused in ["", "0123456789a", "a\0b", "\0"] {
            assert_eq!(Name::new(refused), None, "{}", refused.escape_debug());
        }
    }

    #[test]
    fn a_cut_name_ends_between_characters() {
        assert_eq!(Name::truncated("Dolly on rails").unwrap().as_str(), Some("Dolly on r"));
        assert_eq!(Name::truncated("123456789é").unwrap().as_str(), Some("123456789"));
        assert_eq!(Name::truncated("12345678é").unwrap().as_str(), Some("12345678é"));
        assert_eq!(Name::truncated("ab\0cd").unwrap().as_str(), Some("ab"));
        assert_eq!((Name::truncated(""), Name::truncated("\0a")), (None, None));
    }

    #[test]
    fn names_of_others_are_kept_unchanged() {
        let padded = Name::from_bytes(b"ABC\0\0\0\0\0\0\0").unwrap();
        assert_eq!((padded.as_bytes().len(), padded.as_str()), (10, Some("ABC")));
        assert_eq!(format!("{padded:?}"), "Name(\"ABC\")");
        assert_ne!(padded, Name::new("ABC").unwrap(), "other bytes");
        assert_eq!(Name::from_bytes(b"\0\0\0\0\0\xFF").unwrap().as_str(), None);
    }
}

//! Owned messages and their JSON: what holds for every message of a table, for any body.

use motion_core::owned::Owned;
use motion_core::wire::{FieldView, Fields, Messages, Side, Value};

/// Owns the message of a body, and takes it to JSON and back: the same bytes, or the same but for what a text drops.
///
/// `irregular` names the messages that no layout describes: they may be refused, but not come back as others.
///
/// # Panics
///
/// If a law is broken.
pub fn any_body<S: Side>(number: u32, body: &[u8], irregular: &[&str]) {
    there_and_back::<S>(number, body, irregular);
}

/// Holds the law, and gives the name of the message that came back.
fn there_and_back<S: Side>(number: u32, body: &[u8], irregular: &[&str]) -> Option<&'static str> {
    let owned = Owned::<S>::from_parts(number, body.to_vec());
    let message = owned.message();
    assert_eq!(Owned::new(&message).as_ref(), Ok(&owned), "{message:?} owned is itself");

    let json = serde_json::to_string(&owned).unwrap_or_else(|error| panic!("{message:?} has no JSON: {error}"));
    let again: Owned<S> = match serde_json::from_str(&json) {
        Ok(again) => again,
        Err(error) => {
            assert!(irregular.contains(&message.name()), "{json} does not come back: {error}");
            return None;
        }
    };
    if again != owned {
        assert!(has_text(&message) && body.contains(&0), "{json} comes back as {again:?}");
        assert_eq!(serde_json::to_string(&again).ok(), Some(json), "nothing but the end of a text is dropped");
    }
    Some(message.name())
}

/// Every message of the table, from bodies of every length up to 80 and a few patterns.
///
/// # Panics
///
/// If a law is broken, or a message that is not `irregular` never comes back.
pub fn table<S: Side>(irregular: &[&str]) {
    for kind in S::Message::ALL {
        let mut back = false;
        for len in 0..80_u8 {
            let patterns: [Vec<u8>; 4] = [
                vec![0; len.into()],
                vec![0xff; len.into()],
                (1..=len).collect(),
                (0..len).map(|at| at.wrapping_mul(37) ^ 0xd4).collect(),
            ];
            for body in patterns {
                back |= there_and_back::<S>(kind.number, &body, irregular) == Some(kind.name);
            }
        }
        assert!(back || irregular.contains(&kind.name), "{} never comes back", kind.name);
    }
}

fn has_text(message: &impl Fields) -> bool {
    let mut found = false;
    message.fields(&mut |field: &FieldView<'_>| found |= matches!(field.value, Value::Text(_) | Value::Secret(_)));
    found
}

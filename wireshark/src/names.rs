//! Tables of names of numbers and bits, each of them once, under the name of a field that uses it.

use std::collections::BTreeMap;

use crate::probe::{Field, Meaning, Message, Shape};
use crate::protocol::Protocol;

/// Tables of names of one protocol.
#[derive(Debug, Default)]
pub struct Names(BTreeMap<Meaning, String>);

impl Names {
    /// Tables that the messages of a protocol use.
    #[must_use]
    pub fn of(protocol: &Protocol) -> Self {
        let mut names = Self::default();
        for (field, meaning) in &protocol.names {
            names.add(field, meaning);
        }
        let groups = protocol.groups.iter().flat_map(|(_, groups)| groups);
        for message in protocol.host.iter().chain(&protocol.later).chain(&protocol.device).chain(groups) {
            all_fields(message).for_each(|field| names.add(field.name, &field.meaning));
        }
        for answer in &protocol.answers {
            answer.types.iter().for_each(|(_, meaning, _)| names.add(&snake(answer.query), meaning));
        }
        names
    }

    fn add(&mut self, field: &str, meaning: &Meaning) {
        let has_names = matches!(meaning, Meaning::Names(_) | Meaning::Flags(_) | Meaning::RingTip(_));
        if !has_names || numbered(meaning).is_some() || self.0.contains_key(meaning) {
            return;
        }
        let field = if *meaning == yes_or_no() { "yes_or_no" } else { field };
        // Two fields of one name may have different names of numbers.
        let all = std::iter::once(field.to_owned()).chain((2..).map(|number| format!("{field}_{number}")));
        let free = all.into_iter().find(|name| self.0.values().all(|taken| taken != name));
        self.0.insert(meaning.clone(), free.unwrap_or_default());
    }

    /// Name of a table.
    #[must_use]
    pub fn get(&self, meaning: &Meaning) -> Option<&str> {
        self.0.get(meaning).map(String::as_str)
    }

    /// Tables in the order of their names.
    #[must_use]
    pub fn sorted(&self) -> BTreeMap<&str, &Meaning> {
        self.0.iter().map(|(meaning, name)| (name.as_str(), meaning)).collect()
    }
}

/// Number of bits whose names are their numbers from 1.
#[must_use]
pub fn numbered(meaning: &Meaning) -> Option<usize> {
    let Meaning::Flags(bits) = meaning else { return None };
    let is_numbered =
        (1..).zip(bits).all(|(number, (bit, name))| *bit == 1 << (number - 1) && *name == number.to_string());
    is_numbered.then_some(bits.len())
}

/// Names of a number that means yes or no.
fn yes_or_no() -> Meaning {
    Meaning::Names(vec![(0, "no".to_owned()), (1, "yes".to_owned())])
}

/// Fields of a message, and those of the groups in its lists.
fn all_fields(message: &Message) -> impl Iterator<Item = &Field> {
    message.fields.iter().flat_map(|field| {
        let inner: &[Field] = match &field.shape {
            Shape::Groups(fields) | Shape::Counted(_, fields) => fields,
            _ => &[],
        };
        std::iter::once(field).chain(inner)
    })
}

/// Name such as `RunStatus` as `run_status`.
fn snake(name: &str) -> String {
    let words =
        name.chars().flat_map(|letter| letter.is_uppercase().then_some('_').into_iter().chain(letter.to_lowercase()));
    words.skip(1).collect()
}

//! Dissectors for Wireshark and the page of all messages, made from the tables of the protocols.

pub mod lua;
pub mod names;
pub mod page;
pub mod probe;
pub mod protocol;
pub mod view;

use std::path::PathBuf;

/// Files that are made from the tables: their paths from the root of the repository, and their texts.
#[must_use]
pub fn files() -> Vec<(PathBuf, String)> {
    let protocols = protocol::all();
    let mut files: Vec<_> = protocols
        .iter()
        .map(|protocol| (format!("wireshark/{}.lua", protocol.key).into(), lua::dissector(protocol)))
        .collect();
    files.push(("docs/messages.md".into(), page::page(&protocols)));
    files
}

/// Root of the repository.
#[must_use]
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

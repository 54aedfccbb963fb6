//! The dissectors and the page of all messages say what the tables say.

use std::fs;

#[test]
fn all_files_are_made_from_the_tables() {
    for (path, text) in wireshark::files() {
        let written = fs::read_to_string(wireshark::root().join(&path)).unwrap_or_default();
        assert!(written == text, "{} is not what the tables say: run `cargo run -p wireshark`", path.display());
    }
}

//! Names of public items, as `docs/api` lists them.

use std::fs;
use std::path::Path;

/// Names that the prelude of the standard library brings into every module. A glob import of a type with one of these names
/// would shadow it.
const PRELUDE: [&str; 38] = [
    "AsMut",
    "AsRef",
    "Box",
    "Clone",
    "Copy",
    "Debug",
    "Default",
    "DoubleEndedIterator",
    "Drop",
    "Eq",
    "Err",
    "ExactSizeIterator",
    "Extend",
    "Fn",
    "FnMut",
    "FnOnce",
    "From",
    "FromIterator",
    "Hash",
    "Into",
    "IntoIterator",
    "Iterator",
    "None",
    "Ok",
    "Option",
    "Ord",
    "PartialEq",
    "PartialOrd",
    "Result",
    "Send",
    "Sized",
    "Some",
    "String",
    "Sync",
    "ToString",
    "TryFrom",
    "TryInto",
    "Vec",
];

#[test]
fn no_public_type_has_a_name_of_the_prelude() {
    let api = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/api");
    let mut types = 0;
    for file in fs::read_dir(api).expect("docs/api is a folder") {
        let text = fs::read_to_string(file.expect("a file").path()).expect("a text");
        for line in text.lines() {
            let words = ["pub struct ", "pub enum ", "pub trait ", "pub type ", "pub use "];
            let Some((_, path)) = words.iter().find_map(|word| line.split_once(word)) else { continue };
            // The path ends where the generics, the supertraits or the fields begin.
            let path = path.split(['<', '(', ' ', ';']).next().unwrap_or_default();
            let mut names = path.trim_end_matches(':').rsplit("::");
            let name = names.next().unwrap_or_default();
            // Associated types belong to another type, and no import brings them in.
            if names.next().is_some_and(|parent| parent.starts_with(char::is_uppercase)) {
                continue;
            }
            assert!(!PRELUDE.contains(&name), "{line}");
            types += 1;
        }
    }
    assert!(types > 500, "{types} types are listed");
}

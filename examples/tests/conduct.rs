//! The page `docs/conduct.md` says what the tables say of each message from a host.
//!
//! `UPDATE=1 cargo test -p examples --test conduct` writes the page again.

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

use motion_core::wire::{Kind, Messages};

const HEAD: &str = "\
# Conduct of the messages from a host

This page is made from the tables of messages, and a test compares it with them. A conduct says what a message does to
motors, and whether it may be sent again after a silence. Machines, rigs and lint read the same tables.

| conduct | meaning |
|---|---|
| asks | changes nothing |
| sets | changes a setting or an output, or takes a photo; moves no motor |
| moves | a motor may start to move, or change how it moves |
| arms | prepares a motion that a later message or an operator starts |
| stops | stops motors; goes out before everything else, and again until it is confirmed |
| resets | the device starts anew or takes another address |
| by its values | the values of the message decide between two of these |

`once` means that the message is never sent twice by itself. `in sequence` means that the message belongs to an exchange of
several messages. `blocks` means that the device may hear nothing for this number of milliseconds.
";

fn chapter(page: &mut String, name: &str, digits: usize, kinds: &[Kind]) {
    let _ = write!(page, "\n## {name}\n\n| number | message | conduct |\n|---|---|---|\n");
    for Kind { number, name, conduct, .. } in kinds {
        let conduct = conduct.map_or_else(|| "by its values".to_owned(), |conduct| conduct.to_string());
        let _ = writeln!(page, "| `0x{number:0digits$x}` | {name} | {conduct} |");
    }
}

#[test]
fn the_page_of_conduct_is_made_from_the_tables() {
    let mut page = HEAD.to_owned();
    chapter(&mut page, "kOS: id, type, number of the action", 8, kos_proto::HostMessage::ALL);
    chapter(&mut page, "DMC: type", 4, dmc_proto::HostMessage::ALL);
    chapter(&mut page, "hoot: table, command, first sub-address", 6, hoot_proto::HostMessage::ALL);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/conduct.md");
    if env::var_os("UPDATE").is_some() {
        fs::write(&file, &page).expect("docs can be written");
    }
    let written = fs::read_to_string(&file).expect("docs/conduct.md exists");
    assert!(written == page, "docs/conduct.md is not what the tables say: set UPDATE=1 and run this test again");
}

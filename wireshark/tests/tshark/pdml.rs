//! What tshark prints of a capture, as PDML: an element for each item of the tree.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Frame that a dissector found.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    /// Number of the record in which the frame ends.
    pub(crate) record: usize,
    /// Items with a name, in the order of the tree.
    pub(crate) items: Vec<Item>,
}

/// Item of the tree.
#[derive(Debug)]
pub(crate) struct Item {
    /// Name without that of the protocol.
    pub(crate) name: String,
    /// Value as tshark prints it for filters.
    pub(crate) show: String,
    /// Whole text of the line.
    pub(crate) text: String,
    /// Bytes of the item.
    pub(crate) bytes: Vec<u8>,
}

impl Frame {
    /// Value of the first item under this name.
    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        self.items.iter().find(|item| item.name == name).map(|item| item.show.as_str())
    }

    /// Whether the expert information under this name is there.
    pub(crate) fn has_expert(&self, name: &str) -> bool {
        self.get(&format!("expert.{name}")).is_some()
    }
}

/// Runs tshark with the dissector of a protocol over a capture. Also returns the whole text.
pub(crate) fn dissect(protocol: &str, capture: &Path, options: &[&str]) -> (Vec<Frame>, String) {
    let script = wireshark::root().join(format!("wireshark/{protocol}.lua"));
    let output = Command::new("tshark")
        .args(["-2", "-T", "pdml", "-X", &format!("lua_script:{}", script.display()), "-r"])
        .arg(capture)
        .args(options)
        .output()
        .expect("tshark is installed: see .ci/dissectors");
    let (text, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let errors = errors.lines().filter(|line| !line.starts_with("Running as user")).collect::<Vec<_>>();
    assert!(output.status.success() && errors.is_empty(), "tshark: {errors:#?}");
    fs::remove_file(capture).expect("the capture can be removed");
    if let Some(error) = text.lines().find(|line| line.contains("Lua Error")) {
        panic!("{error}");
    }
    (frames(protocol, &text), text.into_owned())
}

fn frames(protocol: &str, text: &str) -> Vec<Frame> {
    let (start, prefix) = (format!("proto name=\"{protocol}\""), format!("{protocol}."));
    let (mut frames, mut record, mut inside) = (Vec::<Frame>::new(), 0, false);
    // Values may contain line ends, but no `<`.
    for element in text.split('<') {
        if element.starts_with("packet>") {
            record += 1;
        } else if element.starts_with("proto ") {
            inside = element.starts_with(&start);
            if inside {
                frames.push(Frame { record, items: Vec::new() });
            }
        } else if let Some(name) = attribute(element, "name").filter(|_| inside) {
            let Some(name) = name.strip_prefix(&prefix) else { continue };
            let get = |key| attribute(element, key).unwrap_or_default();
            let hex = get("value");
            let pairs = (0..hex.len() / 2).filter_map(|at| u8::from_str_radix(hex.get(2 * at..2 * at + 2)?, 16).ok());
            let item = Item { name: name.to_owned(), show: get("show"), text: get("showname"), bytes: pairs.collect() };
            frames.last_mut().expect("a frame began").items.push(item);
        }
    }
    frames
}

/// Value of an attribute of an element.
fn attribute(element: &str, key: &str) -> Option<String> {
    let (_, rest) = element.split_once(&format!(" {key}=\""))?;
    let (value, _) = rest.split_once('"')?;
    let plain = value.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&#x27;", "'");
    Some(plain.replace("&amp;", "&"))
}

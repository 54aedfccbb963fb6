//! Every decision, safety decision, section, row and law that code or a document cites is defined in `docs`, once; and
//! every test that a decision names exists.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// A protocol, with decisions, sections and rows of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Protocol {
    Dmc,
    Hoot,
    Kos,
}

impl Protocol {
    const ALL: [(&'static str, Self); 3] = [("dmc", Self::Dmc), ("hoot", Self::Hoot), ("kos", Self::Kos)];

    /// The protocol that a path or a word names, if it names exactly one.
    fn of(text: &str) -> Option<Self> {
        let text = text.to_lowercase();
        let mut named = Self::ALL.into_iter().filter(|(name, _)| text.contains(name));
        named.next().filter(|_| named.next().is_none()).map(|(_, protocol)| protocol)
    }
}

/// A thing that can be cited. Ids of decisions are unique among all protocols; the rest belongs to a protocol.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Cited {
    /// `K-F3`, `D-12`, `H-26`, `C-1`.
    Decision(String),
    Safety(Protocol, u32),
    /// `7.2`; in DMC `D5`.
    Section(Protocol, String),
    /// A row of the state tables: `7.2-4`; in DMC `D5-1`.
    Row(Protocol, String),
    Law(u32),
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// `K-F3`, `D-12`, `D-32a`, `H-26`, `C-1`.
fn is_decision(word: &str) -> bool {
    let Some((list, number)) = word.split_once('-') else { return false };
    let number = if list == "K" { number.trim_start_matches(|c: char| c.is_ascii_uppercase()) } else { number };
    ["C", "D", "H", "K"].contains(&list) && is_number(number.trim_end_matches(['a', 'b', 'c']))
}

/// `7` or `7.2`; in DMC `D5`.
fn is_section(protocol: Protocol, word: &str) -> bool {
    match protocol {
        Protocol::Dmc => word.len() == 2 && word.starts_with(['A', 'D']) && is_number(&word[1..]),
        _ => word.split_once('.').map_or_else(|| is_number(word), |(one, two)| is_number(one) && is_number(two)),
    }
}

/// `7.2-4`; in DMC `D5-1`.
fn is_row(protocol: Protocol, word: &str) -> bool {
    word.split_once('-').is_some_and(|(section, row)| is_section(protocol, section) && is_number(row))
}

/// A file of the repository. Its lines are joined, without the marks of comments, because a citation may cross lines.
struct Source {
    path: String,
    is_code: bool,
    text: String,
    /// Where each line begins in `text`.
    starts: Vec<usize>,
}

impl Source {
    fn new(path: String, is_code: bool, content: &str) -> Self {
        let (mut text, mut starts) = (String::new(), vec![]);
        for line in content.lines() {
            starts.push(text.len());
            let line = line.trim();
            let line = line.strip_prefix("//").map_or(line, |comment| comment.trim_start_matches(['/', '!']).trim());
            text.push_str(line);
            text.push(' ');
        }
        Self { path, is_code, text, starts }
    }

    /// The place of an offset, as `path:line`.
    fn at(&self, offset: usize) -> String {
        format!("{}:{}", self.path, self.starts.partition_point(|start| *start <= offset))
    }

    /// Each line with its place.
    fn lines(&self) -> impl Iterator<Item = (String, &str)> {
        let ends = self.starts.iter().copied().skip(1).chain([self.text.len()]);
        self.starts.iter().zip(ends).map(|(start, end)| (self.at(*start), self.text[*start..end].trim()))
    }

    /// The rows of all tables, cell by cell.
    fn rows(&self) -> impl Iterator<Item = (String, Vec<&str>)> {
        self.lines().filter_map(|(at, line)| {
            let row = line.strip_prefix('|')?.strip_suffix('|')?;
            Some((at, row.split('|').map(str::trim).collect()))
        })
    }
}

/// All `.rs` and `.md` files, except build products and the listings of the public API.
fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let (mut sources, mut folders): (_, Vec<PathBuf>) = (vec![], vec![root.into()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let shown = path.strip_prefix(root).unwrap().to_str().unwrap().to_owned();
            let name = path.file_name().unwrap().to_str().unwrap();
            if path.is_dir() {
                if !name.starts_with('.') && name != "target" && shown != "docs/api" {
                    folders.push(path);
                }
            } else if let Some("md" | "rs") = path.extension().and_then(OsStr::to_str) {
                let is_code = path.extension().is_some_and(|extension| extension == "rs");
                sources.push(Source::new(shown, is_code, &fs::read_to_string(&path).unwrap()));
            }
        }
    }
    sources
}

/// All that is defined, with its place; and what is wrong with the definitions.
#[derive(Default)]
struct Definitions {
    found: BTreeMap<Cited, String>,
    wrong: BTreeSet<String>,
}

impl Definitions {
    fn new(sources: &[Source]) -> Self {
        let mut definitions = Self::default();
        for source in sources {
            let Some(name) = source.path.strip_prefix("docs/") else { continue };
            match (name.split(['-', '.']).next(), Protocol::of(name)) {
                (Some("decisions"), protocol) => definitions.decisions(source, protocol),
                (Some("machines"), Some(protocol)) => {
                    for (at, cells) in source.rows().filter(|(_, cells)| is_row(protocol, cells[0])) {
                        definitions.add(Cited::Row(protocol, cells[0].into()), at);
                    }
                }
                (Some("specification"), Some(protocol)) => {
                    for (at, line) in source.lines().filter(|(_, line)| line.starts_with("##")) {
                        let number = line.split_whitespace().nth(1).filter(|word| is_section(protocol, word));
                        if let Some(number) = number {
                            definitions.add(Cited::Section(protocol, number.into()), at);
                        }
                    }
                }
                (Some("architecture"), _) => {
                    for (at, line) in source.lines().skip_while(|(_, line)| *line != "## Laws") {
                        if let Some((number, _)) = line.split_once(". ").filter(|(number, _)| is_number(number)) {
                            definitions.add(Cited::Law(number.parse().unwrap()), at);
                        }
                    }
                }
                _ => {}
            }
        }
        definitions
    }

    fn add(&mut self, cited: Cited, at: String) {
        if let Some(first) = self.found.get(&cited) {
            self.wrong.insert(format!("{at}: {cited:?} is defined in {first} already"));
        } else {
            self.found.insert(cited, at);
        }
    }

    /// The first cell of each row holds its ids. In hoot a row may name a section in place of an id.
    fn decisions(&mut self, source: &Source, protocol: Option<Protocol>) {
        for (at, cells) in source.rows() {
            if cells.len() != 4 {
                self.wrong.insert(format!("{at}: a decision has four cells"));
            }
            if cells[0] == "id" || cells[0].starts_with("--") || cells[0].starts_with("section ") {
                continue;
            }
            for id in cells[0].split(", ") {
                let safety = id.strip_prefix("safety ").map(|number| number.trim_start_matches("decision "));
                match (protocol, safety.and_then(|number| number.parse().ok())) {
                    (Some(protocol), Some(number)) => self.add(Cited::Safety(protocol, number), at.clone()),
                    _ if is_decision(id) => self.add(Cited::Decision(id.into()), at.clone()),
                    _ => {
                        self.wrong.insert(format!("{at}: {id} is not the id of a decision"));
                    }
                }
            }
        }
    }
}

/// The words of a text with their offsets. A word may contain points, dashes and underscores.
fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut offset = 0;
    text.split_inclusive(|c: char| !(c.is_alphanumeric() || "-._".contains(c))).filter_map(move |part| {
        let start = offset;
        offset += part.len();
        let word = part.trim_end_matches(|c: char| !c.is_alphanumeric());
        (!word.is_empty()).then_some((start, word))
    })
}

/// The items of a list such as `1, 2 and 4`, `2.2 to 2.4` or `K-F1 to K-F9`, with what lies between the ends of a range.
fn list(text: &str, is_item: impl Fn(&str) -> bool) -> Vec<String> {
    let (mut items, mut rest, mut from): (Vec<String>, &str, Option<String>) = (vec![], text, None);
    while let Some((_, item)) = words(rest).next().filter(|(start, word)| *start == 0 && is_item(word)) {
        if let Some(from) = from.take() {
            items.extend(between(&from, item));
        }
        items.push(item.into());
        rest = &rest[item.len()..];
        let joints = [", and ", " and ", ", ", " to "];
        let Some(joint) = joints.into_iter().find(|end| rest.starts_with(end)) else { break };
        from = (joint == " to ").then(|| item.into());
        rest = &rest[joint.len()..];
    }
    items
}

/// What lies between two ids that differ in their last number only.
fn between(from: &str, to: &str) -> Vec<String> {
    let prefix = from.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = |id: &str| id.get(prefix.len()..).and_then(|number| number.parse::<u32>().ok());
    let (Some(from), Some(to)) = (number(from), number(to)) else { return vec![] };
    (from + 1..to).map(|number| format!("{prefix}{number}")).collect()
}

/// All citations of a file, each with its offset. If neither the words nor the path say which protocol is meant, there is
/// a reading for each protocol.
fn citations(source: &Source) -> Vec<(usize, Vec<Cited>)> {
    let of_file = Protocol::of(&source.path);
    let (mut found, mut before) = (vec![], "");
    for (offset, word) in words(&source.text) {
        let here = &source.text[offset..];
        let rest = here[word.len()..].trim_start();
        let named = Protocol::of(before).or(of_file);
        let readings = |cited: &dyn Fn(Protocol) -> Cited| match named {
            Some(protocol) => vec![cited(protocol)],
            None => Protocol::ALL.map(|(_, protocol)| cited(protocol)).into(),
        };
        let mut cite = |cited: Vec<Cited>| found.push((offset, cited));
        match word {
            "safety" | "Safety" => {
                let numbers = rest.trim_start_matches("decisions ").trim_start_matches("decision ");
                for id in list(numbers, is_number) {
                    cite(readings(&|protocol| Cited::Safety(protocol, id.parse().unwrap())));
                }
            }
            // In DMC a section is a part of an upload.
            "section" | "Section" | "sections" | "Sections" if named != Some(Protocol::Dmc) => {
                // The number after that of one section is that of a command: "section 2.1, 6".
                let most = if word.ends_with('s') { usize::MAX } else { 1 };
                for id in list(rest, |word| is_section(Protocol::Kos, word)).into_iter().take(most) {
                    cite(readings(&|protocol| Cited::Section(protocol, id.clone())));
                }
            }
            "law" | "Law" | "laws" | "Laws" => {
                for id in list(rest, is_number) {
                    cite(vec![Cited::Law(id.parse().unwrap())]);
                }
            }
            "kOS" | "DMC" => {
                let protocol = if word == "DMC" { Protocol::Dmc } else { Protocol::Kos };
                let is_item = |word: &str| !is_number(word) && is_section(protocol, word);
                for id in list(rest, is_item) {
                    cite(vec![Cited::Section(protocol, id)]);
                }
            }
            _ if is_decision(word) => {
                for id in list(here, is_decision) {
                    cite(vec![Cited::Decision(id)]);
                }
            }
            _ => {}
        }
        if let Some(protocol) = of_file {
            if is_row(protocol, word) && (protocol == Protocol::Dmc || word.contains('.')) {
                cite(vec![Cited::Row(protocol, word.into())]);
            }
            if let Some(number) = word.strip_prefix("S-").filter(|number| is_number(number)) {
                cite(vec![Cited::Safety(protocol, number.parse().unwrap())]);
            }
        }
        before = word;
    }
    found
}

fn none(wrong: &BTreeSet<String>) {
    let text = wrong.iter().fold(String::new(), |mut text, line| {
        writeln!(text, "{line}").unwrap();
        text
    });
    assert!(wrong.is_empty(), "\n{text}");
}

#[test]
fn every_citation_is_defined_once() {
    let sources = sources();
    let Definitions { found, mut wrong } = Definitions::new(&sources);
    let mut kinds = BTreeMap::<_, u32>::new();
    for source in &sources {
        for (offset, readings) in citations(source) {
            let kind = format!("{:?}", readings[0]);
            *kinds.entry(kind.split('(').next().unwrap().to_owned()).or_default() += 1;
            if !readings.iter().any(|cited| found.contains_key(cited)) {
                wrong.insert(format!("{}: {:?} is not defined in docs", source.at(offset), readings[0]));
            }
        }
    }
    none(&wrong);
    println!("{kinds:?}");
    assert_eq!(kinds.len(), 5, "a kind of citation is no longer found: {kinds:?}");
    assert!(kinds.values().all(|count| *count >= 10), "{kinds:?}");
}

/// The last cell of a decision names tests between backquotes. Names in brackets after them are those of vectors.
#[test]
fn every_test_of_a_decision_exists() {
    let sources = sources();
    let code = sources.iter().filter(|source| source.is_code);
    let functions: BTreeSet<_> = code
        .flat_map(|source| source.text.split("fn ").skip(1))
        .filter_map(|function| function.split(['(', '<']).next())
        .collect();
    let mut wrong = BTreeSet::new();
    for source in sources.iter().filter(|source| source.path.starts_with("docs/decisions")) {
        for (at, cells) in source.rows() {
            let without_brackets = cells[3].split('(').map(|part| part.split_once(')').map_or(part, |(_, rest)| rest));
            for name in without_brackets.flat_map(|part| part.split('`').skip(1).step_by(2)) {
                if !name.contains('.') && !functions.contains(name.rsplit("::").next().unwrap_or(name)) {
                    wrong.insert(format!("{at}: there is no test {name}"));
                }
            }
        }
    }
    none(&wrong);
}

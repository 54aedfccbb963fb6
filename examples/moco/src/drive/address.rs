//! Addresses of rigs on the command line.

use std::net::SocketAddr;

use tokio::net::lookup_host;

use super::Trouble;
use crate::session::Target;
use crate::simulate::Protocol;

/// Address of a rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Address {
    /// Host in a network, and its port if it is given.
    Host(String, Option<u16>),
    /// Serial line.
    Serial(String),
    /// Unknown address of a rig that announces itself to this address of our computer.
    Announced(SocketAddr),
}

impl Address {
    /// Parses `HOST`, `HOST:PORT`, a serial device such as `/dev/ttyUSB0` or `COM3`, and `udp://ADDRESS:PORT`.
    ///
    /// # Errors
    ///
    /// [`Trouble::Usage`] if the text has another form, or a form that the protocol does not use.
    pub fn parse(text: &str, protocol: Protocol) -> Result<Self, Trouble> {
        let refused = |why: &str| Trouble::Usage(format!("{text:?}: {why}"));
        let is_kos = protocol == Protocol::Kos;
        if let Some(ours) = text.strip_prefix("udp://") {
            let ours = ours
                .parse()
                .map_err(|_| refused("udp:// must be followed by an address and a port of this computer"))?;
            return is_kos.then_some(Self::Announced(ours)).ok_or_else(|| refused("only kOS rigs announce themselves"));
        }
        let number = text.get(..3).filter(|start| start.eq_ignore_ascii_case("com")).and_then(|_| text.get(3..));
        if text.contains(['/', '\\']) || number.is_some_and(|number| number.parse::<u16>().is_ok()) {
            let serial = Self::Serial(text.to_owned());
            return (!is_kos)
                .then_some(serial)
                .ok_or_else(|| refused("kOS rigs have no serial line: give HOST[:PORT]"));
        }
        let (host, port) = match text.rsplit_once(':') {
            // An IPv6 address without a port contains colons.
            Some((host, port)) if !host.contains(':') || host.ends_with(']') => {
                (host, Some(port.parse().map_err(|_| refused("the colon must be followed by a port from 0 to 65535"))?))
            }
            _ => (text, None),
        };
        let host = host.trim_start_matches('[').trim_end_matches(']');
        if host.is_empty() {
            return Err(refused("give HOST[:PORT], or a serial device such as /dev/ttyUSB0 or COM3"));
        }
        if port.is_none() && !is_kos {
            return Err(refused("give HOST:PORT, or a serial device such as /dev/ttyUSB0 or COM3"));
        }
        Ok(Self::Host(host.to_owned(), port))
    }

    /// Finds the target to connect to. `baud` is the speed of a serial line, in bits per second.
    ///
    /// # Errors
    ///
    /// [`Trouble::Line`] if the name of the host cannot be resolved. An [`Announced`](Self::Announced) rig has to be
    /// discovered instead.
    pub async fn target(&self, baud: u32) -> Result<Target, Trouble> {
        match self {
            Self::Serial(path) => Ok(Target::Serial(path.clone(), baud)),
            Self::Announced(ours) => Ok(Target::Tcp(*ours)),
            Self::Host(host, port) => {
                let port = port.unwrap_or(kos_proto::discovery::DEFAULT_PORT);
                let found = lookup_host((host.as_str(), port)).await;
                let found = found.map_err(|error| Trouble::Line(format!("{host}: {error}: check the spelling")))?;
                let mut found: Vec<_> = found.collect();
                // Few rigs support IPv6.
                found.sort_by_key(SocketAddr::is_ipv6);
                let first = found.first().map(|address| Target::Tcp(*address));
                first.ok_or_else(|| Trouble::Line(format!("{host}: this host has no address")))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str, protocol: Protocol) -> Result<Address, String> {
        Address::parse(text, protocol).map_err(|trouble| trouble.to_string())
    }

    #[expect(clippy::unnecessary_wraps, reason = "the value is compared with results")]
    fn host(host: &str, port: Option<u16>) -> Result<Address, String> {
        Ok(Address::Host(host.to_owned(), port))
    }

    #[test]
    fn each_form_of_address_is_parsed() {
        for (text, expected) in [
            ("rig.local", host("rig.local", None)),
            ("10.0.0.7:99", host("10.0.0.7", Some(99))),
            ("[::1]:99", host("::1", Some(99))),
            ("[::1]", host("::1", None)),
            ("fe80::2", host("fe80::2", None)),
            ("com", host("com", None)),
            ("udp://127.0.0.1:9", Ok(Address::Announced(([127, 0, 0, 1], 9).into()))),
        ] {
            assert_eq!(parse(text, Protocol::Kos), expected, "{text}");
        }
        for text in ["/dev/ttyUSB0", "./line", "COM3", "com12", r"\\.\COM12"] {
            assert_eq!(parse(text, Protocol::Dmc), Ok(Address::Serial(text.to_owned())));
        }
        assert_eq!(parse("rig:5521", Protocol::Hoot), host("rig", Some(5521)));
    }

    #[test]
    fn a_wrong_address_is_refused_with_the_reason() {
        for (text, protocol, expected) in [
            ("", Protocol::Kos, "\"\": give HOST[:PORT]"),
            ("rig", Protocol::Dmc, "\"rig\": give HOST:PORT, or a serial device"),
            ("rig:port", Protocol::Dmc, "\"rig:port\": the colon must be followed by a port"),
            ("/dev/ttyUSB0", Protocol::Kos, "\"/dev/ttyUSB0\": kOS rigs have no serial line"),
            ("udp://rig", Protocol::Kos, "\"udp://rig\": udp:// must be followed by an address"),
            ("udp://127.0.0.1:9", Protocol::Hoot, "only kOS rigs announce themselves"),
        ] {
            let error = parse(text, protocol).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}

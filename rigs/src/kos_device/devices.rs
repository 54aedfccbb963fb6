//! Devices and quirks of kOS by name.

use kos_proto::device::{Options, Quirks};

use super::Setup;
use crate::device::{Choice, Named};

impl Named for Setup {
    const PROTOCOL: &'static str = "kOS";

    const DEVICES: &'static [Choice<Self>] =
        &[Choice { name: "mild", about: "As the document means it.", apply: mild }];

    const QUIRKS: &'static [Choice<Self>] = &[
        Choice {
            name: "older-dialect",
            about: "The device speaks the older dialect.",
            apply: |setup| setup.older_dialect = true,
        },
        Choice {
            name: "begin-nonzero",
            about: "The count of positions stays when a range is marked.",
            apply: |setup| setup.add(Quirks::BEGIN_NONZERO),
        },
        Choice {
            name: "empty-password",
            about: "A client has to send the password, although it is empty.",
            apply: |setup| setup.add(Quirks::REQUIRE_EMPTY_PASSWORD),
        },
        Choice {
            name: "stop-when-alone",
            about: "A move is stopped when the last client is gone.",
            apply: |setup| setup.options = setup.options.with_stop_when_alone(true),
        },
        Choice {
            name: "push-address",
            about: "The address is sent over TCP every five seconds.",
            apply: |setup| setup.options = setup.options.with_push_every(Some(5000)),
        },
        Choice {
            name: "no-progress",
            about: "The progress of a live move is not reported.",
            apply: |setup| setup.options = setup.options.with_progress_every(None),
        },
    ];
}

/// Takes everything back that a device or a quirk decides.
fn mild(setup: &mut Setup) {
    setup.options = Options::default();
    setup.older_dialect = false;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_quirk_has_a_name() {
        let names: Vec<_> = Setup::QUIRKS.iter().map(|choice| choice.name).collect();
        let all = Setup::default().with_quirks(&names.join(",")).unwrap();
        assert!(all.older_dialect && all.options.stop_when_alone());
        assert_eq!(all.options.quirks(), Quirks::BEGIN_NONZERO | Quirks::REQUIRE_EMPTY_PASSWORD);
        assert_eq!((all.options.push_every(), all.options.progress_every()), (Some(5000), None));
        let error = Setup::default().with_quirks("loud").unwrap_err().to_string();
        assert!(error.starts_with("kOS has no quirk \"loud\": it has older-dialect, "), "{error}");
        assert_eq!(Setup::with_motors(99).motors.len(), 10);
        assert_eq!(all.with_device("mild"), Ok(Setup::default()));
    }
}

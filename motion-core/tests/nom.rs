//! The nom parsers agree with a rescan, and report how many bytes are missing.

#[allow(dead_code, reason = "the framings of the stream tests, without their rescans")]
#[path = "stream/framings.rs"]
mod framings;

use framings::{Dmc, Hoot, Kos, dmc_frame, dmc_rescan, hoot_frame, hoot_rescan, kos_frame, kos_rescan};
use motion_core::nom::{complete, streaming};
use motion_core::stream::Framing;
use nom::error::{Error, ErrorKind};
use nom::{Err, Needed};
use proptest::collection::vec;
use proptest::prelude::*;

/// Compares both parsers with a rescan, for bytes of any kind.
fn assert_agreement<'a, F: Framing>(input: &'a [u8], rescan: impl Fn(&[u8]) -> Result<usize, usize>) {
    let found = complete::frame::<F, Error<&'a [u8]>>(input);
    match rescan(input) {
        Ok(len) => {
            let (rest, frame) = found.as_ref().unwrap_or_else(|error| panic!("{error:?}"));
            assert_eq!((frame.as_ref(), *rest), input.split_at(len));
        }
        Err(_) => assert!(found.is_err(), "no frame"),
    }
    let cut = |error: &Err<Error<&[u8]>>| matches!(error, Err::Error(error) if error.code == ErrorKind::Eof);
    match (streaming::frame::<F, Error<&'a [u8]>>(input), found) {
        (Err(Err::Incomplete(Needed::Size(more))), Err(error)) => {
            assert!(cut(&error), "{error:?}");
            assert!(input.len() + more.get() <= F::MAX, "it asks for more than the longest frame");
        }
        (Err(one), Err(other)) => assert_eq!(one, other),
        (Ok((one, _)), Ok((other, _))) => assert_eq!(one, other),
        _ => panic!("only one of the parsers finds a frame"),
    }
}

/// Feeds a frame in pieces of the lengths that the parser asks for.
fn assert_asks_for_missing_bytes<F: Framing>(frame: &[u8]) {
    let mut asked = 0;
    let mut have = 0;
    while have < frame.len() {
        let Err(Err::Incomplete(Needed::Size(more))) = streaming::frame::<F, Error<&[u8]>>(&frame[..have]) else {
            panic!("{have} of {} bytes", frame.len())
        };
        have += more.get();
        asked += 1;
    }
    assert_eq!(have, frame.len(), "it asks for no byte after the frame");
    assert!(asked <= 3, "one question each for an empty input, a marker and a header: {asked}");
    assert!(matches!(streaming::frame::<F, Error<&[u8]>>(frame), Ok((&[], _))));
}

#[test]
fn a_parser_asks_for_the_missing_bytes() {
    assert_asks_for_missing_bytes::<Dmc<400>>(&dmc_frame(1, 2, &[7; 300]));
    assert_asks_for_missing_bytes::<Kos<400>>(&kos_frame(1, &[7; 300]));
    assert_asks_for_missing_bytes::<Hoot>(&hoot_frame([1, 2, 3], &[7; 30]));
}

#[test]
fn each_error_has_its_kind() {
    let kind = |error: Err<Error<&[u8]>>| match error {
        Err::Error(error) => (error.code, "error"),
        Err::Failure(error) => (error.code, "failure"),
        Err::Incomplete(_) => (ErrorKind::Eof, "incomplete"),
    };
    let dmc = |bytes: &[u8]| streaming::frame::<Dmc<40>, Error<&[u8]>>(bytes).map(drop).map_err(kind);
    let mut bad = dmc_frame(1, 2, b"data");
    bad[12] ^= 1;
    assert_eq!(dmc(&bad), Err((ErrorKind::Verify, "error")));
    assert_eq!(dmc(&dmc_frame(1, 2, &[0; 29])), Err((ErrorKind::TooLarge, "error")));
    assert_eq!(dmc(b"xDF"), Err((ErrorKind::Tag, "error")));
    let kos = streaming::frame::<Kos<40>, Error<&[u8]>>(&[5, 0, 6]).map(drop).map_err(kind);
    assert_eq!(kos, Err((ErrorKind::Tag, "failure")));
}

proptest! {
    #[test]
    fn the_parsers_find_what_a_rescan_finds(
        data in vec(any::<u8>(), 0..50),
        rest in vec(any::<u8>(), 0..20),
        cut in any::<prop::sample::Index>(),
        flip in any::<prop::sample::Index>(),
        by in prop_oneof![Just(0), any::<u8>()],
    ) {
        let damage = |frame: Vec<u8>| {
            let mut bytes = [frame, rest.clone()].concat();
            bytes.truncate(1 + cut.index(bytes.len()));
            let at = flip.index(bytes.len());
            bytes[at] ^= by;
            bytes
        };
        assert_agreement::<Dmc<40>>(&damage(dmc_frame(1, 2, &data)), dmc_rescan(40));
        assert_agreement::<Kos<40>>(&damage(kos_frame(1, &data)), kos_rescan(40));
        assert_agreement::<Hoot>(&damage(hoot_frame([1, 2, 3], &data[..data.len().min(40)])), hoot_rescan);
    }
}

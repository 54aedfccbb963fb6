//! Laws of streams: any bytes, cut anywhere, with gaps anywhere, through the framing of each protocol.
//!
//! Input: the protocol, the number of pieces and their lengths, which repeat, the number of gaps and their places
//! (`u16`, little-endian), then the stream.

#![no_main]

use dmc_proto::frame::{Dmc, MAX_FRAME};
use fuzz::rescan;
use hoot_proto::frame::{Hoot, MAX_DATA, Strict};
use kos_proto::frame::Kos;
use laws::stream::check;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let _ = run(input);
});

/// Short limits besides the usual ones: more frames are too long, and buffers move more often.
fn run(input: &[u8]) -> Option<()> {
    let (&protocol, rest) = input.split_first()?;
    let (&pieces, rest) = rest.split_first()?;
    let (pieces, rest) = rest.split_at_checked(pieces.into())?;
    let (&gaps, rest) = rest.split_first()?;
    let (gaps, stream) = rest.split_at_checked(usize::from(gaps) * 2)?;

    let mut pieces = pieces.iter().map(|&len| usize::from(len)).chain([1]).cycle();
    let mut cut = || pieces.next().unwrap_or(1);
    let mut gaps: Vec<usize> = gaps.chunks_exact(2).map(|at| usize::from(at[0]) | usize::from(at[1]) << 8).collect();
    gaps.sort_unstable();

    match protocol % 3 {
        0 => {
            check::<Kos<1024>, 2048>(stream, &gaps, &mut cut, |rest| rescan::kos(rest, 1024));
            check::<Kos<16>, 32>(stream, &gaps, cut, |rest| rescan::kos(rest, 16));
        }
        1 => {
            check::<Dmc, { 2 * MAX_FRAME }>(stream, &gaps, &mut cut, |rest| rescan::dmc(rest, MAX_FRAME));
            check::<Dmc<64>, 128>(stream, &gaps, cut, |rest| rescan::dmc(rest, 64));
        }
        _ => {
            check::<Hoot, 84>(stream, &gaps, &mut cut, |rest| rescan::hoot(rest, MAX_DATA));
            check::<Hoot<4>, 28>(stream, &gaps, &mut cut, |rest| rescan::hoot(rest, 4));
            check::<Strict, 84>(stream, &gaps, cut, |rest| rescan::hoot_strict(rest, MAX_DATA));
        }
    }
    Some(())
}

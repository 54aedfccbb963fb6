//! Everything that the libraries do with bytes that nobody has checked.

use core::fmt::{self, Write};

use dmc_proto::frame::{Dmc, MessageId, MessageType};
use motion_core::fletcher::{self, Sum};
use motion_core::stream::{Frames, Framing, Item};
use motion_core::wire::{DecodeError, Messages};

/// Bytes that a message is encoded into: some are too long for it, and that must not panic either.
const ROOM: usize = 512;

/// Does it all, and prints what it finds: what is not used would not be in the program.
pub fn everything(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    checksums(input, out)?;
    dmc(input, out)
}

fn checksums(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    let (front, back) = input.split_at_checked(input.len() / 3).unwrap_or_default();
    let (first, whole) = (Sum::of(front), Sum::of(input));
    let joined = first.update(back) == first.then(Sum::of(back), back.len());
    let apart = whole.after(first, back.len());
    writeln!(out, "{whole:?} {apart:?} {joined} {} {:?}", fletcher::verify(input), whole.check_bytes())
}

fn dmc(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use dmc_proto::{DeviceMessage, HostMessage};

    stream::<Dmc, 4096>(input, out, |frame, out| {
        let number = u32::from(frame.kind().0);
        for payload in [frame.payload(), frame.bytes()] {
            message(HostMessage::decode_body(number, payload), out)?;
            message(DeviceMessage::decode_body(number, payload), out)?;
        }
        let mut room = [0; ROOM];
        let encoded = dmc_proto::frame::encode(frame.id(), MessageType(3), frame.payload(), &mut room);
        let again = HostMessage::decode(&frame).map(|message| message.encode_into(MessageId(1), &mut room));
        writeln!(out, "{encoded:?} {again:?} {frame:?} {:?}", dmc_proto::Frame::decode(input))
    })
}

/// Feeds `input` in pieces of uneven lengths, with gaps and resets between some of them.
fn stream<F: Framing, const N: usize>(
    input: &[u8],
    out: &mut dyn Write,
    with_frame: impl Fn(F::Frame<'_>, &mut dyn Write) -> fmt::Result,
) -> fmt::Result {
    let mut frames = Frames::<F, N>::new();
    let mut rest = input;
    let mut turn = 0_usize;
    while !rest.is_empty() {
        turn = turn.wrapping_add(1);
        let piece = rest.get(..turn.wrapping_mul(37) % 300).unwrap_or(rest);
        let taken = frames.push(piece);
        rest = rest.get(taken..).unwrap_or_default();
        if turn % 5 == 0 || rest.is_empty() {
            frames.gap();
        }
        items(&mut frames, out, &with_frame)?;
        if turn % 50 == 0 {
            frames.reset();
        }
    }
    writeln!(out, "{frames:?} {}", frames.work())
}

fn items<F: Framing, const N: usize>(
    frames: &mut Frames<F, N>,
    out: &mut dyn Write,
    with_frame: &impl Fn(F::Frame<'_>, &mut dyn Write) -> fmt::Result,
) -> fmt::Result {
    while let Some(item) = frames.next() {
        match item {
            Item::Frame(frame) => with_frame(frame, out)?,
            Item::Corrupt { header, why, bytes } => writeln!(out, "{header:?} {why} {why:?} {bytes:?}")?,
            Item::Noise { bytes, why } => writeln!(out, "{why} {why:?} {bytes:?}")?,
            Item::Fatal(why) => {
                writeln!(out, "{why} {why:?}")?;
                frames.resync();
            }
        }
    }
    Ok(())
}

/// Prints a message both ways, and encodes it.
fn message<'a, M: Messages<'a>>(decoded: Result<M, DecodeError>, out: &mut dyn Write) -> fmt::Result {
    let mut room = [0; ROOM];
    match decoded {
        Ok(message) => {
            let encoded = message.encode_body(&mut room);
            writeln!(out, "{} {message} {message:?} {encoded:?}", message.number())?;
            encoded.err().map_or(Ok(()), |error| writeln!(out, "{error}"))
        }
        Err(error) => writeln!(out, "{error}"),
    }
}

//! Complete parsers of other protocols, each with its own traffic: from a stream with checksums to typed messages.
//!
//! Protocols differ, so times are compared for each message. There are 2000 messages in random order: 60 % of a short
//! kind, 30 % of a longer kind and 10 % of a third kind. Each reader adds up all fields. Messages of ublox have 28, 36
//! and 44 bytes, messages of mavlink 24 and 40 bytes. Raw numbers are added, before scaling.

use benches::traffic::Tally;
use mavlink::dialects::common::{ATTITUDE_DATA, GLOBAL_POSITION_INT_DATA, MavMessage, SYSTEM_TIME_DATA};
use mavlink::{MavHeader, MavlinkReader, MavlinkVersion, write_v2_msg};
use ublox::proto23::PacketRef;
use ublox::{Parser, UbxPacket};

/// Bytes of a stream, and the result that a reader must find.
pub(crate) struct Stream {
    pub(crate) bytes: Vec<u8>,
    pub(crate) tally: Tally,
}

/// Kinds of the messages in order, with the same shares for all protocols.
fn kinds() -> impl Iterator<Item = (u32, u32)> {
    let mut seed = 0x2545_F491_u32;
    std::iter::repeat_with(move || {
        seed ^= seed << 13;
        seed ^= seed >> 17;
        seed ^= seed << 5;
        (seed % 10, seed)
    })
    .take(2000)
}

fn total(numbers: impl IntoIterator<Item = u32>) -> u32 {
    numbers.into_iter().fold(0, u32::wrapping_add)
}

pub(crate) fn mavlink() -> Stream {
    let mut stream = Stream { bytes: Vec::new(), tally: Tally::default() };
    for (kind, number) in kinds() {
        // The highest byte is never 0, because the format leaves out trailing zeros.
        let (int, float) = (number.cast_signed() | 0x0101_0101, f32::from_bits(0x3F80_0001 | number >> 9));
        let short = i16::from_be_bytes([1, 1]);
        let message = match kind {
            0..6 => MavMessage::SYSTEM_TIME(SYSTEM_TIME_DATA {
                time_unix_usec: number.into(),
                time_boot_ms: int.cast_unsigned(),
            }),
            6..9 => MavMessage::ATTITUDE(ATTITUDE_DATA {
                time_boot_ms: number,
                roll: float,
                pitch: float,
                yaw: float,
                rollspeed: float,
                pitchspeed: float,
                yawspeed: float,
            }),
            _ => MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
                time_boot_ms: number,
                lat: int,
                lon: int,
                alt: int,
                relative_alt: int,
                vx: short,
                vy: short,
                vz: short,
                hdg: 0x0101,
            }),
        };
        stream.tally.add(sum_of_mavlink(&message));
        write_v2_msg(&mut stream.bytes, MavHeader::default(), &message).expect("writing to a vector does not fail");
    }
    stream
}

fn sum_of_mavlink(message: &MavMessage) -> u32 {
    match message {
        MavMessage::SYSTEM_TIME(it) => total([(it.time_unix_usec & 0xFFFF_FFFF) as u32, it.time_boot_ms]),
        MavMessage::ATTITUDE(it) => {
            let floats = [it.roll, it.pitch, it.yaw, it.rollspeed, it.pitchspeed, it.yawspeed];
            total(floats.map(f32::to_bits)).wrapping_add(it.time_boot_ms)
        }
        MavMessage::GLOBAL_POSITION_INT(it) => {
            let ints = [it.lat, it.lon, it.alt, it.relative_alt, it.vx.into(), it.vy.into(), it.vz.into()];
            total(ints.map(i32::cast_unsigned)).wrapping_add(it.time_boot_ms).wrapping_add(it.hdg.into())
        }
        _ => 0,
    }
}

pub(crate) fn read_mavlink(stream: &[u8]) -> Tally {
    let (mut reader, mut tally) = (MavlinkReader::new(stream), Tally::default());
    while let Ok((_, message)) = reader.read_message::<MavMessage>(MavlinkVersion::V2) {
        tally.add(sum_of_mavlink(&message));
    }
    tally
}

pub(crate) fn ublox() -> Stream {
    let mut stream = Stream { bytes: Vec::new(), tally: Tally::default() };
    for (kind, number) in kinds() {
        let (id, numbers) = match kind {
            0..6 => (0x22, 5),
            6..9 => (0x02, 7),
            _ => (0x12, 9),
        };
        let start = stream.bytes.len();
        stream.bytes.extend([0xB5, 0x62, 0x01, id, numbers * 4, 0]);
        stream.bytes.extend((1..=numbers).flat_map(|times| number.wrapping_mul(times.into()).to_le_bytes()));
        let (mut a, mut b) = (0_u8, 0_u8);
        for &byte in &stream.bytes[start + 2..] {
            a = a.wrapping_add(byte);
            b = b.wrapping_add(a);
        }
        stream.bytes.extend([a, b]);
        stream.tally.add(total((1..=u32::from(numbers)).map(|times| number.wrapping_mul(times))));
    }
    stream
}

pub(crate) fn read_ublox(parser: &mut Parser<Vec<u8>>, stream: &[u8]) -> Tally {
    let mut tally = Tally::default();
    let mut packets = parser.consume_ubx(stream);
    while let Some(Ok(UbxPacket::Proto23(packet))) = packets.next() {
        let sum = match packet {
            PacketRef::NavClock(it) => total([
                it.itow_raw(),
                it.clk_bias_raw().cast_unsigned(),
                it.clk_drift_raw().cast_unsigned(),
                it.time_acc_raw(),
                it.freq_acc_raw(),
            ]),
            PacketRef::NavPosLlh(it) => total([
                it.itow(),
                it.lon_degrees_raw().cast_unsigned(),
                it.lat_degrees_raw().cast_unsigned(),
                it.height_meters_raw().cast_unsigned(),
                it.height_msl_raw().cast_unsigned(),
                it.h_ack_raw(),
                it.v_acc_raw(),
            ]),
            PacketRef::NavVelNed(it) => total([
                it.itow(),
                it.vel_north_raw().cast_unsigned(),
                it.vel_east_raw().cast_unsigned(),
                it.vel_down_raw().cast_unsigned(),
                it.speed_3d_raw(),
                it.ground_speed_raw(),
                it.heading_degrees_raw().cast_unsigned(),
                it.speed_accuracy_estimate_raw(),
                it.course_heading_accuracy_estimate_raw(),
            ]),
            _ => 0,
        };
        tally.add(sum);
    }
    tally
}

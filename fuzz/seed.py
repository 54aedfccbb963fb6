#!/usr/bin/env python3
"""Makes the seeds of the fuzz targets from the conformance vectors.

`seed.py` writes the seeds. `seed.py --check` fails if the files in seeds/ differ from them. Files whose name does not
begin with "vector-" stay as they are: the fuzzers found them.
"""

import json
import sys
from pathlib import Path

HERE = Path(__file__).parent
VECTORS = HERE.parent / "vectors"
PROTOCOLS = ["kos", "dmc", "hoot"]


def vectors(name):
    return json.loads((VECTORS / f"{name}.json").read_text())


def fletcher():
    """Two bytes with the place of the cut, and the bytes to be summed."""
    for vector in vectors("fletcher16")["vectors"]:
        if "hex" in vector and vector["len"] > 0:
            data = bytes.fromhex(vector["hex"])
            yield f"{vector['fill']}-{len(data)}", (len(data) // 3).to_bytes(2, "little") + data


def stream():
    """The protocol, the lengths of the pieces, the places of the gaps, and the stream: a frame, noise, a broken frame,
    ten more frames."""
    for number, protocol in enumerate(PROTOCOLS):
        frames = [bytes.fromhex(vector["hex"]) for vector in vectors(protocol) if "usb" not in vector.get("kind", "")]
        frames = [frame for frame in frames if 0 < len(frame) <= 200]
        for at in range(0, len(frames) - 12, max(1, len(frames) // 8)):
            broken = frames[at + 1][:-1] + bytes([frames[at + 1][-1] ^ 1])
            data = frames[at] + b"noise" + broken + b"".join(frames[at + 2 : at + 12])
            pieces = [1, 3, 64, 7]
            gaps = [len(frames[at]) + 5, len(data) // 2]
            head = bytes([number, len(pieces), *pieces, len(gaps)])
            yield f"{protocol}-{at}", head + b"".join(gap.to_bytes(2, "little") for gap in gaps) + data


def decode():
    """Side, number in the tables and body: one message for each number and each eight bytes of length."""
    chosen = {}
    for side, number, body in [*kos_bodies(), *dmc_bodies(), *hoot_bodies()]:
        if len(body) <= 300:
            # In hoot the last byte is the part of the node. The commands without it are enough seeds.
            kind = number >> 8 if side == 4 else number
            chosen.setdefault(f"{PROTOCOLS[side // 2]}-{side}-{kind:x}-{len(body) // 8}", bytes([side]) + number.to_bytes(4, "little") + body)
    return chosen.items()


def dmc_differential():
    """Whole frames: one for each type, direction and eight bytes of length."""
    chosen = {}
    for vector in vectors("dmc"):
        frame = bytes.fromhex(vector["hex"])
        if len(frame) <= 700:
            chosen.setdefault(f"{vector['direction'][0]}-{int.from_bytes(frame[6:8], 'little'):x}-{len(frame) // 8}", frame)
    return chosen.items()


def dmc_round_trip():
    """Id, type and data."""
    return [(name, frame[2:8] + frame[10:-2]) for name, frame in dmc_differential()]


def dmc_stream():
    """Operations: a frame, noise, one with a wrong byte, a gap, one cut off, a wrong length, one more frame; pieces."""
    frames = [frame for _, frame in dmc_differential() if len(frame) <= 60]
    for at in range(0, len(frames) - 4, 7):
        kind_and_data = [bytes([len(frame) - 12]) + frame[6:8] + frame[10:-2] + b"\x0b" for frame in frames[at : at + 4]]
        one, wrong, cut, last = kind_and_data
        pieces = b"\x07\x03\x07\x40\x07\x01"
        yield f"{at}", pieces + b"\0" + one + b"\x05\x03DDF\x03" + wrong + b"\x06\0\x02" + cut + b"\x04\x40\0" + last


def dmc_upload():
    """Operations: the begin, sections of all three kinds, with gaps and repeats, the end."""
    begin, end = bytes([0, 0, 2, 41, 0]), bytes([1, 0])
    axis = lambda motor, start, values: bytes([2, start, motor, len(values), *values])
    dmx = lambda channel, start, values: bytes([9, start, channel, len(values), *values])
    triggers = lambda mask, pairs: bytes([13, 0, mask, len(pairs), *[part for pair in pairs for part in pair], 0])
    # From 150 on, the start index has the bit of the last section.
    yield "whole", begin + axis(1, 0, range(9)) + axis(1, 159, [7]) + dmx(2, 150, [1]) + triggers(3, [(1, 1), (9, 2)]) + end
    yield "gaps", begin + axis(3, 20, [1, 2]) + axis(3, 4, [5]) + axis(2, 155, []) + dmx(1, 0, [4, 5]) + end + begin
    yield "refused", axis(1, 0, [1]) + begin + axis(0, 0, [1]) + axis(1, 39, [1, 2]) + triggers(1, [(43, 1)]) + end + end


def kos_differential():
    """Whole messages: one for each number, direction and eight bytes of length."""
    chosen = {}
    for vector in vectors("kos"):
        message = bytes.fromhex(vector["hex"])
        if message[:1] == b"\4" and 6 <= len(message) <= 700 and not vector["kind"].startswith("usb"):
            chosen.setdefault(f"{vector['direction'][0]}-{message[3:7].hex()}-{len(message) // 8}", message)
    return chosen.items()


def kos_round_trip():
    """Id, type and payload."""
    return [(name, message[3:]) for name, message in kos_differential()]


def kos_stream():
    """Operations: a message, noise, one with a wrong byte, a gap, one cut off, a wrong length, one more; pieces."""
    messages = [message for _, message in kos_differential() if message[3] == 0 and len(message) <= 60]
    for at in range(0, len(messages) - 4, 7):
        one, wrong, cut, last = [bytes([len(message) - 6]) + message[4:] + b"\x0b" for message in messages[at : at + 4]]
        pieces = b"\x07\x03\x07\x40\x07\x01"
        yield f"{at}", pieces + b"\0" + one + b"\5\3\4\0\6\3" + wrong + b"\6\0\2" + cut + b"\4\x40\0" + last


def kos_trajectory():
    """Stored moves, also with their blocks in reverse order; numbers for plans of each kind, sound or hostile."""
    for vector in vectors("kos"):
        if vector["name"].startswith("traj/"):
            name, body = vector["name"].removeprefix("traj/"), bytes.fromhex(vector["hex"])[6:]
            yield name, b"\0" + body
            yield f"{name}-backwards", b"\0" + body[:1] + b"".join(reversed([*blocks(body[1:])]))
    numbers = bytes(at * 37 % 256 for at in range(160))
    for kind in range(6):
        for delay, size in enumerate([0, 2, 4, 4]):
            plan = bytes([100, delay]) + numbers[:size] + bytes([kind]) + numbers[kind:]
            yield f"plan-{kind}-{delay}", b"\1" + plan
            yield f"hostile-{kind}-{delay}", b"\2" + plan


def blocks(data):
    """Splits blocks: a number, a length of two bytes, and the data. The last block may be cut off."""
    while data:
        total = 3 + int.from_bytes(data[1:3], "big")
        yield data[:total]
        data = data[total:]


def kos_usb():
    """Operations: any report; a long message, complete or with a lost, doubled or late piece; a stop; others; a wait."""
    for vector in vectors("kos"):
        if vector["kind"].startswith("usb"):
            data = bytes.fromhex(vector["hex"])
            yield vector["name"].removeprefix("usb/"), b"".join(bytes([0, 64]) + data[at : at + 64] for at in range(0, len(data), 64))
    move, stop, other = bytes(range(100, 200)), b"\x17\x40", b"\0\2\2\2"
    for form, name in [(0, "numbered"), (8, "stripped")]:
        long = lambda mishaps: bytes([0x14 + form, 100, *mishaps]) + move
        whole = bytes([0x13 + form, 100, 0, 0]) + move
        yield f"whole-{name}", whole + other + stop + whole
        yield f"mishaps-{name}", long([4, 0]) + stop + long([8, 0]) + stop + long([0x30, 0]) + b"\2\x63" + long([0, 1]) + whole
        yield f"open-{name}", bytes([6 + form, 1]) + other + stop + bytes([6 + form, 0x10]) + b"\2\x64" + whole


def hoot_differential():
    """Whole packets: one for each command, part, direction and eight bytes of length."""
    chosen = {}
    for vector in vectors("hoot"):
        packet = bytes.fromhex(vector["hex"])
        if len(packet) >= 10:
            chosen.setdefault(f"{vector['direction'][:3]}-{packet[6:9].hex()}-{len(packet) // 8}", packet)
    return chosen.items()


def hoot_round_trip():
    """Address, sub-address, command and data."""
    return [(name, packet[6:9] + packet[10:]) for name, packet in hoot_differential()]


def hoot_stream():
    """Operations: a packet, noise, one with a wrong byte, a gap, one cut off, a wrong length, one more; pieces."""
    packets = [packet for _, packet in hoot_differential()]
    for at in range(0, len(packets) - 4, 7):
        one, wrong, cut, last = [packet[9:10] + packet[6:9] + packet[10:] + b"\x0b" for packet in packets[at : at + 4]]
        pieces = b"\x07\x03\x07\x40\x07\x01"
        yield f"{at}", pieces + b"\0" + one + b"\5\3\0\0\xff\3" + wrong + b"\6\0\2" + cut + b"\4\x40\0" + last


def hoot_reply():
    """The query, the response code, and the data of the reply."""
    chosen = {}
    for vector in vectors("hoot"):
        asked, packet = (bytes.fromhex(vector.get(key, "")) for key in ["in_reply_to", "hex"])
        if len(asked) >= 10 and (asked[8] >= 100 or asked[8] == 1 and len(asked) > 10):
            command = asked[8] if asked[8] >= 100 else asked[10]
            data = bytes([command, asked[7], packet[8]]) + packet[10:]
            chosen.setdefault(f"{asked[7]}-{command}-{packet[8]}-{packet[10:11].hex()}", data)
    return chosen.items()


def message(number, body):
    """A message as the targets of machines read it: a mark for a written number, the number, and the body."""
    return b"\xfa" + number.to_bytes(4, "little") + bytes([len(body)]) + body


def sessions(begin, bodies, step):
    """A line that comes up, then messages, ten in a session, each with its consequences. In turn, the clock stands
    still, advances, or advances to the next deadline."""
    bodies = [(side, number, body) for side, number, body in bodies if len(body) <= 100]
    clocks = [b"\0", b"\5\x20", b"\x09"]
    for at in range(0, len(bodies), max(10, len(bodies) // 12)):
        steps = [clocks[n % 3] + step(*given) for n, given in enumerate(bodies[at : at + 10])]
        yield f"{at}", begin + b"".join(steps)


def dmc_machines():
    """Window, no need to enable motors, and quirks; greetings; then requests of the application and answers of a device."""
    to_device, to_host = b"\0\0\5\0", b"\0\4\5"
    begin = b"\4" + bytes(4) + b"\0\x0d\3" + to_device + to_host + b"\0\x0e\1"
    request = lambda number, body: b"\x0e" + (b"\x0c" if number & 0xFF00 == 0x100 else b"\x08") + message(number, body)
    answer = lambda number, body: b"\x09\0" + message(number, body)
    at_rest = b"\0\x0a\3\0"
    go = b"\0\x0e\2"
    follow = to_device + to_host + at_rest + to_host + go + to_device + to_host
    return sessions(begin, dmc_bodies(), lambda side, *given: (request if side == 2 else answer)(*given) + follow)


def kos_machines():
    """Options; a device that runs, a client that connects; then messages of other peers to both sides."""
    begin = bytes(10) + b"\0\x0c\0\0" + b"\0\x0f\2\0\0" + b"\0\x0d\0\0\0" + b"\0\0\5\0\4\5" * 4
    asked = lambda number, body: b"\x08\0" + message(number, body) + b"\0"
    told = lambda number, body: b"\x0a" + message(number, body)
    follow = b"\0\x0c\1\6\x20" + b"\0\0\5\0\4\5"
    return sessions(begin, kos_bodies(), lambda side, *given: (asked if side == 0 else told)(*given) + follow)


def hoot_machines():
    """Options; a line that comes up; then packets for a node, and requests of the application with small numbers."""
    begin = b"\0\0\0\1" + b"\0\x0d\1"
    given = lambda side, number, body: b"\x08\0\3" + message(number, body)
    request = lambda number: b"\x09\x0e\3\x08" + bytes([number % 250, number % 64 * 4 + 3 & 255, 0, number % 6])
    follow = lambda number: request(number >> 8) + b"\x09\0\5\x09\4\5" + b"\0\x0b\0\x0a"
    bodies = [body for body in hoot_bodies() if body[0] == 4]
    return sessions(begin, bodies, lambda side, number, body: given(side, number, body) + follow(number))


def kos_bodies():
    for vector in vectors("kos"):
        frame = bytes.fromhex(vector["hex"])
        if vector["kind"].startswith(("ok", "accept")) and len(frame) >= 6:
            side = 0 if vector["direction"] == "host" else 1
            head, body = frame[3:6], frame[6:]
            # Actions and notifications have a number of their own before their body.
            numbered = head in (b"\0\x80\0", b"\0\x81\2")
            number, body = (head + body[:1], body[1:]) if numbered else (head + b"\0", body)
            yield side, int.from_bytes(number, "big"), body


def dmc_bodies():
    for vector in vectors("dmc"):
        frame = bytes.fromhex(vector["hex"])
        yield 2 if vector["direction"] == "request" else 3, int.from_bytes(frame[6:8], "little"), frame[10:-2]


def hoot_bodies():
    for vector in vectors("hoot"):
        frame = bytes.fromhex(vector["hex"])
        if len(frame) < 10:
            continue
        address, sub_address, command = frame[6:9]
        if vector["direction"] == "request" and address != 1 and command == 1 and len(frame) > 10:
            yield 4, 2 << 16 | frame[10] << 8 | sub_address, frame[11:]
        elif vector["direction"] == "request":
            yield 4, (address == 1) << 16 | command << 8 | sub_address, frame[10:]
        else:
            yield 5, command, frame[10:]


def text():
    """How to read it (0: guess the format, the senders are unknown), and hex with marks, comments and dumps."""
    for at, vector in enumerate(vectors("dmc")[::20]):
        frame = bytes.fromhex(vector["hex"])
        lines = [f"> {frame.hex(' ')}  // a comment", f"< {frame.hex()}", "", "# 0x in front", f"> 0x{frame.hex('_')}"]
        yield f"hex-{at}", b"\0" + "\n".join(lines).encode()
        yield f"xxd-{at}", b"\x07" + xxd(frame)
        yield f"hexdump-{at}", b"\x0b" + hexdump(frame)
    yield "repeat", b"\x07" + hexdump(bytes(16)) + b"*\n00000100\n"


def rows(data):
    """The offset, the bytes and the letters of each line of a dump."""
    for at in range(0, len(data), 16):
        row = data[at : at + 16]
        yield at, row, "".join(chr(byte) if 32 <= byte < 127 else "." for byte in row)


def xxd(data):
    return "".join(f"{at:08x}: {row.hex(' ', -2):<39}  {letters}\n" for at, row, letters in rows(data)).encode()


def hexdump(data):
    halves = lambda row: f"{row[:8].hex(' '):<23}  {row[8:].hex(' '):<23}"
    return "".join(f"{at:08x}  {halves(row)}  |{letters}|\n" for at, row, letters in rows(data)).encode()


def main():
    check = sys.argv[1:] == ["--check"]
    stale = []
    kos = [kos_differential, kos_machines, kos_round_trip, kos_stream, kos_trajectory, kos_usb]
    dmc = [dmc_differential, dmc_machines, dmc_round_trip, dmc_stream, dmc_upload]
    hoot = [hoot_differential, hoot_machines, hoot_reply, hoot_round_trip, hoot_stream]
    for target in [decode, fletcher, stream, text, *kos, *dmc, *hoot]:
        folder = HERE / "seeds" / target.__name__
        wanted = {f"vector-{name}": data for name, data in target()}
        have = {path.name: path.read_bytes() for path in folder.glob("vector-*")}
        if check:
            stale += [folder / name for name in wanted.keys() | have.keys() if wanted.get(name) != have.get(name)]
            continue
        folder.mkdir(parents=True, exist_ok=True)
        for name in have.keys() - wanted.keys():
            (folder / name).unlink()
        for name, data in wanted.items():
            (folder / name).write_bytes(data)
    if stale:
        sys.exit("seeds that differ from those of fuzz/seed.py: " + ", ".join(map(str, sorted(stale))))


if __name__ == "__main__":
    main()

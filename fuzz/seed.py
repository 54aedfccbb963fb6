#!/usr/bin/env python3
"""Makes the seeds of the fuzz targets from the conformance vectors.

`seed.py` writes them, `seed.py --check` demands that those in seeds/ are what it would write. Files whose name does not
begin with "vector-" are left alone: they are what the fuzzers found.
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
    """Two bytes that say where to cut, and the bytes to be summed."""
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
    """The side, the message's number in the tables, and its body: of each number one in each eight bytes of length."""
    chosen = {}
    for side, number, body in [*kos_bodies(), *dmc_bodies(), *hoot_bodies()]:
        if len(body) <= 300:
            # In hoot the last byte is the part of the node: the commands without it are seeds enough.
            kind = number >> 8 if side == 4 else number
            chosen.setdefault(f"{PROTOCOLS[side // 2]}-{side}-{kind:x}-{len(body) // 8}", bytes([side]) + number.to_bytes(4, "little") + body)
    return chosen.items()


def kos_bodies():
    for vector in vectors("kos"):
        frame = bytes.fromhex(vector["hex"])
        if vector["kind"].startswith(("ok", "accept")) and len(frame) >= 6:
            side = 0 if vector["direction"] == "host" else 1
            head, body = frame[3:6], frame[6:]
            # Actions and notifications have a number of their own, in front of their body.
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
        if vector["direction"] == "request":
            yield 4, (address == 1) << 16 | command << 8 | sub_address, frame[10:]
        else:
            yield 5, command, frame[10:]


def text():
    """How to take it (0: guess, nobody says who sent it), and marked hex, comments and dumps."""
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
    for target in [decode, fletcher, stream, text]:
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
        sys.exit("seeds that fuzz/seed.py would write otherwise: " + ", ".join(map(str, sorted(stale))))


if __name__ == "__main__":
    main()

"""CAN and CAN FD frames to bits [ISO 11898-1]: 0 is dominant, 1 is recessive."""

from dataclasses import dataclass
from typing import Optional

from crc import CRC15, crc, fd_code

FD_LENGTHS = {9: 12, 10: 16, 11: 20, 12: 24, 13: 32, 14: 48, 15: 64}


@dataclass(frozen=True)
class Frame:
    """One frame. kind: "data", "remote" or "fd"; brs and esi belong to "fd"."""

    id: int
    extended: bool
    kind: str
    dlc: int
    data: bytes = b""
    brs: bool = False
    esi: bool = False
    iso: bool = True

    def __post_init__(self):
        if not 0 <= self.id < (1 << (29 if self.extended else 11)):
            raise ValueError(f"id {self.id:x}")
        if len(self.data) != data_length(self.kind, self.dlc):
            raise ValueError(f"{len(self.data)} bytes for DLC {self.dlc} of {self.kind}")


@dataclass(frozen=True)
class Encoded:
    """The bits from SOF to the last EOF bit, ACK slot recessive, and where things are in them."""

    bits: tuple
    crc: int
    dynamic_stuff_bits: int
    brs: Optional[int]
    crc_delimiter: int


def data_length(kind, dlc):
    """Data bytes of a frame."""
    if not 0 <= dlc <= 15:
        raise ValueError(f"DLC {dlc}")
    if kind == "remote":
        return 0
    if dlc <= 8:
        return dlc
    return FD_LENGTHS[dlc] if kind == "fd" else 8


def number(value, width):
    """`value` as bits, the most significant first."""
    return [(value >> shift) & 1 for shift in reversed(range(width))]


def header(frame):
    """SOF to DLC, and the place of the BRS bit in it."""
    fd = frame.kind == "fd"
    remote = 1 if frame.kind == "remote" else 0
    bits = [0]
    if frame.extended:
        bits += number(frame.id >> 18, 11)
        bits += [1, 1]  # SRR, IDE
        bits += number(frame.id & ((1 << 18) - 1), 18)
        bits += [remote]  # RTR, or RRS (always dominant) in CAN FD
        if not fd:
            bits += [0, 0]  # FDF, r0
    else:
        bits += number(frame.id, 11)
        bits += [remote, 0]  # RTR or RRS, IDE
        if not fd:
            bits += [0]  # FDF
    brs = None
    if fd:
        bits += [1, 0]  # FDF, res
        brs = len(bits)
        bits += [int(frame.brs), int(frame.esi)]
    return bits + number(frame.dlc, 4), brs


def stuff(bits):
    """Dynamic stuffing: after five equal bits one of the other value.

    Returns the stuffed bits and for each bit of the input its place in them. Five equal bits at
    the very end get their stuff bit, too.
    """
    out, places = [], []
    run_value, run = None, 0
    for bit in bits:
        places.append(len(out))
        out.append(bit)
        run = run + 1 if bit == run_value else 1
        run_value = bit
        if run == 5:
            out.append(1 - bit)
            run_value, run = 1 - bit, 1
    return out, places


def stuff_count_field(count):
    """Stuff count modulo 8 in Gray code, and even parity."""
    gray = (count % 8) ^ ((count % 8) >> 1)
    bits = number(gray, 3)
    return bits + [sum(bits) % 2]


def fixed_stuff(previous, field):
    """A stuff bit before each four bits of the field: the complement of the bit before it."""
    out = []
    for index, bit in enumerate(field):
        if index % 4 == 0:
            out.append(1 - (out[-1] if out else previous))
        out.append(bit)
    return out


def encode(frame):
    """The bits that a sender of `frame` puts on the bus."""
    start, brs = header(frame)
    payload = [bit for byte in frame.data for bit in number(byte, 8)]
    if frame.kind == "fd":
        body, places = stuff(start + payload)
        if places[-1] != len(body) - 1:
            # The fixed stuff bit that opens the CRC field takes the place of the dynamic one.
            body.pop()
        count = len(body) - len(places)
        code = fd_code(len(frame.data), frame.iso)
        stuff_count = stuff_count_field(count) if frame.iso else []
        value = crc(code, body + stuff_count)
        check = fixed_stuff(body[-1], stuff_count + number(value, code.width))
        brs = places[brs] if frame.brs else None
    else:
        value = crc(CRC15, start + payload)
        body, places = stuff(start + payload + number(value, 15))
        count = len(body) - len(places)
        check = []
    delimiter = len(body) + len(check)
    tail = [1, 1, 1] + [1] * 7  # CRC delimiter, ACK slot, ACK delimiter, EOF
    return Encoded(tuple(body + check + tail), value, count, brs, delimiter)

"""The frames of vectors/bits/*.toml: every frame kind and DLC, and the corners of the encoding."""

import random

from frame import Frame, data_length, encode, header, number, stuff

EDGE_IDS = {False: (0, 0x7FF, 0x555, 0x2AA, 0x400), True: (0, 0x1FFFFFFF, 0x15555555, 0x0003FFFF)}


def payload(rng, length, style):
    if style == "zeros":
        return bytes(length)
    if style == "ones":
        return b"\xff" * length
    if style == "alternating":
        return b"\x55" * length
    return bytes(rng.randrange(256) for _ in range(length))


def every_dlc(kind, extended, **flags):
    """Each DLC with constant and with random content."""
    rng = random.Random(f"{kind} {extended} {sorted(flags.items())}")
    ids = EDGE_IDS[extended]
    top = ids[1]
    for dlc in range(16):
        length = data_length(kind, dlc)
        styles = ["random"]
        if length and dlc in (1, 8, 15):
            styles += ["zeros", "ones", "alternating"]
        for style in styles:
            data = payload(rng, length, style)
            yield Frame(rng.randrange(top + 1), extended, kind, dlc, data, **flags)
    for identifier in ids:
        length = data_length(kind, 2)
        yield Frame(identifier, extended, kind, 2, payload(rng, length, "random"), **flags)


def search(seed, make, wanted, count):
    """The first `count` frames that `make` draws and `wanted` accepts."""
    rng = random.Random(seed)
    found = []
    while len(found) < count:
        frame = make(rng)
        if wanted(frame, encode(frame)):
            found.append(frame)
    return found


def random_frame(kind, extended, most=8, **flags):
    def make(rng):
        dlc = rng.randrange(most + 1)
        length = data_length(kind, dlc)
        identifier = rng.randrange(1 << (29 if extended else 11))
        return Frame(identifier, extended, kind, dlc, payload(rng, length, "random"), **flags)

    return make


def ends_in_stuff_bit(frame, encoded):
    """Five equal bits at the end of the CRC sequence: a stuff bit before the CRC delimiter."""
    end = encoded.crc_delimiter
    return len(set(encoded.bits[end - 6 : end - 1])) == 1 and frame.kind != "fd"


def data_ends_in_five(frame, encoded):
    """Five equal bits just before the CRC field of CAN FD: no dynamic stuff bit there."""
    start, _ = header(frame)
    plain = start + [bit for byte in frame.data for bit in number(byte, 8)]
    stuffed, places = stuff(plain)
    return places[-1] != len(stuffed) - 1


def corner(name, frames):
    return [(f"{name}-{number}", frame) for number, frame in enumerate(frames)]


def files():
    """File name -> list of (name, frame)."""
    out = {
        "cbff-data": corner("dlc", every_dlc("data", False)),
        "cbff-remote": corner("dlc", every_dlc("remote", False)),
        "ceff-data": corner("dlc", every_dlc("data", True)),
        "ceff-remote": corner("dlc", every_dlc("remote", True)),
    }
    for name, extended in (("fbff", False), ("feff", True)):
        for brs in (False, True):
            for iso in (True, False):
                flags = {"brs": brs, "esi": brs != iso, "iso": iso}
                title = f"{name}-{'brs' if brs else 'nobrs'}-{'iso' if iso else 'noniso'}"
                out[title] = corner("dlc", every_dlc("fd", extended, **flags))
    out["corners"] = corners()
    return out


def corners():
    out = []
    for extended in (False, True):
        suffix = "ext" if extended else "base"
        for kind in ("data", "remote"):
            found = search(kind, random_frame(kind, extended), ends_in_stuff_bit, 6)
            out += corner(f"stuff-bit-after-crc-{kind}-{suffix}", found)
        for iso in (True, False):
            title = "iso" if iso else "noniso"
            make = random_frame("fd", extended, 12, brs=True, iso=iso)
            found = search(title, make, data_ends_in_five, 6)
            out += corner(f"five-equal-before-fsb-{title}-{suffix}", found)
        out += corner(f"stuff-bit-around-fdf-{suffix}", around_fdf(extended))
    out += corner("most-stuff-bits", most_stuffed())
    return out


def around_fdf(extended):
    """Stuff bits right before FDF (an identifier that ends in zeros) and right after BRS.

    FDF and res differ, so between FDF and BRS there can be none.
    """
    ends_in_zeros = 0x10 if extended else 0x08
    for identifier in (ends_in_zeros, 0):
        for esi, dlc in ((True, 15), (True, 14), (False, 0), (False, 1)):
            data = bytes(range(data_length("fd", dlc)))
            for brs in (False, True):
                yield Frame(identifier, extended, "fd", dlc, data, brs=brs, esi=esi)


def most_stuffed():
    """After a first stuff bit, runs of four that begin with the stuff bit need one each."""
    for byte in (0x78, 0x0F, 0xC3, 0x87, 0x1E, 0x3C, 0xE1, 0xF0):
        data = bytes([byte] * 8)
        yield Frame(0, False, "data", 8, data)
        yield Frame(0x07878787, True, "data", 8, data)
        yield Frame(0, False, "fd", 15, data * 8, brs=True)
        yield Frame(0, True, "fd", 15, data * 8, brs=True)

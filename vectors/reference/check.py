#!/usr/bin/env python3
"""Checks the reference against published figures and against recordings of real controllers.

The recordings live outside the project in ../shared/captures; without them that part is left out,
and said so.
"""

import json
import pathlib
import re
import sys
import zipfile

from crc import CRC15, CRC17_EXPONENTS, CRC21_EXPONENTS, Code, crc
from frame import Frame, encode, header, number
from receiver import Receiver

CAPTURES = pathlib.Path(__file__).resolve().parents[3] / "shared" / "captures"

# "check" of the CRC catalogue (reveng): the CRC of the characters 123456789.
CATALOGUE = [
    ("CRC-15/CAN", CRC15, 0x059E),
    ("CRC-17/CAN-FD", Code(17, CRC17_EXPONENTS, False), 0x04F03),
    ("CRC-21/CAN-FD", Code(21, CRC21_EXPONENTS, False), 0x0ED841),
]

# A sender sees an error there, a receiver accepts the frame.
ACCEPTED_ERROR = "form_error: eof last bit dominant"

# One recorded sender drives SRR dominant (the standard wants it recessive, receivers accept both).
SRR_DOMINANT = {("scopehal_can_wfm5.json", 24992)}


def check_catalogue():
    bits = [bit for byte in b"123456789" for bit in number(byte, 8)]
    for name, code, wanted in CATALOGUE:
        got = crc(code, bits)
        if got != wanted:
            yield f"{name}: {got:#x}, the catalogue says {wanted:#x}"


def frame_of(entry):
    kind = "fd" if entry["fd"] else "remote" if entry["rtr"] else "data"
    return Frame(
        entry["id"],
        entry["ext"],
        kind,
        entry["dlc"],
        bytes.fromhex(entry["data"]),
        entry["brs"],
        entry["esi"],
    )


def check_fields(path, entries):
    """CRC and stuff count of every good frame, and our receiver on our own bits."""
    for entry in entries:
        where = f"{path.name} at sample {entry['start_sample']}"
        frame = frame_of(entry)
        if (path.name, entry["start_sample"]) in SRR_DOMINANT:
            if crc_with_dominant_srr(frame) != entry["crc"]:
                yield f"{where}: CRC is not that of a dominant SRR"
            continue
        encoded = encode(frame)
        if encoded.crc != entry["crc"]:
            yield f"{where}: CRC {encoded.crc:#x}, recorded {entry['crc']:#x}"
        recorded = entry.get("stuff_count", encoded.dynamic_stuff_bits)
        if encoded.dynamic_stuff_bits != recorded:
            yield f"{where}: {encoded.dynamic_stuff_bits} stuff bits, recorded {recorded}"
        events = Receiver().run(list(encoded.bits) + [1] * 3)
        if [event.frame for event in events] != [frame]:
            yield f"{where}: own receiver reads {events}"


def crc_with_dominant_srr(frame):
    bits, _ = header(frame)
    bits[12] = 0
    return crc(CRC15, bits + [bit for byte in frame.data for bit in number(byte, 8)])


def runs_of(path, bit):
    """(first sample, level) of every run in the logic data of a .sr file."""
    with zipfile.ZipFile(path) as archive:
        metadata = archive.read("metadata").decode()
        size = int(re.search(r"unitsize\s*=\s*(\d+)", metadata).group(1))
        names = [name for name in archive.namelist() if name.startswith("logic-1")]
        names.sort(key=lambda name: [int(part) for part in re.findall(r"\d+", name)])
        raw = b"".join(archive.read(name) for name in names)
    lane = raw[bit // 8 :: size].translate(bytes((v >> bit % 8) & 1 for v in range(256)))
    runs = [(match.start(), lane[match.start()]) for match in re.finditer(rb"\x00+|\x01+", lane)]
    return runs, len(lane)


def sampled_bits(runs, length, samples_per_bit):
    """Classic bits by sampling in the middle, synchronized to every recessive-dominant edge."""
    bits, starts = [], []
    for (at, level), (following, _) in zip(runs, runs[1:] + [(length, None)]):
        if level == 0 or not bits:
            origin = at
        boundary = origin + round((at - origin) / samples_per_bit) * samples_per_bit
        while boundary + 0.5 * samples_per_bit < following:
            bits.append(level)
            starts.append(boundary)
            boundary += samples_per_bit
    return bits, starts


def check_recording(path, truth, inverted):
    """Our receiver on the line of a classic recording: frames and errors in order."""
    rate = truth["samplerate"] / truth["nominal_bitrate"]
    runs, length = runs_of(CAPTURES / path, truth.get("channel_bit") or 0)
    if inverted:
        runs = [(at, 1 - level) for at, level in runs]
    bits, starts = sampled_bits(runs, length, rate)
    events = Receiver(integrated=False).run(bits)
    late = [
        entry["start_sample"]
        for entry in truth["frames"]
        if entry.get("error", "").startswith(ACCEPTED_ERROR)
    ]
    got = [
        event.frame
        for event in events
        if event.kind == "frame" and all(abs(starts[event.start] - at) > rate for at in late)
    ]
    wanted = [frame_of(entry) for entry in truth["frames"] if "error" not in entry]
    if got != wanted:
        both = zip(got + [None] * len(wanted), wanted + [None] * len(got))
        first = next(i for i, (a, b) in enumerate(both) if a != b)
        yield f"{path}: {len(got)} frames, {len(wanted)} recorded, first difference at {first}"
    errors = [starts[event.start] for event in events if event.kind == "error"]
    for entry in truth["frames"]:
        near = [at for at in errors if abs(at - entry["start_sample"]) < rate]
        if entry.get("error") in ("stuff_error", "crc_error", "form_error") and not near:
            yield f"{path}: no error near sample {entry['start_sample']}: {entry['error']}"


def check_recordings():
    manifest = json.loads((CAPTURES / "manifest.json").read_text())
    frames = lines = 0
    seen = set()
    for capture in manifest:
        if capture["truth"] is None:
            continue
        path = CAPTURES / capture["truth"]
        truth = json.loads(path.read_text())
        good = [entry for entry in truth["frames"] if "error" not in entry]
        if path not in seen:
            seen.add(path)
            frames += len(good)
            yield from check_fields(path, good)
        file = CAPTURES / capture["file"]
        coarse = truth["samplerate"] / truth["nominal_bitrate"] < 8
        logic = any(name.startswith("logic-1") for name in names_in(file))
        if logic and not coarse and not any(entry.get("fd") for entry in good):
            lines += 1
            yield from check_recording(capture["file"], truth, bool(capture["inverted?"]))
    print(f"recordings: {frames} frames encoded and read back, {lines} lines read bit by bit")


def names_in(path):
    if path.suffix != ".sr":
        return []
    with zipfile.ZipFile(path) as archive:
        return archive.namelist()


def main():
    problems = list(check_catalogue())
    print(f"catalogue: {len(CATALOGUE)} CRCs")
    if CAPTURES.is_dir():
        problems += check_recordings()
    else:
        print("recordings: ABSENT (../shared/captures); not checked", file=sys.stderr)
    for problem in problems[:50]:
        print(problem, file=sys.stderr)
    if problems:
        sys.exit(f"{len(problems)} problems")
    print("all right")


if __name__ == "__main__":
    main()

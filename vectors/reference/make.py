#!/usr/bin/env python3
"""Writes vectors/bits, vectors/detect and vectors/lss; with --check it only says whether they are up to date."""

import argparse
import difflib
import pathlib
import sys

import lss
import lss_cases
import scenes
import vectors
from frame import encode
from receiver import Receiver

VECTORS = pathlib.Path(__file__).resolve().parents[1]
FOLDERS = ("bits", "detect", "lss")
HEADER = "# Made by vectors/reference/make.py. Do not edit.\n"


def toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {toml_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return repr(value)


def entries(title, table):
    """One array of tables in TOML."""
    lines = []
    for entry in table:
        lines.append(f"\n[[{title}]]")
        lines += [f"{key} = {toml_value(value)}" for key, value in entry.items()]
    return "\n".join(lines) + "\n"


def bits_entry(name, frame):
    encoded = encode(frame)
    read = Receiver(iso=frame.iso).run(list(encoded.bits) + [1] * 3)
    if [event.frame for event in read] != [frame]:
        raise AssertionError(f"{name}: the reference does not read its own bits: {read}")
    entry = {
        "name": name,
        "id": frame.id,
        "extended": frame.extended,
        "kind": frame.kind,
        "dlc": frame.dlc,
        "data": frame.data.hex(),
    }
    if frame.kind == "fd":
        entry |= {"brs": frame.brs, "esi": frame.esi, "iso": frame.iso}
    entry |= {
        "crc": f"{encoded.crc:x}",
        "bits": "".join(map(str, encoded.bits)),
        "stuff_bits": encoded.dynamic_stuff_bits,
        "crc_delimiter": encoded.crc_delimiter,
    }
    if encoded.brs is not None:
        entry["brs_index"] = encoded.brs
    return entry


def lss_codec():
    """Every command with its bytes, and what is no command."""
    parts = []
    for title, table, unknown in [
        ("request", lss.REQUESTS, lss.UNKNOWN_REQUESTS),
        ("response", lss.RESPONSES, lss.UNKNOWN_RESPONSES),
    ]:
        parts.append(f"unknown_{title}s = {toml_value(unknown)}\n")
        parts.append(entries(title, [{"name": n, "fields": f, "bytes": b.hex()} for n, f, b in table]))
    # Keys of the file stand before its tables.
    return "".join(sorted(parts, key=lambda part: part.startswith("\n")))


def lss_scripts(cases):
    def entry(name, setup, script):
        lines = "".join(f"    {toml_value(line)},\n" for line in script)
        options = "".join(f"{key} = {toml_value(value)}\n" for key, value in setup.items())
        return f"\n[[case]]\nname = {toml_value(name)}\n{options}script = [\n{lines}]\n"

    identity = "".join(f"{n} = {v:#x}\n" for n, v in zip(lss.PARTS, lss.IDENTITY))
    return identity + "".join(entry(*case) for case in cases)


def outputs():
    """Path -> text of every file."""
    out = {}
    for name, frames in vectors.files().items():
        table = [bits_entry(*named) for named in frames]
        out[VECTORS / "bits" / f"{name}.toml"] = HEADER + entries("frame", table)
    for name, scene in scenes.all_scenes():
        out[VECTORS / "detect" / f"{name}.toml"] = HEADER + scenes.text(scene, entries, toml_value)
    out[VECTORS / "lss" / "codec.toml"] = HEADER + lss_codec()
    for name, cases in [
        ("services", lss_cases.from_table()),
        ("behaviour", lss_cases.checked_by_hand()),
        ("sessions", lss_cases.sessions()),
    ]:
        out[VECTORS / "lss" / f"{name}.toml"] = HEADER + lss_scripts(cases)
    return out


def check(out):
    stale = []
    present = {path for folder in FOLDERS for path in (VECTORS / folder).glob("*")}
    for path in sorted(present | set(out)):
        have = path.read_text() if path.exists() else ""
        want = out.get(path, "")
        if have != want:
            stale.append(path)
            diff = difflib.unified_diff(have.split("\n"), want.split("\n"), str(path), "made", n=0)
            print("\n".join(line[:200] for line in list(diff)[:8]), file=sys.stderr)
    if stale:
        sys.exit(f"{len(stale)} files are out of date: run vectors/reference/make.py")
    print(f"{len(out)} files up to date")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    out = outputs()
    if parser.parse_args().check:
        return check(out)
    for folder in FOLDERS:
        (VECTORS / folder).mkdir(exist_ok=True)
        for path in (VECTORS / folder).glob("*.toml"):
            path.unlink()
    for path, text in out.items():
        path.write_text(text)
    print(f"{len(out)} files written")


if __name__ == "__main__":
    main()

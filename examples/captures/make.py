#!/usr/bin/env python3
"""Makes the demo captures of this folder with the reference of vectors/; the same bytes each time.

    python3 examples/captures/make.py           # write
    python3 examples/captures/make.py --check   # exit code 1 if they are out of date
"""

import io
import pathlib
import random
import sys
import zipfile
from fractions import Fraction

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "vectors" / "reference"))

from frame import Frame, encode  # noqa: E402
from timeline import Bus, Rates, sampled  # noqa: E402

NS = Fraction(1, 10**9)
MS = Fraction(1, 1000)


class Sender:
    """A node with a clock of its own; the others hear it, and it hears them, somewhat late."""

    def __init__(self, nominal, data, ppm, ack_delay_ns):
        self.rates = Rates(Fraction(nominal), Fraction(data), Fraction(ppm))
        self.ack_delay = ack_delay_ns * NS


class Traffic:
    """Periodic messages of several senders on one bus, in order of their due times."""

    def __init__(self, seed):
        self.bus = Bus()
        self.rng = random.Random(seed)
        self.messages = []

    def every(self, period, first, sender, make):
        self.messages.append([first, period, sender, make])

    def run(self, until, destroyed=None):
        """`destroyed` = (number of the message, bits): that frame ends in an error flag first."""
        number = 0
        while True:
            message = min(self.messages, key=lambda entry: (entry[0], entry[1]))
            due, period, sender, make = message
            # A node schedules by its own timer, so frames meet the sampling clock at any phase.
            message[0] = due + period * Fraction(1_000_217, 1_000_000)
            if due >= until:
                break
            self.bus.now = max(self.bus.now, due)
            frame = make(number)
            encoded = encode(frame)
            if destroyed and destroyed[0] == number:
                # The sender notices first, the others answer its flag: seven to twelve bits.
                self.bus.error_frame(encoded, sender.rates, destroyed[1], 11)
                self.bus.idle(3 * sender.rates.bit())
            self.bus.frame(encoded, sender.rates, True, sender.ack_delay)
            self.bus.idle(3 * sender.rates.bit())
            number += 1
        self.bus.now = until


def counter_data(length, start=0x10):
    """Signals that move from message to message."""

    def data(number):
        return bytes((start + 7 * index + number * (index + 1)) & 0xFF for index in range(length))

    return data


def fd_bus():
    """A drive of three nodes: 500 kbit/s, CAN FD with 2 Mbit/s."""
    control = Sender(500_000, 2_000_000, 40, 180)
    motor = Sender(500_000, 2_000_000, -85, 210)
    panel = Sender(500_000, 2_000_000, 10, 240)
    traffic = Traffic(1)
    short, wide, full = counter_data(8), counter_data(24, 0x80), counter_data(64, 0x20)
    traffic.every(5 * MS, 1 * MS, control, lambda n: Frame(0x0A0, False, "fd", 8, short(n), True))
    traffic.every(5 * MS, 2 * MS, motor, lambda n: Frame(0x1A1, False, "fd", 12, wide(n), True))
    traffic.every(20 * MS, 3 * MS, motor, lambda n: Frame(0x2B0, False, "fd", 15, full(n), True))
    brief = counter_data(4, 0x55)
    traffic.every(10 * MS, 4 * MS, panel, lambda n: Frame(0x321, False, "data", 4, brief(n)))
    address = 0x18FF_5021
    traffic.every(15 * MS, 6 * MS, panel, lambda n: Frame(address, True, "data", 8, short(n)))
    traffic.every(60 * MS, 13 * MS, control, lambda n: Frame(0x322, False, "remote", 2))
    answer = Frame(0x322, False, "data", 2, b"\x01\x5e")
    traffic.every(60 * MS, 13 * MS + MS / 3, panel, lambda n: answer)
    traffic.run(60 * MS, destroyed=(17, 40))
    return traffic.bus


def classic_bus():
    """A body bus: 83.333 kbit/s."""
    door = Sender(Fraction(250_000, 3), 0, 120, 300)
    seat = Sender(Fraction(250_000, 3), 0, -200, 350)
    traffic = Traffic(2)
    door_data, seat_data = counter_data(6, 0x01), counter_data(8, 0x90)
    traffic.every(20 * MS, 2 * MS, door, lambda n: Frame(0x1C3, False, "data", 6, door_data(n)))
    traffic.every(25 * MS, 9 * MS, seat, lambda n: Frame(0x2F0, False, "data", 8, seat_data(n)))
    traffic.run(100 * MS)
    return traffic.bus


NAMES = ["CAN_RX", "CAN_TX", "SPI_CS", "SPI_CLK", "LED", "RESET", "KEY", "TRIGGER"]


def sigrok_session(bus, frequency):
    """A sigrok session, version 2, with eight named probes; only some of them move."""
    odd, edges, count = sampled(bus.transitions(30 * NS), frequency, Fraction(0), bus.now)
    lanes = {0: edges, 3: spi_clock(count), 4: blinks(count)}
    idle = 1 << 1 | 1 << 2 | 1 << 5 | 1 << 6  # TX, chip select, reset and key rest high
    level = idle | (1 if odd == 0 else 0)
    changes = sorted((at, 1 << lane) for lane, ticks in lanes.items() for at in ticks)
    samples = bytearray()
    for at, mask in changes:
        samples += bytes([level]) * (at - len(samples))
        level ^= mask
    samples += bytes([level]) * (count - len(samples))
    probes = "".join(f"probe{index + 1}={name}\n" for index, name in enumerate(NAMES))
    metadata = (
        "[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\n"
        f"total probes={len(NAMES)}\nsamplerate={frequency // 10**6} MHz\ntotal analog=0\n"
        f"{probes}unitsize=1\n"
    )
    return archive({"version": b"2", "metadata": metadata.encode(), "logic-1-1": bytes(samples)})


def spi_clock(count):
    """Bursts of 16 clocks at 1 MHz, every 12 ms."""
    return [
        start + half * 8
        for start in range(count // 20, count, count // 5)
        for half in range(32)
        if start + half * 8 < count
    ]


def blinks(count):
    return [count // 4, count // 2]


def archive(members):
    """A zip file whose bytes depend on the members alone (and on the deflate of zlib)."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for name, content in members.items():
            info = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(info, content, compresslevel=9)
    return out.getvalue()


def saleae_csv(bus, frequency):
    """Saleae Logic 2, digital CSV: one row per change, the last row ends the capture."""
    odd, edges, count = sampled(bus.transitions(), frequency, Fraction(0), bus.now)
    rows = ["Time [s],CAN"]
    level = 1 - odd
    rows.append(f"{0:.9f},{level}")
    for edge in edges:
        level = 1 - level
        rows.append(f"{edge / frequency:.9f},{level}")
    rows.append(f"{count / frequency:.9f},{level}")
    return ("\n".join(rows) + "\n").encode()


def main():
    files = {
        "demo-fd-500k-2m.sr": sigrok_session(fd_bus(), 16_000_000),
        "demo-classic-83k3.csv": saleae_csv(classic_bus(), 4_000_000),
    }
    stale = []
    for name, content in files.items():
        path = HERE / name
        if "--check" in sys.argv[1:]:
            if not path.exists() or unpacked(path.read_bytes()) != unpacked(content):
                stale.append(name)
        else:
            path.write_bytes(content)
            print(f"{name}: {len(content)} bytes")
    if stale:
        sys.exit(f"out of date: {', '.join(stale)}")


def unpacked(content):
    """What counts: the members of a zip file, not how a version of zlib packs them."""
    if not content.startswith(b"PK"):
        return content
    with zipfile.ZipFile(io.BytesIO(content)) as file:
        return {name: file.read(name) for name in file.namelist()}


if __name__ == "__main__":
    main()

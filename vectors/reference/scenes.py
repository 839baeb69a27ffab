"""The recordings of vectors/detect/*.toml: what a timer sees of a bus, and what is to be found."""

from dataclasses import dataclass, field
from fractions import Fraction

from frame import Frame, encode
from timeline import Bus, Rates, sampled, seeded_jitter

NS = Fraction(1, 10**9)
US = Fraction(1, 10**6)


@dataclass
class Scene:
    """One recording. `frames` are those that a receiver accepts, in order."""

    why: str
    timebase_hz: int
    initial: str
    edges: list
    end: int
    expect: dict
    frames: list = field(default_factory=list)


def text(scene, entries, toml_value):
    """A scene as TOML."""
    lines = [f"why = {toml_value(scene.why)}", f"timebase_hz = {scene.timebase_hz}"]
    lines += [f"initial = {toml_value(scene.initial)}", f"end = {scene.end}"]
    lines += ["edges = ["]
    for first in range(0, len(scene.edges), 12):
        lines.append("  " + " ".join(f"{edge}," for edge in scene.edges[first : first + 12]))
    lines += ["]", f"expect = {toml_value(scene.expect)}"]
    frames = entries("frame", map(described, scene.frames)) if scene.frames else ""
    return "\n".join(lines) + "\n" + frames


def described(frame):
    entry = {"id": frame.id, "extended": frame.extended, "kind": frame.kind, "dlc": frame.dlc}
    entry["data"] = frame.data.hex()
    if frame.kind == "fd":
        entry |= {"brs": frame.brs, "esi": frame.esi, "iso": frame.iso}
    return entry


def around(rate, rates, tolerance_ppm):
    """A range of bit rates, in millibit/s, around what the sender really does."""
    true = Fraction(rate) / rates.stretch()
    slack = Fraction(tolerance_ppm, 1_000_000)
    return [int(true * (1 - slack) * 1000), int(true * (1 + slack) * 1000) + 1]


def found(rates, data="none", tolerance_ppm=8000):
    """data: "none" (classic), "never_switched", or "switched"."""
    nominal = around(rates.nominal, rates, tolerance_ppm)
    expect = {"verdict": "found", "nominal_millibits_per_second": nominal, "data": data}
    if data == "switched":
        expect["data_millibits_per_second"] = around(rates.data, rates, tolerance_ppm)
    return expect


def base(identifier, data):
    return Frame(identifier, False, "data", len(data), bytes(data))


def extended(identifier, data):
    return Frame(identifier, True, "data", len(data), bytes(data))


def fd(identifier, dlc, data, ext=False, **flags):
    return Frame(identifier, ext, "fd", dlc, bytes(data), **flags)


def record(bus, why, hz, expect, frames, **how):
    """Ends the bus with the stated idle and records it."""
    begin = how.get("begin", Fraction(0))
    end = how.get("end", bus.now)
    toggles = bus.transitions(how.get("asymmetry", Fraction(0)), how.get("jitter"))
    odd, edges, last = sampled(toggles, hz, begin, end, how.get("phase", Fraction(1, 3)))
    inverted = how.get("inverted", False)
    initial = "high" if (odd == 0) != inverted else "low"
    if expect["verdict"] == "found":
        expect = expect | {"polarity": "inverted" if inverted else "normal"}
    return Scene(why, hz, initial, edges, last, expect, frames)


MIXED = base(0x2A5, [0x11, 0x9C, 0x00, 0xE7, 0x52, 0x08])
LONG = extended(0x18FEF100, [0x3F, 0xFF, 0x2C, 0x01, 0x80, 0x7D, 0x00, 0xA6])


def one(rates, frame, ack=True, delay=0):
    """Idle, one frame, idle."""
    bus = Bus()
    bus.idle(15 * rates.bit())
    bus.frame(encode(frame), rates, ack, Fraction(delay))
    bus.idle(12 * rates.bit())
    return bus


def single_frames():
    """One classic frame at many rates and resolutions."""
    cases = [
        ("10k-1mhz", 10_000, 1_000_000, 0),
        ("33k333-1mhz", Fraction(100_000, 3), 1_000_000, 1200),
        ("83k333-4mhz", Fraction(250_000, 3), 4_000_000, -2500),
        ("95k238-8mhz", Fraction(2_000_000, 21), 8_000_000, 300),
        ("125k-10mhz", 125_000, 10_000_000, -480),
        ("250k-1mhz", 250_000, 1_000_000, 2900),
        ("470k-24mhz", 470_000, 24_000_000, 0),
        ("500k-8mhz", 500_000, 8_000_000, -127),
        ("615k385-8mhz", Fraction(8_000_000, 13), 8_000_000, 0),
        ("625k-8mhz", 625_000, 8_000_000, 0),
        ("666k667-16mhz", Fraction(2_000_000, 3), 16_000_000, 3000),
        ("800k-10mhz", 800_000, 10_000_000, -3000),
        ("1m-10mhz", 1_000_000, 10_000_000, 3000),
        ("1m-72mhz", 1_000_000, 72_000_000, -5000),
        ("500k-1mhz23-2-46-ticks-per-bit", 500_000, 1_230_000, 0),
    ]
    for name, rate, hz, ppm in cases:
        rates = Rates(Fraction(rate), error_ppm=Fraction(ppm))
        bus = one(rates, LONG, delay=rates.bit() / 10)
        yield f"one-{name}", record(bus, "one classic frame", hz, found(rates), [LONG])


def contents():
    """One frame with content that misleads simple methods."""
    rates = Rates(Fraction(500_000), error_ppm=Fraction(150))
    hz = 8_000_000
    cases = [
        ("remote", Frame(0x1F0, False, "remote", 4), True),
        ("not-acknowledged", MIXED, False),
        ("zeros", base(0, [0] * 8), True),
        ("ones", base(0x7FF, [0xFF] * 8), True),
        ("empty-not-acknowledged", base(0x365, []), False),
        ("classic-dlc-15", Frame(0x100, False, "data", 15, bytes(range(8))), True),
    ]
    for name, frame, ack in cases:
        bus = one(rates, frame, ack, delay=100 * NS)
        yield f"content-{name}", record(bus, f"one frame: {name}", hz, found(rates), [frame])


def distorted():
    """One frame, distorted by transceiver or probe."""
    rates = Rates(Fraction(1_000_000), error_ppm=Fraction(-900))
    for name, ns in (("dominant-100ns-longer", 100), ("dominant-100ns-shorter", -100)):
        bus = one(rates, LONG, delay=120 * NS)
        scene = record(bus, name, 10_000_000, found(rates), [LONG], asymmetry=ns * NS)
        yield f"distorted-{name}", scene
    bus = one(rates, LONG, delay=120 * NS)
    how = {"jitter": seeded_jitter(7, 40)}
    yield "distorted-jitter-40ns", record(bus, "jitter", 24_000_000, found(rates), [LONG], **how)
    bus = one(rates, MIXED, delay=120 * NS)
    scene = record(bus, "high is dominant", 16_000_000, found(rates), [MIXED], inverted=True)
    yield "distorted-inverted", scene


def flexible():
    """CAN FD."""
    data20 = bytes(range(0x30, 0x44))
    cases = [
        ("500k-2m-20mhz", 500_000, 2_000_000, 20_000_000, fd(0x123, 11, data20, brs=True)),
        ("500k-5m-72mhz", 500_000, 5_000_000, 72_000_000, fd(0x123, 11, data20, brs=True)),
        ("1m-8m-72mhz", 1_000_000, 8_000_000, 72_000_000, fd(0x7A1, 15, range(64), brs=True)),
        ("250k-1m-4mhz", 250_000, 1_000_000, 4_000_000, fd(0x8DA10F1, 8, range(8), True, brs=True)),
        ("non-iso", 500_000, 2_000_000, 24_000_000, fd(0x345, 9, range(12), brs=True, iso=False)),
        ("470k-1m88", 470_000, 1_880_000, 16_000_000, fd(0x2F, 10, range(16), brs=True, esi=True)),
    ]
    for name, nominal, data, hz, frame in cases:
        rates = Rates(Fraction(nominal), Fraction(data), Fraction(250))
        bus = one(rates, frame, delay=150 * NS)
        expect = found(rates, "switched")
        yield f"fd-{name}", record(bus, "one CAN FD frame with a rate switch", hz, expect, [frame])
    rates = Rates(Fraction(500_000), error_ppm=Fraction(-60))
    frame = fd(0x123, 11, data20)
    bus = one(rates, frame, delay=150 * NS)
    expect = found(rates, "never_switched")
    why = "CAN FD without a rate switch: the data rate cannot be known"
    yield "fd-never-switched", record(bus, why, 8_000_000, expect, [frame])


def troubled():
    """Error flags, glitches, cut recordings."""
    rates = Rates(Fraction(500_000), error_ppm=Fraction(700))
    bit = rates.bit()
    for name, at, flag in (("early", 12, 6), ("late", 60, 12), ("in-id", 5, 8)):
        bus = Bus()
        bus.idle(15 * bit)
        bus.error_frame(encode(MIXED), rates, at, flag, bit / 8)
        bus.idle(3 * bit)
        bus.frame(encode(MIXED), rates, True, 200 * NS)
        bus.idle(12 * bit)
        why = f"a frame destroyed after {at} bits, then sent again"
        yield f"error-flag-{name}", record(bus, why, 8_000_000, found(rates), [MIXED])
    bus = one(rates, LONG, delay=100 * NS)
    for index in (3, 17, 44, 80):
        bus.glitch((15 + index) * bit + bit * 2 / 5, 60 * NS)
    why = "four glitches of 60 ns, none at a sample point"
    yield "glitches", record(bus, why, 24_000_000, found(rates), [LONG])
    bus = Bus()
    bus.frame(encode(LONG), rates)
    bus.idle(3 * bit)
    bus.frame(encode(MIXED), rates)
    bus.idle(5 * bit)
    cut = bus.now + 40 * bit
    bus.frame(encode(LONG), rates)
    how = {"begin": 31 * bit + bit / 3, "end": cut}
    why = "begins and ends in the middle of a frame"
    yield "cut-on-both-sides", record(bus, why, 8_000_000, found(rates), [MIXED], **how)
    bus = one(rates, MIXED)
    bus.now -= 12 * bit
    bus.overload_frame(rates)
    bus.idle(3 * bit)
    bus.frame(encode(LONG), rates)
    bus.idle(12 * bit)
    why = "an overload frame between two frames"
    yield "overload", record(bus, why, 8_000_000, found(rates), [MIXED, LONG])
    bus = Bus()
    bus.idle(15 * bit)
    for attempt in range(3):
        bus.error_frame(encode(MIXED), rates, encode(MIXED).crc_delimiter + 2)
        bus.idle(3 * bit)
    bus.idle(12 * bit)
    why = "nobody acknowledges: the sender's error flag follows the ACK slot, three times"
    yield "never-acknowledged", record(bus, why, 8_000_000, found(rates), [])


def hopeless():
    """Recordings that prove no rate."""
    rates = Rates(Fraction(500_000))
    bus = Bus()
    bus.idle(Fraction(1, 1000))
    nothing = {"verdict": "no_traffic"}
    yield "no-traffic", record(bus, "a recessive line", 8_000_000, nothing, [])
    undecided = {"verdict": "undecided"}
    bus = Bus()
    for _ in range(40):
        bus.drive(bus.now, bus.now + 2 * US)
        bus.idle(4 * US)
    yield "clock", record(bus, "a clock of 250 kHz, no bus", 8_000_000, undecided, [])
    bus = Bus()
    bus.idle(20 * US)
    for byte in b"canbaud, not CAN: 115200 8N1":
        levels = [0] + [(byte >> shift) & 1 for shift in range(8)] + [1]
        for level in levels:
            if level == 0:
                bus.drive(bus.now, bus.now + Fraction(1, 115_200))
            bus.idle(Fraction(1, 115_200))
    bus.idle(200 * US)
    yield "serial-port", record(bus, "an asynchronous serial line", 8_000_000, undecided, [])
    bus = one(rates, LONG)
    cut = {"begin": Fraction(0), "end": 60 * rates.bit()}
    why = "the only frame is cut in its data"
    yield "half-a-frame", record(bus, why, 8_000_000, undecided, [], **cut)
    bus = one(rates, LONG)
    why = "one tick per bit is too coarse"
    yield "one-tick-per-bit", record(bus, why, 500_000, undecided, [])
    bus = Bus()
    bus.idle(20 * US)
    bus.glitch(5 * US, 50 * NS)
    bus.glitch(12 * US, 30 * NS)
    yield "two-glitches", record(bus, "two glitches, no frame", 72_000_000, undecided, [])
    bus = Bus()
    for rate in (500_000, 250_000):
        rates = Rates(Fraction(rate))
        for frame in (MIXED, LONG, base(0x77, [1, 2, 3])):
            bus.idle(15 * rates.bit())
            bus.frame(encode(frame), rates)
    bus.idle(60 * US)
    why = "first three frames at 500 kbit/s, then three at 250 kbit/s"
    yield "two-rates", record(bus, why, 8_000_000, {"verdict": "conflict"}, [])


def all_scenes():
    """(name, scene) of every file."""
    for group in (single_frames, contents, distorted, flexible, troubled, hopeless):
        yield from group()

"""Every service of CiA 305 in every state, with good and bad parameters, by hand; random sessions.

A script is a list of lines:
    > FRAME     the slave receives it (candump form; # data, #R remote, ## CAN FD)
    < FRAME     the slave sends it
    @ MS        the time goes on to this
    ! WHAT      stop, switch RATE, resume: an activation; reset ID: autonomous reset communication
    ? found     the node has found the bit rate
    ? reset     the node went through reset communication
    = STATE node ID rate INDEX    state, pending node-ID and bit timing index
What stands between two lines of > @ ? is all that the slave may do.
"""

import random

from lss import AUTOMATIC, IDENTITY, NONE, PRODUCT, RATES, REVISION, SERIAL, VENDOR, Slave, frame, u32

FRESH = {}
CONFIGURED = {"node_id": 5}
MINI_MASTER = {"automatic": False}
FIXED = {"rates": [], "automatic": False, "storage": "none"}
SLOW_ONLY = {"rates": [4, 6, 7, 8]}

SELECT = [frame(0x40 + k, u32(number)) for k, number in enumerate(IDENTITY)]
ENTER, LEAVE = frame(0x04, 1), frame(0x04, 0)
RANGE = [VENDOR, PRODUCT, REVISION, REVISION, SERIAL, SERIAL]


def identify(numbers):
    return [frame(0x46 + k, u32(number)) for k, number in enumerate(numbers)]


def changed(numbers, place, number):
    return [number if k == place else old for k, old in enumerate(numbers)]


def scan(number, bit, sub, following):
    return frame(0x51, u32(number), bit, sub, following)


BEGIN = scan(0, 128, 0, 0)
FOUND = frame(0x4F)
WAIT, CONF = "waiting", "configuration"

# name, setup, state before, frames, last answer or None, state after.
TABLE = []


def row(name, setup, before, frames, answer, after=None, earlier=0):
    """`earlier`: how many of the frames before the last are answered with 4Fh, too."""
    TABLE.append((name, setup, before, frames, answer, after or before, earlier))


for setup, who in [(FRESH, "without node-ID"), (CONFIGURED, "with node-ID")]:
    for before in (WAIT, CONF):
        row(f"switch state global waiting, {who}", setup, before, [LEAVE], None, WAIT)
        row(f"switch state global configuration, {who}", setup, before, [ENTER], None, CONF)
        for mode in (2, 128, 255):
            row(f"switch state global, reserved mode {mode}, {who}", setup, before, [frame(0x04, mode)], None)
        row(f"switch state selective, {who}", setup, before, SELECT, frame(0x44) if before == WAIT else None, CONF)
        for place in range(4):
            wrong = [frame(0x40 + k, u32(number + (k == place))) for k, number in enumerate(IDENTITY)]
            row(f"switch state selective, part {place} is another's, {who}", setup, before, wrong, None)
        row(f"switch state selective without its first part, {who}", setup, before, SELECT[1:], None)
        row(f"switch state selective without its third part, {who}", setup, before, SELECT[:2] + SELECT[3:], None)
        row(f"switch state selective in another order, {who}", setup, before, [SELECT[1], SELECT[0], *SELECT[2:]], None)
        row(f"switch state selective, a service between, {who}", setup, before, [*SELECT[:3], frame(0x5E) if before == WAIT else ENTER, SELECT[3]], None)
        row(f"switch state selective begun again, {who}", setup, before, SELECT[:2] + SELECT, frame(0x44) if before == WAIT else None, CONF)
        for node_id in (1, 2, 127, 255, 0, 128, 254):
            good = node_id in (1, 2, 127, 255)
            answer = frame(0x11, 0 if good else 1) if before == CONF else None
            row(f"configure node-ID {node_id}, {who}", setup, before, [frame(0x11, node_id)], answer)
        for part in range(4):
            answer = frame(0x5A + part, u32(IDENTITY[part])) if before == CONF else None
            row(f"inquire identity {part}, {who}", setup, before, [frame(0x5A + part)], answer)
        row(f"inquire node-ID, {who}", setup, before, [frame(0x5E)], frame(0x5E, setup.get("node_id", NONE)) if before == CONF else None)
        row(f"identify remote slave, {who}", setup, before, identify(RANGE), FOUND)
        wide = [VENDOR, PRODUCT, 0, 0xFFFFFFFF, 0, 0xFFFFFFFF]
        row(f"identify remote slave, all of a product, {who}", setup, before, identify(wide), FOUND)
        for place, number, why in [
            (0, VENDOR + 1, "vendor"),
            (1, PRODUCT - 1, "product"),
            (2, REVISION + 1, "revision below"),
            (3, REVISION - 1, "revision above"),
            (4, SERIAL + 1, "serial number below"),
            (5, SERIAL - 1, "serial number above"),
        ]:
            row(f"identify remote slave, {why}, {who}", setup, before, identify(changed(RANGE, place, number)), None)
        row(f"identify remote slave without its first frame, {who}", setup, before, identify(RANGE)[1:], None)
        row(f"identify remote slave without its third frame, {who}", setup, before, identify(RANGE)[:2] + identify(RANGE)[3:], None)
        row(f"identify remote slave, a service between, {who}", setup, before, identify(RANGE)[:5] + [frame(0x04, 9)] + identify(RANGE)[5:], None)
        unconfigured = setup is FRESH
        row(f"identify non-configured remote slave, {who}", setup, before, [frame(0x4C)], frame(0x50) if unconfigured else None)
        scanned = unconfigured and before == WAIT
        row(f"fastscan begins, {who}", setup, before, [BEGIN], FOUND if scanned else None)
        row(f"fastscan, bit 31, {who}", setup, before, [BEGIN, scan(0, 31, 0, 0)], FOUND if scanned else None, earlier=scanned)
        for cs in (0x00, 0x05, 0x10, 0x12, 0x14, 0x16, 0x18, 0x44, 0x45, 0x4D, 0x4F, 0x50, 0x52, 0x59, 0x5F, 0x80, 0xFF):
            row(f"command {cs:02X}h does not exist, {who}", setup, before, [frame(cs)], None)

for before in (WAIT, CONF):
    for setup, who, rates, automatic in [
        (FRESH, "a device of all bit rates", set(RATES), True),
        (MINI_MASTER, "a mini-master", set(RATES), False),
        (FIXED, "a device of one bit rate", set(), False),
        (SLOW_ONLY, "a slow device", {4, 6, 7, 8}, True),
    ]:
        for index in (*range(11), 128, 255):
            good = index in rates or (index == AUTOMATIC and automatic)
            answer = frame(0x13, 0 if good else 1) if before == CONF else None
            row(f"configure bit timing, index {index}, {who}", setup, before, [frame(0x13, 0, index)], answer)
        for selector in (1, 127, 128, 255):
            answer = frame(0x13, 1) if before == CONF else None
            row(f"configure bit timing, table {selector}, {who}", setup, before, [frame(0x13, selector, 2)], answer)
    for storage, answer in [("works", frame(0x17)), ("none", frame(0x17, 1)), ("broken", frame(0x17, 2)), ("manufacturer", frame(0x17, 255, 42))]:
        row(f"store configuration, storage {storage}", {"storage": storage}, before, [frame(0x17)], answer if before == CONF else None)

# Fastscan in waiting, without node-ID.
row("fastscan, the whole vendor-ID", FRESH, WAIT, [BEGIN, scan(VENDOR, 0, 0, 1)], FOUND, earlier=1)
row("fastscan, many bits at once", FRESH, WAIT, [BEGIN, scan(VENDOR & 0xFFFF0000, 16, 0, 0)], FOUND, earlier=1)
row("fastscan, lower bits are not compared", FRESH, WAIT, [BEGIN, scan(VENDOR | 0xFF, 8, 0, 0)], FOUND, earlier=1)
row("fastscan, an upper bit differs", FRESH, WAIT, [BEGIN, scan(VENDOR ^ 0x8000, 8, 0, 0)], None, earlier=1)
row("fastscan, another part than the one due", FRESH, WAIT, [BEGIN, scan(PRODUCT, 0, 1, 2)], None, earlier=1)
row("fastscan, the part due", FRESH, WAIT, [BEGIN, scan(VENDOR, 0, 0, 1), scan(PRODUCT, 0, 1, 2)], FOUND, earlier=2)
row("fastscan, the part done", FRESH, WAIT, [BEGIN, scan(VENDOR, 0, 0, 1), scan(VENDOR, 0, 0, 1)], None, earlier=2)
row("fastscan begins again", FRESH, WAIT, [BEGIN, scan(VENDOR, 0, 0, 1), BEGIN, scan(VENDOR, 0, 0, 1)], FOUND, earlier=3)
row("fastscan, LSSNext may be any part", FRESH, WAIT, [BEGIN, scan(VENDOR, 0, 0, 3), scan(SERIAL, 31, 3, 3)], FOUND, earlier=2)
ALL_PARTS = [scan(number, 0, sub, (sub + 1) % 4) for sub, number in enumerate(IDENTITY)]
row("fastscan to the end", FRESH, WAIT, [BEGIN, *ALL_PARTS], FOUND, CONF, earlier=4)
row("fastscan ends at a lower LSSNext", FRESH, WAIT, [BEGIN, *ALL_PARTS[:2], scan(REVISION, 0, 2, 0)], FOUND, CONF, earlier=3)
row("fastscan does not end before bit 0", FRESH, WAIT, [BEGIN, *ALL_PARTS[:3], scan(SERIAL, 1, 3, 0)], FOUND, WAIT, earlier=4)
for bit, sub, following in [(32, 0, 0), (127, 0, 0), (129, 0, 0), (255, 0, 0), (31, 4, 0), (31, 255, 0), (31, 0, 4), (31, 0, 255)]:
    row(f"fastscan, BitChecked {bit}, LSSSub {sub}, LSSNext {following}", FRESH, WAIT, [BEGIN, scan(0, bit, sub, following)], None, earlier=1)


def data(raw):
    return "> 7E5#" + raw.hex().upper()


def answer(raw):
    return "< 7E4#" + raw.hex().upper()


def from_table():
    for name, setup, before, frames, last, after, earlier in TABLE:
        model = Slave(**setup)
        lines = [] if before == WAIT else [data(ENTER)]
        for place, raw in enumerate(frames):
            lines.append(data(raw))
            # The first frames, or those right before the last, that are answered.
            if place < len(frames) - 1 and place < earlier:
                lines.append(answer(FOUND))
        if last is not None:
            lines.append(answer(last))
        play = list(lines)
        outcome = run(model, play)
        if outcome != lines:
            raise AssertionError(f"{name}: table {lines}, model {outcome}")
        status = model.status()
        if status.split()[1] != after:
            raise AssertionError(f"{name}: {status}, the table says {after}")
        yield f"{name}, in {before}", setup, [*lines, status]


def run(model, lines):
    """The script with what the model does in place of what it says."""
    now, out = 0, []
    for line in lines:
        kind, rest = line.split(" ", 1)
        if kind == ">":
            out.append(line)
            head, _, body = rest.partition("#")
            if head == "7E5" and len(body) == 16:
                out += model.command(now, bytes.fromhex(body))
        elif kind == "@":
            now = int(rest)
            out += [line, *model.advance(now)]
        elif kind == "?":
            out.append(line)
            if rest == "found" and model.plan:
                model.plan = [(model.resume, "resume")] if model.plan[0][1] == "found?" else model.plan
            if rest == "reset":
                model.active_id, model.configuring, model.position, model.history = model.pending_id, False, 0, []
                model.reset = False
            out += model.advance(now)
        elif kind == "=":
            out.append(model.status())
    return out


def by_hand():
    """What takes more than an answer: written out in full."""
    rate = {index: str(bits) for index, bits in RATES.items()}
    yield "the pending node-ID becomes active by itself on leaving configuration", FRESH, [
        data(ENTER), data(frame(0x11, 7)), answer(frame(0x11)), data(frame(0x5E)), answer(frame(0x5E, 7)),
        data(LEAVE), "! reset 7", "? reset", "= waiting node 7 rate 3",
        data(frame(0x4C)), data(BEGIN), data(ENTER), data(frame(0x5E)), answer(frame(0x5E, 7)),
    ]
    yield "the node-ID of a device that has one changes at reset communication alone", CONFIGURED, [
        data(ENTER), data(frame(0x11, 7)), answer(frame(0x11)), data(frame(0x5E)), answer(frame(0x5E, 5)),
        data(LEAVE), "= waiting node 7 rate 3", data(ENTER), data(frame(0x5E)), answer(frame(0x5E, 5)),
        "? reset", "= waiting node 7 rate 3", data(ENTER), data(frame(0x5E)), answer(frame(0x5E, 7)),
    ]
    yield "255 takes the node-ID away at reset communication", CONFIGURED, [
        data(ENTER), data(frame(0x11, 255)), answer(frame(0x11)), data(frame(0x4C)), data(LEAVE),
        data(frame(0x4C)), "? reset", data(frame(0x4C)), answer(frame(0x50)),
        data(BEGIN), answer(FOUND),
    ]
    yield "a pending node-ID ends fastscan and identify non-configured at once", FRESH, [
        data(ENTER), data(frame(0x11, 9)), answer(frame(0x11)), data(frame(0x4C)),
    ]
    yield "no node-ID, no reset", FRESH, [data(ENTER), data(LEAVE), data(frame(0x4C)), answer(frame(0x50))]
    yield "leaving the waiting state is no reason for a reset", FRESH, [
        *[line for raw, found in [(BEGIN, 1), *[(part, 1) for part in ALL_PARTS]] for line in (data(raw), answer(FOUND))],
        data(frame(0x11, 3)), answer(frame(0x11)), data(LEAVE), "! reset 3", data(LEAVE),
    ]
    yield "activation: stop, switch after the delay, send after twice the delay", FRESH, [
        data(ENTER), data(frame(0x13, 0, 2)), answer(frame(0x13)), "@ 1000",
        data(frame(0x15, ("u16", 300))), "! stop", "@ 1299", "@ 1300", "! switch " + rate[2],
        "@ 1599", "@ 1600", "! resume", data(frame(0x5E)), answer(frame(0x5E, 255)),
    ]
    yield "activation without a new bit rate keeps the silence all the same", CONFIGURED, [
        data(ENTER), data(frame(0x15, ("u16", 20))), "! stop", "@ 20", "! switch " + rate[3], "@ 40", "! resume",
    ]
    yield "activation with a delay of 0", FRESH, [
        data(ENTER), data(frame(0x13, 0, 0)), answer(frame(0x13)),
        data(frame(0x15, ("u16", 0))), "! stop", "! switch " + rate[0], "! resume",
    ]
    yield "activation with the longest delay", FRESH, [
        data(ENTER), data(frame(0x15, ("u16", 65535))), "! stop", "@ 65534", "@ 65535", "! switch " + rate[3],
        "@ 131069", "@ 131070", "! resume",
    ]
    yield "activation in waiting is not for this slave", FRESH, [
        data(frame(0x15, ("u16", 10))), "@ 100", data(ENTER), data(frame(0x5E)), answer(frame(0x5E, 255)),
    ]
    yield "during an activation nothing is answered and nothing is set", FRESH, [
        data(ENTER), data(frame(0x13, 0, 4)), answer(frame(0x13)), data(frame(0x15, ("u16", 100))), "! stop",
        data(frame(0x11, 3)), data(frame(0x13, 0, 2)), data(frame(0x17)), data(frame(0x4C)), data(frame(0x5A)),
        *[data(raw) for raw in identify(RANGE)], data(frame(0x15, ("u16", 1))),
        "@ 100", "! switch " + rate[4], data(frame(0x11, 3)), data(frame(0x5E)),
        "@ 200", "! resume", "= configuration node 255 rate 4",
    ]
    yield "during an activation the state can be switched", FRESH, [
        data(ENTER), data(frame(0x15, ("u16", 100))), "! stop", data(LEAVE), "= waiting node 255 rate 3",
        "@ 100", "! switch " + rate[3], "@ 200", "! resume", data(frame(0x5E)),
    ]
    yield "the boot-up waits until sending is allowed", FRESH, [
        data(ENTER), data(frame(0x11, 12)), answer(frame(0x11)), data(frame(0x13, 0, 1)), answer(frame(0x13)),
        data(frame(0x15, ("u16", 50))), "! stop", data(LEAVE), "@ 50", "! switch " + rate[1],
        "@ 100", "! resume", "! reset 12",
    ]
    yield "index 9: silent until the bit rate is found", FRESH, [
        data(ENTER), data(frame(0x13, 0, 9)), answer(frame(0x13)), data(frame(0x17)), answer(frame(0x17)),
        data(frame(0x15, ("u16", 100))), "! stop", data(LEAVE), "@ 100", "! switch automatic", "@ 5000",
        data(frame(0x4C)), data(BEGIN), "? found", "! resume", data(frame(0x4C)), answer(frame(0x50)),
        "= waiting node 255 rate 9",
    ]
    yield "index 9: found within the second period, silent until its end", FRESH, [
        data(ENTER), data(frame(0x13, 0, 9)), answer(frame(0x13)), data(frame(0x15, ("u16", 100))), "! stop",
        "@ 100", "! switch automatic", "@ 120", "? found", "@ 199", "@ 200", "! resume",
    ]
    yield "index 9: the boot-up waits for the bit rate", FRESH, [
        data(ENTER), data(frame(0x11, 20)), answer(frame(0x11)), data(frame(0x13, 0, 9)), answer(frame(0x13)),
        data(frame(0x15, ("u16", 10))), "! stop", data(LEAVE), "@ 10", "! switch automatic", "@ 20", "@ 900",
        "? found", "! resume", "! reset 20",
    ]
    body = ENTER.hex().upper()
    for name, line in [
        *[(f"a command of DLC {dlc} is none", f"> 7E5#{body[:2 * dlc]}") for dlc in range(8)],
        ("a remote frame is no command", "> 7E5#R8"),
        ("an extended identifier is another one", f"> 000007E5#{body}"),
        ("a CAN FD frame is no command", f"> 7E5##0{body}"),
        ("what slaves send is no command", f"> 7E4#{body}"),
        ("the identifier beside is another one", f"> 7E6#{body}"),
    ]:
        yield name, FRESH, [line, data(frame(0x5E)), "= waiting node 255 rate 3"]


def checked_by_hand():
    for name, setup, lines in by_hand():
        outcome = run(watched(Slave(**setup)), lines)
        if outcome != lines:
            raise AssertionError(f"{name}:\n{lines}\nmodel:\n{outcome}")
        yield name, setup, lines


def watched(model):
    """Remembers when sending was to go on, for after the bit rate is found."""
    command = model.command

    def remember(now, raw):
        lines = command(now, raw)
        if raw[0] == 0x15 and "! stop" in lines:
            model.resume = now + 2 * (raw[1] + 256 * raw[2])
        return lines

    model.command = remember
    return model


def random_command(rng):
    number = rng.choice([*IDENTITY, *IDENTITY, 0, 0xFFFFFFFF, rng.getrandbits(32)])
    kind = rng.randrange(14)
    if kind < 3:
        return [frame(0x04, rng.choice([0, 0, 1, 1, 1, 2]))]
    if kind < 5:
        return [frame(0x11, rng.choice([0, 1, 5, 127, 128, 255, 255]))]
    if kind < 6:
        return [frame(0x13, rng.choice([0, 0, 0, 1, 200]), rng.randrange(11))]
    if kind < 7:
        return [frame(0x15, ("u16", rng.choice([0, 1, 10, 200])))]
    if kind < 8:
        numbers = RANGE if rng.random() < 0.6 else changed(RANGE, rng.randrange(6), number)
        return identify(numbers)[rng.choice([0, 0, 0, 1]) :]
    if kind < 9:
        return SELECT if rng.random() < 0.7 else [*SELECT[:3], frame(0x43, u32(number))]
    if kind < 12:
        sub = rng.randrange(4)
        bit = rng.choice([0, 0, 0, 5, 31, 32, 128, 128])
        scanned = IDENTITY[sub] if rng.random() < 0.8 else number
        whole = [BEGIN, *ALL_PARTS[: rng.randrange(5)]] if rng.random() < 0.5 else []
        return [*whole, scan(scanned, bit, sub, rng.choice([sub, (sub + 1) % 4, rng.randrange(6)]))]
    return [frame(rng.choice([0x17, 0x4C, 0x5A, 0x5B, 0x5C, 0x5D, 0x5E, rng.randrange(256)]))]


def sessions(count=40, steps=30):
    """Random commands; what the model does with them."""
    for seed in range(count):
        rng = random.Random(f"lss {seed}")
        setup = rng.choice([FRESH, FRESH, CONFIGURED, MINI_MASTER, SLOW_ONLY, {"storage": "broken"}])
        lines, now = [], 0
        for _ in range(steps):
            roll = rng.random()
            if roll < 0.1:
                now += rng.choice([1, 10, 199, 200, 500])
                lines.append(f"@ {now}")
            elif roll < 0.14:
                lines.append("? found")
            elif roll < 0.18:
                lines.append("? reset")
            else:
                lines += [data(raw) for raw in random_command(rng)]
            if rng.random() < 0.1:
                lines.append("= ")
        model = watched(Slave(**setup))
        yield f"random session {seed}", setup, [*run(model, lines), model.status()]

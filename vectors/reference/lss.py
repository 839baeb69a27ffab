"""CiA 305 (LSS): how commands look in eight bytes, and a model of what a slave does with them."""

import struct

VENDOR, PRODUCT, REVISION, SERIAL = 0x11223344, 0x55667788, 0x00020001, 0x99AABBCC
IDENTITY = [VENDOR, PRODUCT, REVISION, SERIAL]
RATES = {0: 1_000_000, 1: 800_000, 2: 500_000, 3: 250_000, 4: 125_000, 6: 50_000, 7: 20_000, 8: 10_000}
AUTOMATIC = 9
NONE = 255


def frame(*fields):
    """A number is a byte, ("u16", n) and ("u32", n) are little-endian; zeros up to eight bytes."""
    raw = b""
    for field in fields:
        raw += bytes([field]) if isinstance(field, int) else struct.pack({"u16": "<H", "u32": "<I"}[field[0]], field[1])
    return raw.ljust(8, b"\0")


def u32(value):
    return ("u32", value)


PARTS = ["vendor_id", "product_code", "revision_number", "serial_number"]
BOUNDS = ["vendor_id", "product_code", "revision_number_low", "revision_number_high", "serial_number_low", "serial_number_high"]
NUMBER = 0x8091A2B3

# Name of the command, its fields, its bytes.
REQUESTS = [
    ("switch_state_global", {"mode": 0}, frame(0x04, 0)),
    ("switch_state_global", {"mode": 1}, frame(0x04, 1)),
    ("switch_state_global", {"mode": 200}, frame(0x04, 200)),
    *[("switch_state_selective", {"part": name, "number": NUMBER}, frame(0x40 + k, u32(NUMBER))) for k, name in enumerate(PARTS)],
    ("configure_node_id", {"node_id": 127}, frame(0x11, 127)),
    ("configure_node_id", {"node_id": 255}, frame(0x11, 255)),
    ("configure_bit_timing", {"table_selector": 0, "table_index": 9}, frame(0x13, 0, 9)),
    ("configure_bit_timing", {"table_selector": 129, "table_index": 3}, frame(0x13, 129, 3)),
    ("activate_bit_timing", {"switch_delay_ms": 0x1234}, frame(0x15, ("u16", 0x1234))),
    ("store_configuration", {}, frame(0x17)),
    *[("identify_remote_slave", {"bound": name, "number": NUMBER}, frame(0x46 + k, u32(NUMBER))) for k, name in enumerate(BOUNDS)],
    ("identify_non_configured_remote_slave", {}, frame(0x4C)),
    ("fastscan", {"id_number": NUMBER, "bit_checked": 31, "lss_sub": 2, "lss_next": 3}, frame(0x51, u32(NUMBER), 31, 2, 3)),
    ("fastscan", {"id_number": 0, "bit_checked": 128, "lss_sub": 0, "lss_next": 0}, frame(0x51, u32(0), 128, 0, 0)),
    *[("inquire_identity", {"part": name}, frame(0x5A + k)) for k, name in enumerate(PARTS)],
    ("inquire_node_id", {}, frame(0x5E)),
]
RESPONSES = [
    *[
        (name, {"error_code": error, "specific_error": specific}, frame(cs, error, specific))
        for name, cs in [("configure_node_id", 0x11), ("configure_bit_timing", 0x13), ("store_configuration", 0x17)]
        for error, specific in [(0, 0), (1, 0), (2, 0), (255, 77)]
    ],
    ("switch_state_selective", {}, frame(0x44)),
    ("identify_slave", {}, frame(0x4F)),
    ("identify_non_configured_slave", {}, frame(0x50)),
    *[("inquire_identity", {"part": name, "number": NUMBER}, frame(0x5A + k, u32(NUMBER))) for k, name in enumerate(PARTS)],
    ("inquire_node_id", {"node_id": 42}, frame(0x5E, 42)),
]
UNKNOWN_REQUESTS = sorted(set(range(256)) - {request[2][0] for request in REQUESTS})
UNKNOWN_RESPONSES = sorted(set(range(256)) - {response[2][0] for response in RESPONSES})


class Slave:
    """A slave as CiA 305 has it. Commands in, lines of a script out."""

    def __init__(self, node_id=NONE, rate=3, rates=tuple(RATES), automatic=True, storage="works"):
        self.active_id = self.pending_id = node_id
        self.active_rate = self.pending_rate = rate
        self.rates, self.automatic, self.storage = set(rates), automatic, storage
        self.configuring = False
        self.history = []
        self.position = 0
        self.reset = False
        # What is still to be done of an activation: (time in ms, what).
        self.plan = []

    def unconfigured(self):
        return self.active_id == NONE and self.pending_id == NONE

    def advance(self, now):
        """What the node has to do up to now."""
        lines = []
        while self.plan and self.plan[0][0] <= now:
            what = self.plan.pop(0)[1]
            if what.startswith("switch"):
                self.active_rate = self.target
                if self.target == AUTOMATIC:
                    self.plan = [(entry[0], "found?") for entry in self.plan]
            if what == "found?":
                # Sending goes on only once the bit rate is found.
                self.plan.insert(0, (float("inf"), what))
                break
            lines.append("! " + what)
        return lines + self.autonomous()

    def autonomous(self):
        if self.reset and not self.plan:
            self.reset = False
            return [f"! reset {self.pending_id}"]
        return []

    def command(self, now, data):
        cs, rest = data[0], data[1:]
        value = int.from_bytes(rest[:4], "little")
        if cs in UNKNOWN_REQUESTS:
            return []
        self.history = (self.history + [(cs, value)])[-6:]
        if cs == 0x04:
            self.history = []
            return self.switch(rest[0])
        if self.plan:
            return []
        answer = self.answer(now, cs, rest, value)
        if cs == 0x15 and self.configuring:
            return ["! stop"] + self.advance(now)
        return [] if answer is None else ["< 7E4#" + answer.hex().upper()]

    def switch(self, mode):
        if mode == 1:
            self.configuring = True
        elif mode == 0:
            self.position = 0
            if self.configuring and self.active_id == NONE and self.pending_id != NONE:
                self.reset = True
            self.configuring = False
        return self.autonomous()

    def answer(self, now, cs, rest, value):
        if cs == 0x4B:
            v, p, r, s = IDENTITY
            asked = self.history
            in_order = [cs for cs, _ in asked] == [0x46, 0x47, 0x48, 0x49, 0x4A, 0x4B]
            if in_order:
                values = [number for _, number in asked]
                if values[:2] == [v, p] and values[2] <= r <= values[3] and values[4] <= s <= values[5]:
                    return frame(0x4F)
            return None
        if cs == 0x4C:
            return frame(0x50) if self.unconfigured() else None
        return self.configuration(now, cs, rest) if self.configuring else self.waiting(cs, rest, value)

    def waiting(self, cs, rest, value):
        if cs == 0x43 and self.history[-4:] == list(zip(range(0x40, 0x44), IDENTITY)):
            self.configuring = True
            return frame(0x44)
        if cs == 0x51 and self.unconfigured():
            bit, sub, following = rest[4:7]
            if bit == 0x80:
                self.position = 0
                return frame(0x4F)
            if bit > 31 or sub > 3 or following > 3 or sub != self.position:
                return None
            if value // 2**bit != IDENTITY[sub] // 2**bit:
                return None
            self.position = following
            if bit == 0 and following < sub:
                self.configuring = True
            return frame(0x4F)
        return None

    def configuration(self, now, cs, rest):
        if cs == 0x11:
            if not (1 <= rest[0] <= 127 or rest[0] == NONE):
                return frame(cs, 1)
            self.pending_id = rest[0]
            return frame(cs, 0)
        if cs == 0x13:
            known = rest[0] == 0 and (rest[1] in self.rates or (rest[1] == AUTOMATIC and self.automatic))
            if known:
                self.pending_rate = rest[1]
            return frame(cs, 0 if known else 1)
        if cs == 0x15:
            delay = rest[0] + 256 * rest[1]
            self.target = self.pending_rate
            rate = "automatic" if self.target == AUTOMATIC else RATES[self.target]
            self.plan = [(now + delay, f"switch {rate}"), (now + 2 * delay, "resume")]
        if cs == 0x17:
            return {"works": frame(cs, 0), "none": frame(cs, 1), "broken": frame(cs, 2), "manufacturer": frame(cs, 255, 42)}[self.storage]
        if 0x5A <= cs <= 0x5D:
            return frame(cs, u32(IDENTITY[cs - 0x5A]))
        if cs == 0x5E:
            return frame(cs, self.pending_id if self.active_id == NONE else self.active_id)
        return None

    def status(self):
        state = "configuration" if self.configuring else "waiting"
        return f"= {state} node {self.pending_id} rate {self.pending_rate}"

"""A receiver that watches a bus bit by bit [ISO 11898-1] and never drives it.

It sends no flag of its own, so after an error it takes the dominant bits that follow for the flags
of the others, and eight recessive bits after them for the delimiter.
"""

from dataclasses import dataclass, field
from typing import Optional

from crc import CRC15, crc, fd_code
from frame import Frame, data_length, stuff_count_field


@dataclass(frozen=True)
class Event:
    """What happened. kind: "frame", "error" or "overload"; start and end are bit numbers.

    `error` is one of stuff, form, crc, and `frame` is there for kind "frame".
    """

    kind: str
    start: int
    end: int
    frame: Optional[Frame] = None
    crc: Optional[int] = None
    acknowledged: bool = False
    error: Optional[str] = None


class BusError(Exception):
    """The frame broke a rule at the bit just taken."""


class ProtocolException(Exception):
    """Protocol exception: wait for eleven recessive bits without an error flag."""


@dataclass
class Receiver:
    """Feed it bits; it collects events. It starts integrated unless told otherwise."""

    iso: bool = True
    integrated: bool = True
    events: list = field(default_factory=list)

    def run(self, bits):
        """Takes all `bits` and returns the events."""
        machine = self._machine()
        next(machine)
        for bit in bits:
            machine.send(bit)
        machine.close()
        return self.events

    def _machine(self):
        self.time = -1
        if not self.integrated:
            yield from self._integrate()
        while True:
            outcome = "sof" if (yield from self._take()) == 0 else "idle"
            while outcome == "sof":
                outcome = yield from self._frame_and_tail()
            if outcome == "integrate":
                yield from self._integrate()

    def _take(self):
        bit = yield
        self.time += 1
        return bit

    def _integrate(self):
        count = 0
        while count < 11:
            bit = yield from self._take()
            count = count + 1 if bit == 1 else 0

    def _frame_and_tail(self):
        """From a dominant SOF bit just taken to the end of the intermission.

        Returns "idle", or "sof" if the third bit of the intermission was the next SOF, or
        "integrate" after a protocol exception.
        """
        start = self.time
        try:
            event = yield from self._frame(start)
            self.events.append(event)
            overload = self.last_eof_bit == 0
        except BusError as error:
            overload = yield from self._error(start, str(error))
        except ProtocolException:
            return "integrate"
        while True:
            if overload:
                overload = yield from self._overload()
            elif (yield from self._take()) == 0 or (yield from self._take()) == 0:
                overload = True  # a dominant bit in the first two of the intermission
            else:
                return "sof" if (yield from self._take()) == 0 else "idle"

    def _error(self, start, name):
        """Flags and delimiter after an error; whether an overload flag follows at once."""
        overload = yield from self._delimiter()
        self.events.append(Event("error", start, self.time, error=name))
        return overload

    def _overload(self):
        """The rest of an overload flag, whose first bit was just taken, and its delimiter."""
        start = self.time
        for _ in range(5):
            if (yield from self._take()) == 1:
                return (yield from self._error(start, "form"))
        overload = yield from self._delimiter()
        self.events.append(Event("overload", start, self.time))
        return overload

    def _delimiter(self):
        """Takes bits until eight recessive ones in a row; the eighth may be an overload flag."""
        recessive = 0
        while recessive < 8:
            bit = yield from self._take()
            if bit == 0 and recessive == 7:
                return True
            recessive = recessive + 1 if bit == 1 else 0
        return False

    def _frame(self, start):
        reader = Unstuffer(self)
        reader.accept(0)
        identifier = yield from reader.number(11)
        rtr = yield from reader.bit()
        extended = (yield from reader.bit()) == 1
        if extended:
            identifier = identifier << 18 | (yield from reader.number(18))
            rtr = yield from reader.bit()
        fd = (yield from reader.bit()) == 1
        brs = esi = False
        if fd:
            if (yield from reader.bit()) == 1:
                raise ProtocolException
            brs = (yield from reader.bit()) == 1
            esi = (yield from reader.bit()) == 1
        elif extended:
            yield from reader.bit()  # r0: either value is accepted
        dlc = yield from reader.number(4)
        kind = "fd" if fd else "remote" if rtr else "data"
        data = bytearray()
        for _ in range(data_length(kind, dlc)):
            data.append((yield from reader.number(8)))
        if fd:
            value, good = yield from self._fd_crc(reader, len(data))
        else:
            value, good = yield from self._classic_crc(reader)
        frame = Frame(identifier, extended, kind, dlc, bytes(data), brs, esi, self.iso or not fd)
        acknowledged = yield from self._acknowledge(fd)
        if not good:
            raise BusError("crc")
        yield from self._end_of_frame()
        return Event("frame", start, self.time, frame, value, acknowledged)

    def _classic_crc(self, reader):
        wanted = crc(CRC15, reader.plain)
        value = yield from reader.number(15)
        # Five equal bits at the end of the CRC sequence are followed by a stuff bit.
        yield from reader.pending_stuff_bit()
        return value, value == wanted

    def _fd_crc(self, reader, length):
        code = fd_code(length, self.iso)
        covered = list(reader.wire)
        field_bits = []
        previous = covered[-1]
        for index in range((4 if self.iso else 0) + code.width):
            if index % 4 == 0:
                stuff_bit = yield from self._take()
                if stuff_bit == previous:
                    raise BusError("form")
            previous = yield from self._take()
            field_bits.append(previous)
        good = True
        if self.iso:
            count, field_bits = field_bits[:4], field_bits[4:]
            good = count == stuff_count_field(reader.stuff_bits)
            covered += count
        value = int("".join(map(str, field_bits)), 2)
        return value, good and value == crc(code, covered)

    def _acknowledge(self, fd):
        """CRC delimiter, ACK slot and ACK delimiter.

        A CAN FD receiver tolerates a CRC delimiter and an ACK of two bits each.
        """
        if (yield from self._take()) == 0:
            raise BusError("form")
        slot = yield from self._take()
        following = yield from self._take()
        if not fd:
            if following == 0:
                raise BusError("form")
            return slot == 0
        if slot == 1 and following == 1:
            return False
        if slot == 0 and following == 1:
            return True
        delimiter = yield from self._take()
        if delimiter == 0:
            raise BusError("form")
        return True

    def _end_of_frame(self):
        for _ in range(6):
            if (yield from self._take()) == 0:
                raise BusError("form")
        # To a receiver the frame is good before the last bit; dominant there means overload.
        self.last_eof_bit = yield from self._take()


class Unstuffer:
    """Reads dynamically stuffed bits of a receiver."""

    def __init__(self, receiver):
        self.receiver = receiver
        self.plain, self.wire = [], []
        self.stuff_bits = 0
        self.last, self.run = None, 0

    def _count(self, bit):
        self.run = self.run + 1 if bit == self.last else 1
        self.last = bit
        self.wire.append(bit)

    def accept(self, bit):
        """A bit that was taken already."""
        self._count(bit)
        self.plain.append(bit)

    def pending_stuff_bit(self):
        """Takes the stuff bit that is due after five equal bits."""
        if self.run == 5:
            bit = yield from self.receiver._take()
            if bit == self.last:
                raise BusError("stuff")
            self._count(bit)
            self.stuff_bits += 1

    def bit(self):
        yield from self.pending_stuff_bit()
        bit = yield from self.receiver._take()
        self.accept(bit)
        return bit

    def number(self, width):
        value = 0
        for _ in range(width):
            value = value << 1 | (yield from self.bit())
        return value

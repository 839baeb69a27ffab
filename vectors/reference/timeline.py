"""A bus on a time axis: who drives what when, and what a recorder with a clock of its own sees.

Times are exact fractions of a second, so that a vector is the same on every machine.
"""

import math
import random
from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True)
class Rates:
    """Bit rates in bit/s, sample points in percent; `error_ppm` makes the bit times longer."""

    nominal: Fraction
    data: Fraction = Fraction(0)
    error_ppm: Fraction = Fraction(0)
    nominal_sample_point: Fraction = Fraction(80)
    data_sample_point: Fraction = Fraction(75)

    def stretch(self):
        return 1 + Fraction(self.error_ppm) / 1_000_000

    def bit(self):
        return self.stretch() / Fraction(self.nominal)

    def data_bit(self):
        return self.stretch() / Fraction(self.data)


def boundaries(encoded, rates, start):
    """The start of every bit, and the end of the last one."""
    times = [start]
    for index in range(len(encoded.bits)):
        length = rates.bit()
        if encoded.brs is not None:
            nominal_part = rates.bit() * Fraction(rates.nominal_sample_point, 100)
            data_part = rates.data_bit() * Fraction(rates.data_sample_point, 100)
            if index == encoded.brs:
                length = nominal_part + rates.data_bit() - data_part
            elif encoded.brs < index < encoded.crc_delimiter:
                length = rates.data_bit()
            elif index == encoded.crc_delimiter:
                length = data_part + rates.bit() - nominal_part
        times.append(times[-1] + length)
    return times


class Bus:
    """Collects dominant intervals; `now` is the end of what has happened."""

    def __init__(self):
        self.dominant = []
        self.glitches = []
        self.now = Fraction(0)

    def idle(self, seconds):
        self.now += Fraction(seconds)

    def drive(self, start, end):
        self.dominant.append((start, end))

    def send(self, encoded, rates, bits=None):
        """The first `bits` bits of a frame (all without it); returns the bit boundaries."""
        times = boundaries(encoded, rates, self.now)
        count = len(encoded.bits) if bits is None else bits
        for index in range(count):
            if encoded.bits[index] == 0:
                self.drive(times[index], times[index + 1])
        self.now = times[count]
        return times

    def frame(self, encoded, rates, ack=True, ack_delay=Fraction(0)):
        """A whole frame; `ack_delay` is how late the dominant ACK slot arrives, in seconds."""
        times = self.send(encoded, rates)
        if ack:
            slot = encoded.crc_delimiter + 1
            self.drive(times[slot] + ack_delay, times[slot + 1] + ack_delay)
        return times

    def error_frame(self, encoded, rates, bits, flag_bits=6, delay=Fraction(0)):
        """A frame that ends in an error flag after `bits` bits; the delimiter follows."""
        self.send(encoded, rates, bits)
        start = self.now + delay
        self.drive(start, start + flag_bits * rates.bit())
        self.now = start + (flag_bits + 8) * rates.bit()

    def overload_frame(self, rates, flag_bits=7):
        """To be called right after a frame: the flag begins with the intermission."""
        self.drive(self.now, self.now + flag_bits * rates.bit())
        self.now += (flag_bits + 8) * rates.bit()

    def glitch(self, at, width):
        """Inverts the line for a moment."""
        self.glitches.append((Fraction(at), Fraction(at) + Fraction(width)))

    def transitions(self, asymmetry=Fraction(0), jitter=None):
        """Times at which the line toggles, recessive before the first.

        `asymmetry` lengthens every dominant interval; `jitter(i)` moves the i-th edge.
        """
        merged = []
        for start, end in sorted(self.dominant):
            if merged and start <= merged[-1][1]:
                merged[-1][1] = max(merged[-1][1], end)
            else:
                merged.append([start, end])
        toggles = []
        for start, end in merged:
            toggles += [start, end + asymmetry]
        if jitter:
            toggles = [at + jitter(index) for index, at in enumerate(toggles)]
        for start, end in self.glitches:
            toggles += [start, end]
        return sorted(toggles)


def sampled(toggles, frequency, begin, end, phase=Fraction(0)):
    """(levels inverted at begin, ticks of the edges, last tick) of a recorder that samples.

    Tick n is at begin + (n + phase) / frequency; an edge has the first tick at or after it, and
    two edges in one tick cancel.
    """
    before = sum(1 for at in toggles if at <= begin)
    edges = []
    for at in toggles:
        if begin < at <= end:
            tick = math.ceil((at - begin) * frequency - phase)
            if edges and edges[-1] == tick:
                edges.pop()
            else:
                edges.append(tick)
    return before % 2, edges, math.ceil((end - begin) * frequency - phase)


def seeded_jitter(seed, peak_ns):
    """Uniform jitter of up to `peak_ns` either way, the same on every machine."""
    rng = random.Random(seed)

    def jitter(_):
        return Fraction(rng.randint(-1000 * peak_ns, 1000 * peak_ns), 10**12)

    return jitter

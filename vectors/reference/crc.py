"""CRCs of CAN [ISO 11898-1], bit by bit, from the exponents of their generator polynomials."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Code:
    """A generator polynomial (exponents below the highest) and the register's start value."""

    width: int
    exponents: tuple
    starts_with_one: bool

    def polynomial(self):
        return sum(1 << exponent for exponent in self.exponents)

    def start(self):
        return 1 << (self.width - 1) if self.starts_with_one else 0


# x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1
CRC15 = Code(15, (14, 10, 8, 7, 4, 3, 0), False)
# x^17 + x^16 + x^14 + x^13 + x^11 + x^6 + x^4 + x^3 + x + 1
CRC17_EXPONENTS = (16, 14, 13, 11, 6, 4, 3, 1, 0)
# x^21 + x^20 + x^13 + x^11 + x^7 + x^4 + x^3 + 1
CRC21_EXPONENTS = (20, 13, 11, 7, 4, 3, 0)


def fd_code(data_length, iso):
    """The code of a CAN FD frame: 17 bits up to 16 bytes, 21 bits above; ISO starts with a one."""
    if data_length <= 16:
        return Code(17, CRC17_EXPONENTS, iso)
    return Code(21, CRC21_EXPONENTS, iso)


def crc(code, bits):
    """The CRC of a sequence of 0 and 1."""
    register = code.start()
    top = 1 << (code.width - 1)
    for bit in bits:
        feedback = bool(register & top) != bool(bit)
        register = (register << 1) & (2 * top - 1)
        if feedback:
            register ^= code.polynomial()
    return register

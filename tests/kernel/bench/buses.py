"""Buses as scenarios of `canbaud simulate`; the adapter is always the node "tester"."""


def bus(bitrate, period="20ms"):
    """Two nodes that acknowledge each other; a frame per `period` on average, None: silence."""
    text = f"""title = "a bus of {bitrate} bit/s"
duration = "30min"
seed = 1

[[node]]
name = "engine"
bitrate = "{bitrate}"
ppm = 100

[[node]]
name = "dash"
bitrate = "{bitrate}"
ppm = -100

[[node]]
name = "tester"
bitrate = "{bitrate}"
monitoring_counters = "counting"
"""
    if period:
        text += f"""
[[traffic]]
node = "engine"
kind = "poisson"
period = "{period}"
id = 0x123
dlc = 8

[[traffic]]
node = "dash"
kind = "periodic"
period = "100ms"
id = 0x18FEF100
extended = true
dlc = 4
payload = "counter"
"""
    return text


def fd_bus(bitrate, data_bitrate, period="20ms"):
    """The same in CAN FD frames with rate switch, and classic ones between."""
    text = bus(bitrate, period).replace(
        f'bitrate = "{bitrate}"\n', f'bitrate = "{bitrate}"\ndata_bitrate = "{data_bitrate}"\n'
    )
    return text.replace("dlc = 8\n", 'dlc = 11\nformat = "fd-brs"\n')

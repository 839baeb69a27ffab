"""Buses as scenarios of `canbaud simulate`; the adapter is always the node "tester"."""


def bus(bitrate, period="20ms", clock="80M"):
    """Two nodes that acknowledge each other, one frame per `period`, `period` None: silence."""
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
clock = "{clock}"
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

"""User-Mode Linux: a whole kernel as one program, its root the host's own, read only."""

import glob
import os
import tty

from .guest import Guest, spawn

HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MODULES = [
    "net/can/can",
    "net/can/can-raw",
    "drivers/net/can/dev/can-dev",
    "drivers/net/can/vcan",
    "drivers/net/can/slcan/slcan",
]


def boot(adapter_pty, logs):
    """Boots; the guest's /dev/ttyS0 is `adapter_pty`. Takes two seconds."""
    line, agent = os.openpty()
    tty.setraw(agent)
    modules = sorted(glob.glob("/usr/lib/uml/modules/*/kernel"))[-1]
    command = [
        "linux.uml",
        "mem=256M",
        "root=/dev/root",
        "rootfstype=hostfs",
        "rootflags=/",
        "ro",
        f"init={HERE}/guest/init-uml",
        "con=null",
        "con0=null,fd:1",
        "ssl=null",
        f"ssl0=tty:{adapter_pty}",
        f"ssl1=tty:{os.ttyname(agent)}",
        "LINE=/dev/ttyS1",
        f"MODULE_DIR={modules}",
        f"MODULES={','.join(MODULES)}",
        "loglevel=5",
    ]
    process = spawn(command, f"{logs}/console.log")
    guest = Guest(process, line, f"{logs}/guest.log")
    try:
        guest.wait_ready(60)
    except Exception:
        guest.stop()
        raise
    # UML has its own descriptor by now; ours keeps the line open over a hang-up.
    guest.agent_side = agent
    return guest

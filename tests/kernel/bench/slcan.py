"""What the scenarios with the kernel's slcan driver share."""

import json
import re
import shlex

from . import uml
from .adapter import SlcanAdapter

# candump that shows each frame, errors too, and where it came from ("TX": from this host).
CANDUMP = "candump -x -e can0,0:0,#FFFFFFFF"


class Bench:
    """One boot of User-Mode Linux with the virtual adapter at its serial port."""

    def __init__(self, canbaud, logs, report):
        self.canbaud = canbaud
        self.logs = logs
        self.report = report
        self.adapter = SlcanAdapter(canbaud, logs)
        self.guest = None

    def boot(self):
        self.guest = uml.boot(self.adapter.path, self.logs)
        # Users other than root may not reach the place that it was built in.
        self.sh(f"install -m 755 {shlex.quote(self.canbaud)} /run/canbaud")

    def stop(self):
        self.adapter.unplug()
        if self.guest:
            self.guest.stop()
            self.guest = None

    def sh(self, script, timeout=20):
        """Runs a script in the guest."""
        return self.guest.run(script, timeout)

    def attach(self, name, bus, options=()):
        """A fresh can0, down and without a bit rate, whose adapter is at `bus`."""
        self.sh(
            "pid=$(cat /run/slcand.pid 2>/dev/null) && kill $pid && sleep 0.3\n"
            "while ip link show can0 >/dev/null 2>&1; do sleep 0.1; done"
        )
        self.adapter.plug(name, bus, options)
        result = self.sh(
            "slcand -F ttyS0 can0 >/run/slcand.log 2>&1 &\n"
            "echo $! >/run/slcand.pid\n"
            "for try in 1 2 3 4 5 6 7 8 9 10; do\n"
            "    ip link show can0 >/dev/null 2>&1 && break; sleep 0.2\n"
            "done\n"
            "ip link show can0 || cat /run/slcand.log"
        )
        if result.status != 0 or "can0" not in result.output:
            raise RuntimeError(f"slcand does not attach: {result.output}")

    def link(self):
        """Settings of can0 as the kernel has them."""
        return settings(self.sh("ip -details -json link show can0").output)

    def errors_and_frames(self, seconds=1):
        """What a listener hears: error frames, frames from the bus, frames from this host."""
        heard = self.sh(f"timeout {seconds} {CANDUMP}; true", seconds + 10).output.splitlines()
        frames = [line for line in heard if re.match(r"\s+can0 ", line)]
        errors = sum("ERRORFRAME" in line for line in frames)
        local = sum(" TX " in line for line in frames)
        return errors, len(frames) - errors - local, local

    def never_disturbed(self):
        """The check behind all others: nothing was sent, and the channel only opened to listen."""
        self.report.check(
            not self.adapter.disturbing(),
            "the adapter was only told to listen",
            " ".join(self.adapter.disturbing()),
        )


def settings(text):
    """`ip -details -json link show` reduced to what a scan has to put back."""
    link = json.loads(text)[0]
    can = link.get("linkinfo", {}).get("info_data", {})
    kept = {key: link.get(key) for key in ("flags", "mtu", "operstate", "txqlen")}
    for key in ("ctrlmode", "bittiming", "data_bittiming", "restart_ms", "termination"):
        kept[key] = can.get(key)
    return kept

"""The bench with the kernel's slcan driver: User-Mode Linux, the adapter at its serial port."""

import shlex

from . import uml
from .adapter import SlcanAdapter
from .bench import Bench


class SlcanBench(Bench):
    name = "slcan"
    driver = "slcan"

    def __init__(self, canbaud, logs, report):
        super().__init__(logs, report)
        self.canbaud = canbaud
        self.adapter = SlcanAdapter(canbaud, self.logs)

    def boot(self):
        self.guest = uml.boot(self.adapter.path, self.logs)
        # Users other than root may not reach the place that it was built in.
        self.prepare(f"install -m 755 {shlex.quote(self.canbaud)} /run/canbaud")

    def stop(self):
        self.adapter.unplug()
        super().stop()

    def plug(self, bus, *options):
        self.unplug()
        self.adapter.plug(self.report.scenario, bus, options or ["--errors", "records"])
        self.prepare(
            "slcand -F ttyS0 can0 >/run/slcand.log 2>&1 &\n"
            "echo $! >/run/slcand.pid\n"
            "for try in 1 2 3 4 5 6 7 8 9 10; do\n"
            "    ip link show can0 >/dev/null 2>&1 && exit; sleep 0.2\n"
            "done\n"
            "cat /run/slcand.log; exit 1"
        )

    def unplug(self):
        self.sh(
            "pid=$(cat /run/slcand.pid 2>/dev/null) && kill $pid && sleep 0.3\n"
            "while ip link show can0 >/dev/null 2>&1; do sleep 0.1; done\n"
            "rm -f /run/slcand.pid"
        )
        self.adapter.unplug()

    def disturbing(self):
        return self.adapter.disturbing()

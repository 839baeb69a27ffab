"""The bench with the kernel's gs_usb driver: QEMU, the adapter a program inside the guest."""

import shlex

from . import qemu
from .bench import Bench


class GsUsbBench(Bench):
    name = "gs_usb"
    driver = "gs_usb"

    def __init__(self, version, kernel, canbaud, device, logs, report):
        self.name = f"gs_usb-{version}"
        super().__init__(logs, report)
        self.version = version
        self.kernel = kernel
        self.programs = {"canbaud": canbaud, "gs_usb_device": device}

    def boot(self):
        self.guest = qemu.boot(self.kernel, self.programs, self.logs)
        self.prepare("cp /bin/canbaud /run/canbaud")

    def plug(self, bus, *options):
        self.unplug()
        self.prepare(
            f"cat >/run/bus.toml <<'END'\n{bus}\nEND\n"
            f"gs_usb_device /run/bus.toml tester {shlex.join(options)} >/run/device.log 2>&1 &\n"
            "echo $! >/run/device.pid\n"
            "for try in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15; do\n"
            "    ip link show can0 >/dev/null 2>&1 && exit; sleep 0.2\n"
            "done\n"
            "cat /run/device.log; exit 1"
        )

    def unplug(self):
        self.sh(
            "pid=$(cat /run/device.pid 2>/dev/null) && kill $pid\n"
            "while ip link show can0 >/dev/null 2>&1; do sleep 0.1; done\n"
            "rm -f /run/device.pid"
        )

    def told(self):
        """The lines of the adapter's log."""
        return self.sh("cat /run/device.log").output.splitlines()

    def disturbing(self):
        def harmless(line):
            closed = line.startswith("close ") and line.endswith(" 0 dominant")
            return closed or line == "attached" or line.startswith("open listen-only ")

        return [line for line in self.told() if not harmless(line)]

"""What every bench has: a guest, a bus behind its can0, and a report."""

import json
import os
import re

# candump that shows each frame, errors too, and where it came from ("TX": from this host).
CANDUMP = "candump -x -e can0,0:0,#FFFFFFFF"


class Bench:
    """One boot of one kernel. A bench of its own says how to boot and how to plug in a bus."""

    # Of its logs; the kernel's driver.
    name = ""
    driver = ""

    def __init__(self, logs, report):
        self.logs = f"{logs}/{self.name}"
        os.makedirs(self.logs)
        self.report = report
        self.guest = None

    def boot(self):
        """Starts the guest, with the program under test as /run/canbaud."""
        raise NotImplementedError

    def plug(self, bus, *options):
        """A fresh can0 at `bus`, down and never set up; `options` are the adapter's."""
        raise NotImplementedError

    def unplug(self):
        """Pulls the adapter out."""
        raise NotImplementedError

    def disturbing(self):
        """What the adapter was told, or did, that may disturb a bus."""
        raise NotImplementedError

    def stop(self):
        """Ends the guest."""
        if self.guest:
            self.guest.stop()
            self.guest = None

    def sh(self, script, timeout=20):
        """Runs a shell script in the guest."""
        return self.guest.run(script, timeout)

    def prepare(self, script, timeout=20):
        """Runs a script that has to succeed for the scenario to go on."""
        result = self.sh(script, timeout)
        if result.status != 0:
            raise RuntimeError(f"{script}\nstatus {result.status}\n{result.output}")

    def settings(self):
        """The settings of can0 that a scan has to put back."""
        answer = self.sh("ip -details -json link show can0")
        if answer.status != 0:
            return {"absent": answer.output}
        link = json.loads(answer.output)[0]
        kept = {key: link.get(key) for key in ("flags", "mtu", "operstate", "txqlen")}
        kept["ctrlmode"] = []
        kept.update(link.get("linkinfo", {}).get("info_data", {}))
        # These change by themselves.
        for key in ("state", "berr_counter"):
            kept.pop(key, None)
        return kept

    def bitrate(self):
        """The bit rate that can0 is set to, in bit/s."""
        settings = self.settings()
        # Drivers with fixed rates have no segments.
        return settings.get("bittiming", {}).get("bitrate", settings.get("bittiming_bitrate"))

    def set_up(self, rate, *modes):
        """Sets can0 to a rate, listen-only, and up."""
        modes = " ".join(modes)
        return self.sh(
            f"ip link set can0 type can bitrate {rate} listen-only on {modes} && "
            "ip link set can0 up"
        )

    def down(self):
        self.sh("ip link set can0 down")

    def heard(self, seconds=1):
        """What a listener hears: (error frames, frames from the bus, frames from this host)."""
        answer = self.sh(f"timeout {seconds} {CANDUMP} 2>/dev/null; true", seconds + 10)
        frames = [line for line in answer.output.splitlines() if re.match(r"\s+can0 ", line)]
        errors = sum("ERRORFRAME" in line for line in frames)
        local = sum(" TX " in line for line in frames)
        return errors, len(frames) - errors - local, local

    def never_disturbed(self):
        """The check behind all others: nothing was sent, the channel only opened to listen."""
        self.report.check(
            not self.disturbing(), "the adapter only ever listened", "\n".join(self.disturbing())
        )

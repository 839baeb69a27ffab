"""The far end of the guest's serial line: a virtual slcan adapter, and two witnesses.

The adapter is `canbaud simulate --slcan`, one process per bus; it logs what it did to the bus. The
guest's line stays the same over many buses: a relay stands between the two, and notes what the
guest's driver really asks for.
"""

import os
import select
import signal
import subprocess
import threading
import time
import tty

# What an adapter may be told without disturbing a bus: set-up, listen-only, questions.
HARMLESS = set("CSsLFVvNmZWXUQEY")
# In the log of the adapter: it took part, sent, or was not silent.
DISTURBING = (": open normal", ": open loopback", ": sent", " ! ")


class SlcanAdapter:
    """The line is there from the beginning, and nobody answers before a bus is plugged in."""

    def __init__(self, canbaud, logs):
        self.canbaud = canbaud
        self.logs = logs
        self.host, self.guest_side = os.openpty()
        tty.setraw(self.guest_side)
        self.path = os.ttyname(self.guest_side)
        self.lock = threading.Lock()
        self.simulator = None
        self.device = None
        self.log = None
        self.deeds = os.devnull
        self.commands = []
        self.partial = b""
        self.wake, self.woken = os.pipe()
        threading.Thread(target=self._relay, daemon=True).start()

    def plug(self, name, bus, options=()):
        """A new adapter at a new bus; what the one before it was told is forgotten."""
        self.unplug()
        scenario = f"{self.logs}/{name}.toml"
        with open(scenario, "w", encoding="utf-8") as file:
            file.write(bus)
        errors = open(f"{self.logs}/{name}.simulator", "wb")
        simulator = subprocess.Popen(
            [self.canbaud, "simulate", scenario, "--slcan", "tester", *options,
             "--log", f"{self.logs}/{name}.adapter"],
            stdout=subprocess.PIPE,
            stderr=errors,
        )
        path = simulator.stdout.readline().decode().strip()
        if not path:
            simulator.wait()
            errors.close()
            with open(errors.name, encoding="utf-8") as file:
                raise RuntimeError(f"canbaud simulate: {file.read().strip()}")
        device = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(device)
        with self.lock:
            # The serial line of User-Mode Linux tells the driver that a command is written only when
            # something comes in; the driver passes over an empty record.
            self.nudge = b"\r" if "canable1" in options else b""
            self.simulator, self.device = simulator, device
            self.log = open(f"{self.logs}/{name}.line", "w", encoding="utf-8")
            self.deeds = f"{self.logs}/{name}.adapter"
            self.began = time.monotonic()
            self.commands, self.partial = [], b""
        os.write(self.woken, b"x")

    def unplug(self):
        """Ends the bus; the line itself stays."""
        with self.lock:
            if self.simulator is None:
                return
            simulator, device = self.simulator, self.device
            self.simulator = self.device = None
            self.log.close()
        simulator.send_signal(signal.SIGTERM)
        simulator.wait()
        simulator.stdout.close()
        os.close(device)
        os.write(self.woken, b"x")

    def heard(self):
        """The commands so far, in order."""
        with self.lock:
            return list(self.commands)

    def disturbing(self):
        """What the adapter was told that is not only listening, and what it did to the bus."""
        told = [command for command in self.heard() if command[0] not in HARMLESS]
        with open(self.deeds, encoding="utf-8") as log:
            lines = log.read().splitlines()
        # Without the times: one line for each kind of deed is enough.
        deeds = [line.split(" ", 1)[1] for line in lines if any(deed in line for deed in DISTURBING)]
        return list(dict.fromkeys(told + deeds))

    def _relay(self):
        while True:
            device = self.device
            ready = select.select([self.wake, self.host] + ([device] if device else []), [], [])[0]
            if self.wake in ready:
                os.read(self.wake, 64)
                continue
            try:
                if self.host in ready:
                    self._from_guest(os.read(self.host, 4096))
                if device in ready:
                    self._to_guest(os.read(device, 4096))
            except OSError:
                # One of the two has just gone.
                time.sleep(0.05)

    def _from_guest(self, data):
        with self.lock:
            if self.device is None:
                return
            *lines, self.partial = (self.partial + data).split(b"\r")
            for line in filter(None, lines):
                command = line.decode(errors="replace")
                self.commands.append(command)
                self._note(">", command)
            os.write(self.device, data)
        os.write(self.host, self.nudge)

    def _to_guest(self, data):
        with self.lock:
            if self.log and not self.log.closed:
                self._note("<", data.decode(errors="replace").replace("\r", " "))
        os.write(self.host, data)

    def _note(self, way, text):
        self.log.write(f"{time.monotonic() - self.began:9.4f} {way} {text}\n")
        self.log.flush()

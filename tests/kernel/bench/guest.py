"""A shell inside a booted kernel, reached over a serial line."""

import base64
import os
import select
import signal
import subprocess
import time
from dataclasses import dataclass


class GuestHung(Exception):
    """The guest no longer answers, or is gone."""


@dataclass
class Result:
    """What a script printed, and its exit status (124: it took too long)."""

    status: int
    output: str


class Guest:
    """A running kernel; `line` is our end of the line that guest/agent serves."""

    def __init__(self, process, line, log_path):
        self.process = process
        self.line = line
        self.log = open(log_path, "a", encoding="utf-8")
        self.number = 0
        self.waiting = b""

    def wait_ready(self, timeout):
        """Waits until the agent runs."""
        self._read_until(0, time.monotonic() + timeout)

    def run(self, script, timeout=20):
        """Runs a shell script to its end."""
        self.number += 1
        self._note(f"$ {script.strip()}")
        packed = base64.b64encode(script.encode()).decode()
        os.write(self.line, f"{self.number} {timeout} {packed}\n".encode())
        # The guest ends the script itself; if it does not, it hangs.
        result = self._read_until(self.number, time.monotonic() + timeout + 15)
        self._note(f"{result.output}\n= {result.status}\n")
        return result

    def stop(self):
        """Ends the guest with everything that belongs to it."""
        if self.process.poll() is None:
            try:
                os.killpg(self.process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.process.wait()
        self.log.close()

    def _note(self, text):
        self.log.write(text + "\n")
        self.log.flush()

    def _read_until(self, number, deadline):
        marker = f"@@{number} ".encode()
        while True:
            at = self.waiting.find(marker)
            end = self.waiting.find(b"\n", at) if at >= 0 else -1
            if end >= 0:
                status = int(self.waiting[at + len(marker) : end])
                output = self.waiting[:at].decode(errors="replace").strip("\r\n")
                self.waiting = self.waiting[end + 1 :]
                return Result(status, output)
            left = deadline - time.monotonic()
            if left <= 0:
                raise GuestHung("the guest does not answer")
            if self.process.poll() is not None:
                raise GuestHung(f"the guest ended by itself (status {self.process.returncode})")
            if select.select([self.line], [], [], min(left, 0.5))[0]:
                self.waiting += os.read(self.line, 65536)


def spawn(command, console_path, **options):
    """Starts a guest in a process group of its own, its console in a file."""
    with open(console_path, "ab") as console:
        return subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=console,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            **options,
        )

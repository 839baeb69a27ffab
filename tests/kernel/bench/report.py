"""One line for each check, a summary, and how to repeat what failed."""

import time


class Report:
    def __init__(self):
        self.passed = 0
        self.failed = []
        self.skipped = []
        self.began = time.monotonic()
        self.scenario = ""
        self.seconds = {}

    def begin(self, scenario):
        self.scenario = scenario
        self.started = time.monotonic()

    def end(self):
        """Notes how long the scenario took."""
        taken = time.monotonic() - self.started
        self.seconds[self.scenario] = self.seconds.get(self.scenario, 0) + taken

    def check(self, good, what, detail=""):
        """Prints and counts one check; `detail` is shown if it failed."""
        if good:
            self.passed += 1
            print(f"ok    {self.scenario}: {what}", flush=True)
        else:
            self.failed.append(f"{self.scenario}: {what}")
            print(f"FAIL  {self.scenario}: {what}", flush=True)
            for line in str(detail).strip().splitlines():
                print(f"      | {line}", flush=True)
        return bool(good)

    def equal(self, got, want, what):
        return self.check(got == want, what, f"got:  {got}\nwant: {want}")

    def note(self, what):
        """Something that is neither good nor bad."""
        print(f"note  {self.scenario}: {what}", flush=True)

    def skip(self, what, reason):
        self.skipped.append(what)
        print(f"skip  {what}: {reason}", flush=True)

    def summary(self, repeat, logs, not_here):
        """The last lines; the exit status: 0, 1, or `not_here` if something was not checked."""
        seconds = time.monotonic() - self.began
        slowest = sorted(self.seconds.items(), key=lambda one: -one[1])[:5]
        print("slowest:", ", ".join(f"{name} {taken:.0f} s" for name, taken in slowest))
        for failure in self.failed:
            print(f"failed: {failure}")
        for what in self.skipped:
            print(f"skipped: {what}")
        print(
            f"kernel: {self.passed} ok, {len(self.failed)} failed, {len(self.skipped)} skipped, "
            f"{seconds:.0f} s"
        )
        if self.failed:
            print(f"again:  {repeat}\nlogs:   {logs}")
            return 1
        return not_here if self.skipped or not self.passed else 0

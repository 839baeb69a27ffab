"""What the exit status says: what was skipped must not pass for checked."""

import contextlib
import io
import unittest

from .report import Report

NOT_HERE = 77


def status(passed=0, failed=0, skipped=()):
    report = Report()
    with contextlib.redirect_stdout(io.StringIO()) as out:
        report.begin("scenario")
        for good in [True] * passed + [False] * failed:
            report.check(good, "check")
        for what in skipped:
            report.skip(what, "reason")
        code = report.summary("again", "logs", NOT_HERE)
    return code, out.getvalue()


class ExitStatus(unittest.TestCase):
    def test_all_checked(self):
        self.assertEqual(status(passed=2)[0], 0)

    def test_skipped_beside_passed_is_told_by_status_and_name(self):
        code, text = status(passed=2, skipped=["gs_usb-6.1"])
        self.assertEqual(code, NOT_HERE)
        self.assertIn("skipped: gs_usb-6.1\n", text)

    def test_nothing_checked(self):
        self.assertEqual(status()[0], NOT_HERE)

    def test_failed_goes_before_skipped(self):
        self.assertEqual(status(passed=1, failed=1, skipped=["gs_usb-6.1"])[0], 1)


if __name__ == "__main__":
    unittest.main()

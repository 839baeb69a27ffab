"""Scenarios with the kernel's slcan driver. A scenario is a function that takes the bench."""

from .buses import bus

# The rates that the kernel's slcan driver knows.
RATES = (10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)


def kernel_facts(bench):
    """What the kernel itself does: the ground that a scan stands on."""
    report = bench.report
    bench.attach("kernel_facts", bus(250_000))
    fresh = bench.link()
    report.equal(fresh["operstate"], "DOWN", "a fresh interface is down")

    def listen(rate):
        up = f"ip link set can0 type can bitrate {rate} listen-only on && ip link set can0 up"
        report.equal(bench.sh(up).status, 0, f"it can be set to {rate} bit/s listen-only")

    listen(500_000)
    errors, frames, _ = bench.errors_and_frames()
    report.check(errors > 5 and frames == 0, "at a wrong rate: error frames, no frames",
                 f"{errors} error frames, {frames} frames")
    busy = bench.sh("ip link set can0 type can bitrate 125000")
    report.check(busy.status != 0 and "busy" in busy.output.lower(),
                 "no change of rate while it is up", busy.output)

    sent = bench.sh(
        "timeout 1 candump -x can0 >/run/heard & sleep 0.3; cansend can0 7A5#DEADBEEF; echo $?\n"
        "wait; grep -c 'TX .* 7A5 ' /run/heard"
    )
    report.equal(sent.output.split(), ["0", "1"],
                 "trap 1: a frame of this host comes back although nothing was sent")
    bench.sh("ip link set can0 down")

    listen(250_000)
    errors, frames, _ = bench.errors_and_frames()
    report.check(errors == 0 and frames > 5, "at the right rate: frames, no error frames",
                 f"{errors} error frames, {frames} frames")
    bench.sh("ip link set can0 down")

    odd = bench.sh("ip link set can0 type can bitrate 83333")
    report.check(odd.status != 0, "slcan knows only its own nine rates", odd.output)
    berr = bench.sh("ip link set can0 type can berr-reporting on")
    report.check(berr.status != 0 and "not supported" in berr.output.lower(),
                 "slcan refuses berr-reporting", berr.output)
    used = sorted(set(bench.adapter.heard()))
    report.equal(used, ["C", "L", "S5", "S6"], "the driver says C, Sn and L")
    bench.never_disturbed()


ALL = [kernel_facts]

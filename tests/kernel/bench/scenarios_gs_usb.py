"""Scenarios for the kernel's gs_usb driver alone."""

from .buses import bus, fd_bus
from .scenarios_live import detect, finds, found, puts_back


def gs_usb_facts(bench):
    """What the driver of this kernel does: the ground that a scan stands on."""
    report = bench.report
    bench.plug(bus(250_000))
    berr = bench.set_up(500_000, "berr-reporting on")
    if bench.version == "6.1":
        report.check(berr.status != 0 and "not supported" in berr.output.lower(),
                     "no berr-reporting in this kernel", berr.output)
        report.equal(bench.bitrate(), 500_000,
                     "trap 5: the rate was changed although the request failed")
        bench.set_up(500_000)
        errors, frames, _ = bench.heard()
        report.check(frames == 0 and errors < 3, "at a wrong rate: no frames, no bus errors",
                     f"{errors} error frames, {frames} frames")
    else:
        report.equal(berr.status, 0, "berr-reporting")
        errors, frames, _ = bench.heard()
        report.check(errors > 5 and frames == 0, "at a wrong rate: error frames, no frames",
                     f"{errors} error frames, {frames} frames")
        counter = bench.sh("ip -details link show can0").output
        report.check("berr-counter tx 0 rx" in counter, "the error counters can be read", counter)
    bench.down()

    bench.set_up(250_000)
    errors, frames, _ = bench.heard()
    report.check(errors == 0 and frames > 5, "at the right rate: frames, no error frames",
                 f"{errors} error frames, {frames} frames")
    sent = bench.sh("cansend can0 7A5#DEADBEEF; echo $?")
    report.equal(sent.output, "0", "trap 9: who sends in listen-only is told no error")
    bench.down()
    bench.never_disturbed()


def gs_usb_witness(bench):
    """The log of the adapter tells when somebody takes part in the bus, and disturbs it."""
    bench.plug(bus(250_000))
    bench.sh(
        "ip link set can0 type can bitrate 500000 listen-only off; ip link set can0 up\n"
        "sleep 1; ip link set can0 down"
    )
    told = "\n".join(bench.disturbing())
    bench.report.check("open normal" in told and "bus disturbed" in told,
                       "normal mode at a wrong rate is noticed", told)


def gs_usb_firmwares(bench):
    """Firmwares differ in what they tell of a wrong rate."""
    for reports in ("always", "states"):
        bench.plug(bus(125_000), "--reports", reports)
        finds(bench, 125_000)
        bench.never_disturbed()


def gs_usb_odd_rate(bench):
    """83.333 kbit/s, which this driver can be set to."""
    bench.plug(bus(83_333))
    finds(bench, 83_333)
    bench.never_disturbed()


def gs_usb_without_listen_only(bench):
    """An adapter that cannot listen is refused: exit 7, the reason, and never opened."""
    bench.plug(bus(125_000), "--without", "listen-only")
    result = detect(bench)
    bench.report.check(result.status == 7 and "listen" in result.output,
                       "refused", f"status {result.status}\n{result.output}")
    bench.report.equal(bench.told(), ["attached"], "never opened")


def gs_usb_stale_frames(bench):
    """Frames that the adapter kept from before the change of rate prove nothing."""
    bench.plug(bus(250_000), "--stale", "3")
    bench.set_up(250_000)
    bench.heard()
    bench.down()
    result = detect(bench, "--rates 500k,125k --timeout 5s")
    bench.report.check(result.status in (3, 4) and found(result.output) is None,
                       "no verdict", f"status {result.status}\n{result.output}")
    bench.never_disturbed()


def gs_usb_fd(bench):
    """CAN FD: the nominal rate first, then the data rate."""
    bench.plug(fd_bus(500_000, 2_000_000), "--fd")
    result = finds(bench, 500_000, "--fd")
    bench.report.check("data 2 Mbit/s" in result.output, "and the data rate", result.output)
    bench.never_disturbed()


def gs_usb_fd_heard_by_classic(bench):
    """A classic controller on a CAN FD bus hears every other frame: the nominal rate or none."""
    bench.plug(fd_bus(500_000, 2_000_000))
    result = detect(bench)
    bench.report.check(found(result.output) in (500_000, None), "no other rate",
                       f"status {result.status}\n{result.output}")
    bench.never_disturbed()


FINE_STATES = {
    "segments": "ip link set can0 type can tq 125 prop-seg 6 phase-seg1 5 phase-seg2 4 sjw 3",
    "CAN FD": "ip link set can0 type can bitrate 500000 sample-point 0.8 sjw 2 "
              "dbitrate 2000000 dsample-point 0.7 fd on && ip link set can0 up",
}


def gs_usb_puts_back_the_timing(bench):
    """Sample points, segments, SJW and the data phase are those that were set."""
    for state, setup in FINE_STATES.items():
        puts_back(bench, state, setup, "SIGTERM", "--fd")
    # LSS alone changes the rate of an interface that takes part.
    bench.plug(bus(250_000, period=None))
    bench.prepare("ip link set can0 type can bitrate 250000 sample-point 0.75 sjw 3 && "
                  "ip link set can0 up")
    before = bench.settings()
    result = bench.sh("/run/canbaud lss serve --address 1:2:3:4 --on can0 --bitrate 125k "
                      "--transmit --for 1s & sleep 0.7; ip -details link show can0; wait")
    bench.report.check("sample-point 0.750" in result.output and "sjw 3" in result.output,
                       "a chosen sample point and SJW hold at the rate of LSS", result.output)
    bench.report.equal(bench.settings(), before, "and are put back with the rate")
    bench.down()


ALL = [
    gs_usb_facts,
    gs_usb_witness,
    gs_usb_firmwares,
    gs_usb_odd_rate,
    gs_usb_without_listen_only,
    gs_usb_stale_frames,
    gs_usb_fd,
    gs_usb_fd_heard_by_classic,
    gs_usb_puts_back_the_timing,
]

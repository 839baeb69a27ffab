"""Scenarios for the kernel's gs_usb driver alone."""

from .buses import bus


def gs_usb_facts(bench):
    """What the driver of this kernel does: the ground that a scan stands on."""
    report = bench.report
    bench.plug(bus(250_000))
    berr = bench.set_up(500_000, "berr-reporting on")
    if bench.version == "6.1":
        report.check(berr.status != 0 and "not supported" in berr.output.lower(),
                     "no berr-reporting in this kernel", berr.output)
        report.equal(bench.settings()["bittiming"]["bitrate"], 500_000,
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


ALL = [gs_usb_facts, gs_usb_witness]

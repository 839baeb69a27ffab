"""Scenarios for User-Mode Linux alone: the slcan driver, and vcan."""

import os
import subprocess

from .buses import bus
from .scenarios_live import detect, finds, found


def slcan_facts(bench):
    """What the driver itself does: the ground that a scan stands on."""
    report = bench.report
    bench.plug(bus(250_000))
    report.equal(bench.settings()["operstate"], "DOWN", "a fresh interface is down")

    bench.set_up(500_000)
    errors, frames, _ = bench.heard()
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
    bench.down()

    bench.set_up(250_000)
    errors, frames, _ = bench.heard()
    report.check(errors == 0 and frames > 5, "at the right rate: frames, no error frames",
                 f"{errors} error frames, {frames} frames")
    bench.down()

    odd = bench.sh("ip link set can0 type can bitrate 83333")
    report.check(odd.status != 0, "only the driver's own nine rates", odd.output)
    berr = bench.sh("ip link set can0 type can berr-reporting on")
    report.check(berr.status != 0 and "not supported" in berr.output.lower(),
                 "no berr-reporting", berr.output)
    used = sorted(set(bench.adapter.heard()))
    report.equal(used, ["C", "L", "S5", "S6"], "the driver says C, Sn and L")
    bench.never_disturbed()


def slcan_witness(bench):
    """The log of the adapter tells when somebody takes part in the bus."""
    bench.plug(bus(250_000))
    bench.sh(
        "ip link set can0 type can bitrate 500000; ip link set can0 up\n"
        "sleep 1; ip link set can0 down"
    )
    told = "\n".join(bench.disturbing())
    bench.report.check(told.startswith("O\n") and "! error flag" in told,
                       "normal mode at a wrong rate is noticed", told)


def slcan_silent_firmware(bench):
    """An adapter that reports no errors: only frames tell."""
    bench.plug(bus(125_000), "--errors", "silent")
    finds(bench, 125_000)
    bench.never_disturbed()


def slcan_without_l(bench):
    """Trap 4: a CANable 1.x ignores L and stays closed: no verdict, and a hint."""
    bench.plug(bus(125_000), "--firmware", "canable1")
    result = detect(bench, "--timeout 3s")
    bench.report.check(result.status in (3, 4) and found(result.output) is None,
                       "no verdict", f"status {result.status}\n{result.output}")
    bench.report.check("slcan:" in result.output, "points to the serial port", result.output)
    bench.never_disturbed()


# Those that use the interface, and compare no times.
STEPS = ("master_of_canopen", "slave_of_durand", "several_devices", "whole_network")
PEERS = os.path.abspath(f"{os.path.dirname(__file__)}/../../../scripts/lss-peers")


def lss_over_vcan(bench):
    """LSS masters and slaves of others against ours, on SocketCAN."""
    prepared = subprocess.run([PEERS, "--prepare"], capture_output=True, text=True, check=False)
    if prepared.returncode == 77:
        bench.report.skip("lss_over_vcan", prepared.stdout.strip())
        return
    bench.prepare("ip link add vcan0 type vcan; ip link set vcan0 up")
    only = " ".join(f"--only {step}" for step in STEPS)
    result = bench.sh(
        f"export PYTHONDONTWRITEBYTECODE=1\n"
        f"{PEERS} --interface socketcan --channel vcan0 --canbaud /run/canbaud {only}", 240)
    bench.sh("ip link del vcan0")
    bench.report.check(result.status == 0, "scripts/lss-peers passes", result.output)


ALL = [
    slcan_facts,
    slcan_witness,
    slcan_silent_firmware,
    slcan_without_l,
    lss_over_vcan,
]

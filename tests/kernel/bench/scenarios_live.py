"""Scenarios for `canbaud detect can0` that hold with any driver."""

import re

from .buses import bus

# The programs that send frames of this host all the while; they never reach the bus.
OWN_FRAMES = """
( while :; do cansend can0 7A5#DEADBEEF; cansend can0 7A6#$(date +%N | cut -c1-8); sleep 0.02; done
) >/dev/null 2>&1 &
sender=$!
"""


def detect(bench, options="", timeout=40):
    """Runs `canbaud detect can0`; a script's result."""
    return bench.sh(f"/run/canbaud detect can0 {options}", timeout)


def found(output):
    """The bit rate that the verdict names; None if there is no verdict."""
    line = re.search(r"^(\d+(?:\.\d+)?) ([kM]?)bit/s\b.*", output, re.MULTILINE)
    if not line:
        return None
    return round(float(line[1]) * {"": 1, "k": 1_000, "M": 1_000_000}[line[2]])


def finds(bench, rate, options=""):
    """Checks that a scan finds `rate`; the scan's result."""
    result = detect(bench, options)
    bench.report.check(
        result.status == 0 and found(result.output) == rate,
        f"finds {rate} bit/s",
        f"status {result.status}\n{result.output}",
    )
    return result


def follows_the_advice(bench, output):
    """Runs the command that the verdict recommends."""
    advice = re.search(r"^ +(ip link set .*)", output, re.MULTILINE)
    result = bench.sh(advice[1] if advice else "echo there is none; exit 1")
    bench.report.check(result.status == 0, "the command that it recommends works",
                       f"{advice and advice[1]}\n{result.output}")


def finds_the_rate(bench):
    """The rate is found, and the interface is down again as it was."""
    for rate in (20_000, 125_000, 500_000, 1_000_000):
        bench.plug(bus(rate))
        before = bench.settings()
        output = finds(bench, rate).output
        after = bench.settings()
        # A rate that was never set cannot be taken away again: Linux has no way to.
        for state in (before, after):
            for key in ("bittiming", "bittiming_bitrate"):
                state.pop(key, None)
        bench.report.equal(after, before, f"the interface is as it was ({rate} bit/s)")
        bench.never_disturbed()
    follows_the_advice(bench, output)


def puts_back(bench, state, setup, ending, *options):
    """Sets can0 up, ends a scan of a silent bus in some way, and compares."""
    script, wanted = ENDINGS[ending]
    bench.plug(bus(250_000, period=None), *options)
    bench.prepare(setup)
    opened = bench.disturbing()
    before = bench.settings()
    result = bench.sh(script)
    # A program that was ended before it had begun would prove nothing.
    bench.report.check(result.status in wanted and "listening at" in result.output,
                       f"{ending} ends the scan, {state}",
                       f"status {result.status}\n{result.output}")
    bench.report.equal(bench.settings(), before, f"as it was after {ending}, {state}")
    # An interface that took part before takes part again; the scan itself never did.
    bench.report.check(set(bench.disturbing()) == set(opened), "the scan only ever listened",
                       "\n".join(bench.disturbing()))


# Statuses: undecided or no traffic; 128 + signal.
ENDINGS = {
    "the time limit": ("/run/canbaud detect can0 --timeout 2s", (3, 4)),
    "SIGINT": ("timeout --preserve-status -s INT 3 /run/canbaud detect can0", (130,)),
    "SIGTERM": ("timeout --preserve-status -s TERM 3 /run/canbaud detect can0", (143,)),
}
STATES = {
    "down with a rate": "ip link set can0 type can bitrate 125000",
    "down, listen-only": "ip link set can0 type can bitrate 500000 listen-only on",
    "up, normal": "ip link set can0 type can bitrate 250000 && "
                  "ip link set can0 txqueuelen 77 up",
    "up, listen-only": "ip link set can0 type can bitrate 100000 listen-only on && "
                       "ip link set can0 up",
}


def puts_everything_back(bench):
    """However the scan ends, the interface is as it was found."""
    for ending in ENDINGS:
        puts_back(bench, "up, normal", STATES["up, normal"], ending)
    for state, setup in STATES.items():
        if state != "up, normal":
            puts_back(bench, state, setup, "SIGINT")


def applies_the_rate(bench):
    """--apply leaves the found rate set, listening; with --normal taking part."""
    report = bench.report
    bench.plug(bus(125_000))
    finds(bench, 125_000, "--apply")
    state = bench.settings()
    report.equal((bench.bitrate(), state["ctrlmode"], state["operstate"]),
                 (125_000, ["LISTEN-ONLY"], "UP"), "--apply: up at 125 kbit/s, listen-only")
    _, frames, _ = bench.heard()
    report.check(frames > 5, "and it hears the bus", frames)
    bench.never_disturbed()
    finds(bench, 125_000, "--apply --normal")
    state = bench.settings()
    report.equal((bench.bitrate(), state["ctrlmode"], state["operstate"]),
                 (125_000, [], "UP"), "--apply --normal: up at 125 kbit/s, taking part")
    bench.down()


LSS = "/run/canbaud lss"
# How `canbaud lss` ends, and with what status, while it has can0 at 125 kbit/s.
LSS_ENDINGS = {
    "no answer": (f"{LSS} inquire --on can0 --bitrate 125k --transmit --timeout 100ms", 4),
    "SIGTERM": (f"timeout --preserve-status -s TERM 1.5 {LSS} serve --address 1:2:3:4 --on can0 "
                "--bitrate 125k --transmit", 143),
    "nobody who reads": (f"{LSS} serve --address 1:2:3:4 --on can0 --bitrate 125k --transmit "
                         "--for 1s 2>&- >&-", 0),
}


def lss_puts_back(bench):
    """LSS changes the bit rate for a time; where an activation succeeded, it stays."""
    report = bench.report
    setup = "ip link set can0 type can bitrate 250000 && ip link set can0 txqueuelen 77 up"
    for ending, (script, wanted) in LSS_ENDINGS.items():
        bench.plug(bus(250_000, period=None))
        bench.prepare(setup)
        before = bench.settings()
        result = bench.sh(script)
        report.equal(result.status, wanted, f"{ending} ends it")
        if wanted:
            report.check("can0 is put back as it was found" in result.output,
                         f"and it says that it is put back ({ending})", result.output)
        report.equal(bench.settings(), before, f"as it was after {ending}")
        bench.down()
    bench.plug(bus(250_000, period=None))
    bench.prepare(setup)
    result = bench.sh(f"{LSS} activate --on can0 --delay 50ms --to 500k --transmit")
    report.check(result.status == 0 and "can0 stays at 500kbit/s" in result.output,
                 "an activation is gone along with", f"status {result.status}\n{result.output}")
    report.equal((bench.bitrate(), bench.settings()["operstate"]), (500_000, "UP"),
                 "and can0 is up at 500 kbit/s")
    bench.down()


def needs_the_permission(bench):
    """Without CAP_NET_ADMIN: one clear line, exit 6, and nothing was touched."""
    bench.plug(bus(125_000))
    before = bench.settings()
    nobody = "setpriv --reuid 65534 --regid 65534 --clear-groups --bounding-set -all"
    result = bench.sh(f"{nobody} /run/canbaud detect can0")
    bench.report.equal(result.status, 6, "exit 6")
    bench.report.check("CAP_NET_ADMIN" in result.output and "setcap" in result.output,
                       "says how to grant it", result.output)
    bench.report.equal(bench.settings(), before, "nothing was touched")
    bench.never_disturbed()


def ignores_its_own_host(bench):
    """Trap 1: frames of this host that come back are no proof of any rate."""
    bench.plug(bus(250_000, period=None))
    result = bench.sh(f"{OWN_FRAMES} /run/canbaud detect can0 --timeout 5s; status=$?\n"
                      "kill $sender; exit $status", 30)
    bench.report.check(result.status in (3, 4) and found(result.output) is None,
                       "on a silent bus they prove nothing",
                       f"status {result.status}\n{result.output}")
    bench.plug(bus(250_000))
    result = bench.sh(f"{OWN_FRAMES} /run/canbaud detect can0; status=$?\n"
                      "kill $sender; exit $status", 40)
    bench.report.check(result.status == 0 and found(result.output) == 250_000,
                       "beside them the right rate is found",
                       f"status {result.status}\n{result.output}")
    bench.never_disturbed()


def survives_the_unplugging(bench):
    """An adapter that is pulled out in mid-scan is an error, not a hang."""
    bench.plug(bus(250_000, period=None))
    bench.sh("(/run/canbaud detect can0 >/run/out 2>&1; echo $? >/run/status) & sleep 1.5")
    bench.unplug()
    result = bench.sh("sleep 2; cat /run/out /run/status")
    bench.report.check(result.output.endswith("7") and "gone" in result.output,
                       "one line, exit 7", result.output)


def refuses_what_has_no_rate(bench):
    """vcan has no bit rate; exit 7 and the reason."""
    bench.prepare("ip link add vcan0 type vcan; ip link set vcan0 up")
    result = bench.sh("/run/canbaud detect vcan0")
    bench.sh("ip link del vcan0")
    bench.report.check(result.status == 7 and "virtual" in result.output,
                       "vcan0 is refused", f"status {result.status}\n{result.output}")


def lists_the_adapters(bench):
    """`canbaud adapters` knows the interface and its driver."""
    bench.plug(bus(250_000))
    result = bench.sh("/run/canbaud adapters")
    bench.report.check(result.status == 0 and re.search(rf"can0.*{bench.driver}", result.output),
                       f"can0 with driver {bench.driver}", result.output)


ALL = [
    finds_the_rate,
    puts_everything_back,
    applies_the_rate,
    lss_puts_back,
    needs_the_permission,
    ignores_its_own_host,
    survives_the_unplugging,
    refuses_what_has_no_rate,
    lists_the_adapters,
]

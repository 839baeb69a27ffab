"""A Debian kernel in QEMU (TCG), for drivers that User-Mode Linux does not have."""

import glob
import os
import pty
import subprocess
import tty

from .guest import Guest, spawn
from .initramfs import Initramfs, find

HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# In the order in which they are loaded.
MODULES = ["usb-common", "usbcore", "can", "can-raw", "can-dev", "vcan", "usbip-core", "vhci-hcd",
           "gs_usb"]
# Programs of the host; what else a script needs is busybox.
PROGRAMS = ["dash", "ip", "candump", "cansend", "setpriv", "timeout"]


def initramfs(kernel, programs, path):
    """Writes the archive for `kernel`; `programs` maps names in the guest to files here."""
    archive = Initramfs()
    for directory in ("/dev", "/proc", "/sys", "/run", "/tmp"):
        archive.directory(directory)
    applets = subprocess.run(["busybox", "--list"], capture_output=True, text=True, check=True)
    for applet in applets.stdout.split():
        archive.link(f"/bin/{applet}", "busybox")
    archive.program(find("busybox"), "/bin/busybox")
    for program in PROGRAMS:
        archive.program(find(program), f"/bin/{program}")
    # Busybox's own shell would prefer its own ip, whatever PATH says.
    archive.link("/bin/sh", "dash")
    for name, source in programs.items():
        archive.program(source, f"/bin/{name}")
    for name in ("agent", "init-qemu"):
        with open(f"{HERE}/guest/{name}", "rb") as file:
            archive.add(f"/{name}", file.read(), 0o755)
    archive.add("/etc/passwd", b"root:x:0:0::/:/bin/sh\nnobody:x:65534:65534::/:/bin/sh\n")
    order = []
    for module in MODULES:
        found = glob.glob(f"{kernel}/lib/modules/*/**/{module}.ko*", recursive=True)
        if not found:
            raise RuntimeError(f"{kernel} has no module {module}")
        order.append(archive.module(found[0]))
    archive.add("/modules/order", "".join(f"{name}\n" for name in order).encode())
    archive.write(path)


def boot(kernel, programs, logs):
    """Boots `kernel`, an unpacked Debian package."""
    initramfs(kernel, programs, f"{logs}/initramfs")
    line, agent = pty.openpty()
    tty.setraw(agent)
    command = [
        "qemu-system-x86_64", "-machine", "q35,accel=tcg", "-cpu", "max", "-smp", "1",
        "-m", "512", "-nodefaults", "-display", "none", "-no-reboot",
        "-kernel", glob.glob(f"{kernel}/boot/vmlinuz-*")[0],
        "-initrd", f"{logs}/initramfs",
        "-append", "console=ttyS0 rdinit=/init-qemu LINE=/dev/ttyS1 panic=1 loglevel=5 "
        "tsc=reliable mitigations=off nokaslr",
        "-serial", "stdio",
        "-chardev", f"serial,id=agent,path={os.ttyname(agent)}", "-serial", "chardev:agent",
    ]
    process = spawn(command, f"{logs}/console.log")
    guest = Guest(process, line, f"{logs}/guest.log")
    guest.agent_side = agent
    try:
        guest.wait_ready(180)
    except Exception:
        guest.stop()
        raise
    return guest

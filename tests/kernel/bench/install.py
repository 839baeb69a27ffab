"""Installs what a bench needs, by package name."""

import glob
import os
import re
import shutil
import subprocess

UML = {
    "linux.uml": "user-mode-linux",
    "slcand": "can-utils",
    "ip": "iproute2",
    "busybox": "busybox-static",
}
QEMU = {
    "qemu-system-x86_64": "qemu-system-x86",
    "candump": "can-utils",
    "ip": "iproute2",
    "busybox": "busybox-static",
    "dash": "dash",
    "dpkg-deb": "dpkg",
}
# Of a kernel package only this is unpacked.
KERNEL_PARTS = ["./boot/vmlinuz-*", "*/kernel/net/can/*", "*/kernel/drivers/net/can/*",
                "*/kernel/drivers/usb/*"]


def install(commands):
    """Installs the packages of the commands that are absent; a message if that cannot be done."""
    absent = missing(commands)
    if absent and not apt("install", "-y", "-qq", "--no-install-recommends", *absent):
        # The lists may be old or empty.
        apt("update", "-qq")
        apt("install", "-y", "-qq", "--no-install-recommends", *absent)
    absent = " ".join(missing(commands))
    return f"cannot be installed here: {absent} (apt-get install {absent})" if absent else None


def missing(commands):
    path = os.environ["PATH"] + ":/usr/sbin:/sbin"
    return sorted({name for command, name in commands.items() if not shutil.which(command, path=path)})


def apt(*arguments):
    """Runs apt-get as root, if that is possible; whether it worked."""
    if not shutil.which("apt-get"):
        return False
    become_root = [] if os.geteuid() == 0 else ["sudo", "-n"]
    if become_root and not shutil.which("sudo"):
        return False
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    command = [*become_root, "apt-get", *arguments]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.run(command, env=environment, check=False, **quiet).returncode == 0


def kernel(version, cache):
    """The newest Debian kernel of `version` ("6.1"), unpacked below `cache`; None: not to be had."""
    have = glob.glob(f"{cache}/linux-image-{version}.*/boot/vmlinuz-*")
    if have:
        return os.path.dirname(os.path.dirname(have[0]))
    package = newest(version)
    if not package:
        apt("update", "-qq")
        package = newest(version)
    if not package:
        return None
    os.makedirs(cache, exist_ok=True)
    subprocess.run(["apt-get", "download", "-qq", package], cwd=cache, check=False,
                   stderr=subprocess.DEVNULL)
    archives = glob.glob(f"{cache}/{package}_*.deb")
    if not archives:
        return None
    unpack(archives[0], f"{cache}/{package}")
    os.remove(archives[0])
    return f"{cache}/{package}"


def newest(version):
    """The name of the newest package: "linux-image-6.1.0-47-amd64"."""
    listed = subprocess.run(["apt-cache", "pkgnames", f"linux-image-{version}."],
                            capture_output=True, text=True, check=False).stdout.split()
    plain = rf"linux-image-{re.escape(version)}\.[\d.+a-z-]*?-amd64"
    names = [name for name in listed if re.fullmatch(plain, name)
             and not re.search(r"-(rt|cloud|dbg)-", name)]
    return max(names, key=lambda name: [int(number) for number in re.findall(r"\d+", name)],
               default=None)


def unpack(archive, place):
    """Unpacks what a guest needs; only a whole one gets its name."""
    part = f"{place}.part"
    shutil.rmtree(part, ignore_errors=True)
    os.makedirs(part)
    with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", archive],
                          stdout=subprocess.PIPE) as files:
        subprocess.run(["tar", "-x", "-C", part, "--wildcards", *KERNEL_PARTS],
                       stdin=files.stdout, check=True)
    os.rename(part, place)

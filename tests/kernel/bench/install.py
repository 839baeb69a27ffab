"""Installs what a bench needs, by package name."""

import os
import shutil
import subprocess

UML = {
    "linux.uml": "user-mode-linux",
    "slcand": "can-utils",
    "ip": "iproute2",
    "busybox": "busybox-static",
}


def for_uml():
    """Installs what the User-Mode Linux bench needs; says what cannot be had, if anything."""
    return install(UML)


def install(commands):
    """Installs the packages of the commands that are absent. The answer is a message, or None."""
    absent = [package for command, package in commands.items() if not shutil.which(command)]
    if absent and not apt("install", "-y", "-qq", "--no-install-recommends", *absent):
        # The lists may be old or empty.
        apt("update", "-qq")
        apt("install", "-y", "-qq", "--no-install-recommends", *absent)
    absent = [package for command, package in commands.items() if not shutil.which(command)]
    if absent:
        return f"cannot be installed here: {' '.join(absent)} (apt-get install {' '.join(absent)})"
    return None


def apt(*arguments):
    """Runs apt-get as root, if that is possible; whether it worked."""
    if not shutil.which("apt-get"):
        return False
    become_root = [] if os.geteuid() == 0 else ["sudo", "-n"]
    if become_root and not shutil.which("sudo"):
        return False
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    command = [*become_root, "apt-get", *arguments]
    done = subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, check=False)
    return done.returncode == 0

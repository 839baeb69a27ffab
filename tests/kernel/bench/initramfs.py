"""An initramfs (cpio, "newc") with the host's own programs and the libraries that they need."""

import gzip
import lzma
import os
import shutil
import stat
import subprocess


class Initramfs:
    """Collects files, then writes the archive."""

    def __init__(self):
        self.entries = {}

    def directory(self, path):
        parent = os.path.dirname(path.strip("/"))
        if parent:
            self.directory(parent)
        self.entries.setdefault(path.strip("/"), (stat.S_IFDIR | 0o755, b""))

    def add(self, path, content, mode=0o644):
        self.directory(os.path.dirname(path))
        self.entries[path.strip("/")] = (stat.S_IFREG | mode, content)

    def link(self, path, target):
        self.directory(os.path.dirname(path))
        self.entries[path.strip("/")] = (stat.S_IFLNK | 0o777, target.encode())

    def module(self, path):
        """A kernel module, unpacked, under /modules."""
        with open(path, "rb") as file:
            content = file.read()
        name = os.path.basename(path)
        if name.endswith(".xz"):
            name, content = name[:-3], lzma.decompress(content)
        self.add(f"/modules/{name}", content)
        return name

    def program(self, source, path):
        """A program of the host with its libraries."""
        with open(source, "rb") as file:
            self.add(path, file.read(), 0o755)
        for library in libraries(source):
            with open(library, "rb") as file:
                self.add(library, file.read(), 0o755)

    def write(self, path):
        with gzip.open(path, "wb", compresslevel=1) as file:
            entries = [*sorted(self.entries.items()), ("TRAILER!!!", (0, b""))]
            for number, (name, (mode, content)) in enumerate(entries, 1):
                file.write(record(number, name, mode, content))


def record(number, name, mode, content):
    """One file of the archive."""
    packed = name.encode() + b"\0"
    fields = [number, mode, 0, 0, 1, 0, len(content), 0, 0, 0, 0, len(packed), 0]
    head = b"070701" + b"".join(b"%08X" % field for field in fields) + packed
    return head + bytes(-len(head) % 4) + content + bytes(-len(content) % 4)


def libraries(program):
    """What the loader would load, and the loader; nothing for a static program."""
    done = subprocess.run(["ldd", program], capture_output=True, text=True, check=False)
    words = done.stdout.split() if done.returncode == 0 else []
    return [word for word in words if word.startswith("/")]


def find(command):
    """A command of the host, with links followed."""
    found = shutil.which(command, path=os.environ["PATH"] + ":/usr/sbin:/sbin")
    if not found:
        raise RuntimeError(f"there is no {command} here")
    return os.path.realpath(found)

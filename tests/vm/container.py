"""A machine for what needs no kernel of its own: the same image, booted by systemd-nspawn at full speed. It has the real service manager,
packages and a network of its own; no display and no driver."""

import os
import pathlib
import shutil
import signal
import subprocess
import time
import unittest

BOOT_S = 60
HANG_S = 300
REBOOTED = 133  # systemd-nspawn's exit code


class Container:
    def __init__(self, image, folder):
        """`image`: what image/build printed; what is written on it is in memory, and gone with it. SkipTest: cannot run here."""
        if os.geteuid() != 0 or not shutil.which("systemd-nspawn"):
            raise unittest.SkipTest("needs root and systemd-nspawn (package systemd-container)")
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.root = self.folder / "root"
        self.mounted = []
        self.process = None
        try:
            self.mount(self.folder / "image", "-o", "ro,loop", f"{image}/disk.img")
            memory = self.mount(self.folder / "memory", "-t", "tmpfs", "tmpfs")
            for name in ("upper", "work"):
                (memory / name).mkdir()
            self.mount(self.root, "-t", "overlay", "overlay", "-o",
                       f"lowerdir={self.folder}/image,upperdir={memory}/upper,workdir={memory}/work")
            self.boot()
            self.wait_for_boot()
        except BaseException:
            self.stop()
            raise

    def boot(self):
        with open(self.folder / "console.log", "ab") as log:
            self.process = subprocess.Popen(
                ["systemd-nspawn", "--quiet", "--directory", self.root, "--register=no", "--keep-unit", "--private-network",
                 "--console=pipe", "--boot"], stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, start_new_session=True)

    def mount(self, place, *what):
        place.mkdir(parents=True, exist_ok=True)
        subprocess.run(["mount", *what, place], check=True)
        self.mounted.append(place)
        return place

    def first_process(self):
        """The container's service manager, as the host numbers it; None while there is none. Boots it again where it rebooted."""
        if self.process.poll() == REBOOTED:
            self.boot()
        if self.process.returncode is not None:
            return None
        children = pathlib.Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        return int(children[0]) if children else None

    def enter(self, command):
        first = self.first_process()
        if first is None:
            raise ConnectionError("the container is gone")
        return subprocess.run(["nsenter", "--target", str(first), "--mount", "--uts", "--ipc", "--net", "--pid", "--cgroup", "--",
                               "/bin/sh", "-c", command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}, timeout=HANG_S, check=False)

    def run(self, command, check=True):
        """Runs a shell command in it as root and returns its output, standard error included."""
        done = self.enter(command)
        output = done.stdout.decode(errors="replace").strip()
        if check and done.returncode != 0:
            raise AssertionError(f"in the container, exit code {done.returncode}: {command}\n{output}")
        return output

    def holds(self, command):
        """Whether a command in it succeeds."""
        return self.enter(command).returncode == 0

    def read(self, path):
        """A file of it, empty if absent."""
        done = self.enter(f"cat {path}")
        return done.stdout if done.returncode == 0 else b""

    def written(self):
        """All files that are not as in the image."""
        upper = self.folder / "memory/upper"
        return sorted(f"/{path.relative_to(upper)}" for path in upper.rglob("*") if path.is_symlink() or not path.is_dir())

    def clock(self):
        return time.monotonic()

    def pause(self, moment_s=0.2):
        time.sleep(moment_s)

    def wait_until(self, what, condition, timeout_s, every_s=0.2):
        """BLOCKS until `condition` (a shell command, or a function) holds; returns the seconds it took."""
        started = self.clock()
        while not (condition() if callable(condition) else self.holds(condition)):
            if self.clock() - started > timeout_s:
                raise AssertionError(f"not within {timeout_s} s: {what}")
            self.pause(every_s)
        return self.clock() - started

    def boot_id(self):
        """Of its own; empty while it boots."""
        try:
            return self.read("/proc/sys/kernel/random/boot_id")
        except (ConnectionError, OSError):
            return b""

    def wait_for_boot(self, after=b""):
        """BLOCKS until it takes commands, in another boot than `after`."""
        self.wait_until("it boots", lambda: self.boot_id() not in (b"", after) and self.is_up(), BOOT_S)

    def is_up(self):
        try:
            return self.holds("systemctl list-units >/dev/null")
        except (ConnectionError, OSError):
            return False

    def stop(self):
        if self.process:
            if first := self.first_process():
                os.kill(first, signal.SIGKILL)
            self.process.wait()
        for place in reversed(self.mounted):
            subprocess.run(["umount", "--lazy", place], check=False)
        self.mounted.clear()

"""What all tests of the virtual machine share: one machine that is live, to which every test returns, and its limits."""

import contextlib
import functools
import json
import os
import pathlib
import time
import unittest
from dataclasses import dataclass

import kiosk
import pictures
from kiosk import Kiosk


@dataclass
class Setup:
    image: str
    build: pathlib.Path
    folder: pathlib.Path


setup = None  # set by `run`
at_end = contextlib.ExitStack()  # what `run` stops
LEAST_PSNR_DB = 40.0
CONFIG, STATE = "/etc/kasumi/kasumi.toml", "/var/lib/kasumi"
BOOT_TO_LIVE_S = 60  # row 22, from the start of the kernel
EMULATED_FIRST_PICTURE_S = 8  # software GL prepares its shaders on one core of 1e9 instructions a second; added to what needs them
HELD_S = 2.0  # the longest an old picture is shown
REPORT_S = 1.5  # the status is written every second, and read a moment later


# Skipped unless all tests are requested.
long = unittest.skipUnless(os.environ.get("KASUMI_VM_ALL") == "1", "only by `./bootstrap vm all`")


@functools.cache
def disk():
    """Packages, fixtures, programs: made once for all tests."""
    return kiosk.make_disk(setup.build, setup.folder / "disk")


@functools.cache
def live_kiosk():
    """One machine for all tests: booted, with Kasumi installed and live on the fixture's frames for both cameras."""
    began = time.monotonic()
    machine = Kiosk(setup.image, disk(), setup.folder / "machine")
    at_end.callback(machine.stop)
    print(f"booted in {machine.boot_s:.1f} s ... ", end="", flush=True)
    machine.install()
    ready_s = machine.start_kasumi()
    print(f"READY in {ready_s:.1f} s ... ", end="", flush=True)
    live_s = ready_s + machine.wait_shown("live", timeout_s=60)  # its first pictures: software GL compiles its shaders
    print(f"live in {live_s:.1f} s of the machine's time; by the host's clock {time.monotonic() - began:.0f} s", flush=True)
    machine.wait_settled()
    machine.run("sync")
    machine.keep("live")
    return machine


class LiveKiosk(unittest.TestCase):
    """Every test starts from the same snapshot, with the kiosk live on the class's cameras."""

    @classmethod
    def setUpClass(cls):
        cls.kiosk = live_kiosk()
        cls.kiosk.return_to("live")
        if cls.prepare():
            cls.kiosk.start_kasumi()
            cls.kiosk.wait_shown("live", timeout_s=60)
            cls.kiosk.wait_settled()
            cls.warm_up()
            cls.kiosk.keep(cls.__name__)
            cls.moment = cls.__name__
        else:
            cls.moment = "live"

    @classmethod
    def prepare(cls):
        """Configures other cameras; returns whether it did."""
        return False

    @classmethod
    def warm_up(cls):
        """Has shown what its tests make the kiosk show."""

    def setUp(self):
        self.began = time.monotonic()
        self.kiosk.return_to(self.moment)
        self.kiosk.wait_shown("live")
        before = self.kiosk.status()
        self.first_picture_s = EMULATED_FIRST_PICTURE_S if self.kiosk.emulated else 0
        self.process_before, self.camera_before = str(before["pid"]), before["scene_camera"]

    def tearDown(self):
        name = self._testMethodName
        (self.kiosk.folder / f"{name}.journal").write_text(self.kiosk.journal())
        (self.kiosk.folder / f"{name}.json").write_text(json.dumps(self.kiosk.status(), indent=2))
        self.kiosk.photograph(f"{name}-after")
        print(f"the test took {time.monotonic() - self.began:.0f} s ... ", end="", flush=True)

    def recovered(self, seconds, limit_s):
        """Prints the recovery time and checks it against the row's limit, as the status tells it: up to REPORT_S late."""
        print(f"recovered in {seconds:.1f} s (allowed {limit_s} s) ... ", end="", flush=True)
        self.assertLessEqual(seconds, limit_s + REPORT_S)

    def assert_same_process(self):
        self.assertEqual(self.kiosk.unit("MainPID")["MainPID"], self.process_before, "the program was restarted")

    def assert_screen_as_computed(self, name, fixture="fixture", not_this=None):
        """The screen comes to match the picture rendered without a screen, pixel for pixel except for rounding, and differs from
        the screenshot `not_this`; returns the screenshot. The next picture may be seconds away on an emulated processor, and after
        a snapshot is loaded QEMU shows the whole buffer, of another size, until then."""
        references = sorted((setup.folder / f"disk/{fixture}-reference").glob("*.png"))
        best, deadline = 0.0, self.kiosk.clock() + 10
        while best < LEAST_PSNR_DB and self.kiosk.clock() < deadline:
            screen = self.kiosk.photograph(f"{self._testMethodName}-{name}")
            if not_this is None or screen.read_bytes() != not_this:
                best = max(best, pictures.psnr_db(screen, references))
            self.kiosk.pause()
        print(f"PSNR {best:.1f} dB ... ", end="", flush=True)
        self.assertGreaterEqual(best, LEAST_PSNR_DB, f"{screen}, against {references[0].parent}")
        return screen.read_bytes()

    def assert_lost(self, since):
        """A scene camera lost at the moment `since`, as a visitor sees it: held at most 2 s, then the still picture; never black."""
        darkest = []

        def is_still():
            darkest.append(pictures.brightness(self.kiosk.photograph(f"{self._testMethodName}-still")))
            return self.kiosk.status().get("shown") == "still"

        self.kiosk.wait_until("the still picture", is_still, since + HELD_S + REPORT_S - self.kiosk.clock())
        print(f"still after {self.kiosk.clock() - since:.1f} s ... ", end="", flush=True)
        self.assertGreater(min(darkest), 3.0)


class InContainer(unittest.TestCase):
    """What needs the service manager, but neither a kernel nor a screen: each test has a container of its own."""

    def setUp(self):
        began = time.monotonic()
        self.kiosk = kiosk.ContainerKiosk(setup.image, disk(), setup.folder / "container")
        self.addCleanup(self.kiosk.stop)
        self.addCleanup(self.keep_journal)
        self.kiosk.install_packages("kasumi")
        self.kiosk.run("systemctl enable --now kasumi")
        self.kiosk.wait_shown("live", timeout_s=60)
        self.process = str(self.kiosk.status()["pid"])
        print(f"live after {time.monotonic() - began:.0f} s ... ", end="", flush=True)

    def keep_journal(self):
        (self.kiosk.folder / f"{self._testMethodName}.journal").write_text(self.kiosk.run("journalctl --no-pager", check=False))

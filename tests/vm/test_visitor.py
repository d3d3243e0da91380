"""Visitors' buttons and a touch screen, made with the kernel's uinput; what they read on the glass is read by tesseract."""

import difflib
import pathlib
import subprocess
import tomllib
import unicodedata

import cv2

import kiosk
from live import CONFIG, LiveKiosk, long

LANGUAGES = pathlib.Path(__file__).parents[2] / "base/words/languages"
IDLE_S = 10
VISITOR = f"""
[visitor]
devices = ["/dev/input/by-id/kasumi-panel"]
then_and_now = ["KEY_1"]
language = ["KEY_2"]
hints = ["then_and_now", "language"]
languages = ["en", "ja"]
idle_s = {IDLE_S}
"""
ACCESS = "[Service]\nSupplementaryGroups=input\nDeviceAllow=char-input r\n"
EV_KEY, EV_ABS, KEY_1, KEY_2, BTN_TOUCH, ABS_X = 1, 3, 2, 3, 0x14a, 0
TESSERACT = {"en": "eng", "ja": "jpn"}
LIKE = {"en": 0.8, "ja": 0.7}  # share of the letters: on so small a screen tesseract mistakes one or the other
ENLARGED, LIGHT = 4, 140  # of 14 pixels it reads nothing; letters are lighter than that


def texts(language):
    return tomllib.loads((LANGUAGES / f"{language}.toml").read_text())


def letters(text):
    return "".join(c for c in unicodedata.normalize("NFKC", text).lower() if c.isalnum())


@long
class Visitor(LiveKiosk):
    """Two buttons below the screen, and a touch screen."""

    @classmethod
    def prepare(cls):
        cls.kiosk.run("mkdir -p /usr/share/fonts/kasumi-vm && cp /opt/kasumi-vm/fonts/* /usr/share/fonts/kasumi-vm/")
        cls.kiosk.run("modprobe uinput && mkfifo /run/panel"
                      " && systemd-run -q --unit=panel /opt/kasumi-vm/panel /run/panel")
        cls.kiosk.wait_until("the panel", lambda: "yes" in cls.kiosk.run(
            "udevadm settle; test -e /dev/input/by-id/kasumi-panel && echo yes", check=False), timeout_s=10)
        cls.kiosk.write("/etc/systemd/system/kasumi.service.d/input.conf", ACCESS)
        cls.kiosk.run("systemctl daemon-reload")
        cls.kiosk.write(CONFIG, kiosk.configuration(cls.kiosk.fixture) + VISITOR)
        return True

    def send(self, kind, code, value):
        self.kiosk.run(f"echo {kind} {code} {value} > /run/panel")

    def press(self, key):
        self.send(EV_KEY, key, 1)
        self.kiosk.pause()
        self.send(EV_KEY, key, 0)

    def read(self, language, part):
        """What is written in that part of the screen: from left, top, to right, bottom, as shares of its size."""
        screen = cv2.imread(str(self.kiosk.photograph(f"{self._testMethodName}-read")))
        height, width = screen.shape[:2]
        left, top, right, bottom = part
        cut = cv2.cvtColor(screen[int(top * height):int(bottom * height), int(left * width):int(right * width)], cv2.COLOR_BGR2GRAY)
        large = cv2.resize(cut, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_CUBIC)
        _, dark_on_light = cv2.threshold(large, LIGHT, 255, cv2.THRESH_BINARY_INV)
        file = self.kiosk.folder / f"{self._testMethodName}-{language}.png"
        cv2.imwrite(str(file), dark_on_light)
        return subprocess.run(["tesseract", file, "-", "-l", TESSERACT[language], "--psm", "6"], check=True, capture_output=True,
                              text=True, timeout=120).stdout

    def assert_reads(self, language, expected, part, limit_s=10):
        """The text is in that part of the screen, a moment after it was chosen."""
        found = [0.0, ""]

        def is_read():
            said = letters(self.read(language, part))
            match = difflib.SequenceMatcher(None, letters(expected), said, autojunk=False)
            share = sum(block.size for block in match.get_matching_blocks()) / len(letters(expected))
            found[:] = max([share, said], found)
            return share >= LIKE[language]

        seconds = self.kiosk.wait_until(f'"{expected}" on the glass', is_read, limit_s)
        print(f'"{expected}" read after {seconds:.1f} s, {found[0]:.0%} of its letters ... ', end="", flush=True)

    def test_presses_and_touches_are_read_on_the_glass(self):
        """Hints in English; in Japanese by a button; today, held; a wipe; and the first language again once nobody is there."""
        english, japanese = texts("en"), texts("ja")
        left, right, labels = (0.0, 0.78, 0.5, 1.0), (0.5, 0.84, 1.0, 1.0), (0.0, 0.55, 1.0, 0.86)
        self.assert_reads("en", english["hint"]["then_and_now"], left)
        self.assert_reads("ja", japanese["name"], right)
        self.press(KEY_2)
        self.assert_reads("ja", japanese["hint"]["then_and_now"], left)
        self.assert_reads("en", english["name"], right)
        self.send(EV_KEY, KEY_1, 1)
        self.assert_reads("ja", japanese["hand"]["now"], labels)
        self.send(EV_KEY, KEY_1, 0)
        self.press(KEY_2)
        self.send(EV_KEY, BTN_TOUCH, 1)
        self.send(EV_ABS, ABS_X, 600)
        self.assert_reads("en", english["hand"]["now"], (0.0, 0.55, 0.6, 0.86))
        self.send(EV_KEY, BTN_TOUCH, 0)
        self.press(KEY_2)
        self.assert_reads("ja", japanese["hint"]["then_and_now"], left)
        self.assert_reads("en", english["hint"]["then_and_now"], left, limit_s=IDLE_S + 10)
        self.assertEqual(self.kiosk.status()["visitor"]["presses"], 5)
        self.assert_same_process()

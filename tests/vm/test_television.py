"""The kiosk switches a television over HDMI-CEC: vivid's emulated bus, with v4l-utils' cec-follower as the television at its other end."""

import re

import kiosk
from live import CONFIG, LiveKiosk, long

TELEVISION = "vivid-000-vid-cap0"  # an HDMI input is a television's end of the cable
TRIES_S = 30  # it is told up to three times, ten seconds apart


@long
class Television(LiveKiosk):
    """The kiosk's HDMI output has a CEC adapter, and a television that sleeps."""

    @classmethod
    def prepare(cls):
        cls.kiosk.run("modprobe vivid node_types=0x101 num_inputs=1 input_types=0x3 num_outputs=1 output_types=0x1 && udevadm settle")
        cls.adapter = cls.kiosk.run("for cec in /dev/cec*; do if cec-ctl -d $cec | grep -q vivid-000-vid-out; then echo $cec; fi; done")
        cls.kiosk.run(f"cec-ctl -a {TELEVISION} --tv && systemd-run -q --unit=television cec-follower -a {TELEVISION} --standby -m -s")
        cls.kiosk.configure(display=f'cec = "{cls.adapter}"\n')
        return True

    @classmethod
    def warm_up(cls):
        cls.kiosk.wait_status("the television is awake", lambda status: status["television"]["power"] == "on")

    def power(self):
        """What the television says to whoever else asks."""
        said = self.kiosk.run(f"cec-ctl -d {self.adapter} --to 0 --give-device-power-status", check=False)
        found = re.search(r"pwr-state: ([\w-]+)", said)
        return found.group(1) if found else said

    def open_at(self, hours, wake_before_min):
        self.kiosk.write(CONFIG, kiosk.configuration(self.kiosk.fixture, display=f'cec = "{self.adapter}"\n')
                         + f'[opening]\nevery_day = "{hours}"\nwake_before_min = {wake_before_min}\n')
        self.kiosk.run("systemctl reload kasumi")

    def test_26_sleeps_while_closed_and_wakes_before_opening(self):
        """It was asleep, and was woken; it sleeps as soon as the kiosk is closed, and is awake before it opens."""
        self.assertIn(self.power(), ("on", "to-on"))
        television = self.kiosk.status()["television"]
        self.assertEqual((television["wanted"], television["answers"], television["problem"] or ""), ("on", True, ""))
        opens = int(self.kiosk.run("date +%H")) + 2
        self.open_at(f"{opens:02}:00-24:00", wake_before_min=0)
        self.kiosk.wait_shown("dark")
        asleep_s = self.kiosk.wait_until("the television sleeps", lambda: self.power() == "standby", TRIES_S)
        self.open_at(f"{opens:02}:00-24:00", wake_before_min=120)
        awake_s = self.kiosk.wait_until("the television is awake", lambda: self.power() in ("on", "to-on"), TRIES_S)
        print(f"asleep {asleep_s:.1f} s after it was dark, awake {awake_s:.1f} s after it was woken ... ", end="", flush=True)
        self.assertLess(int(self.kiosk.run("date +%H")), opens)
        self.assertNotRegex(self.kiosk.journal(), "television:.*the picture goes on without it")
        self.assert_same_process()

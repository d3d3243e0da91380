"""A kiosk's machine is updated, by RAUC: what proves itself stays, all else goes back by itself. One machine, in this order."""

import json
import shutil
import time
import unittest

import images
from slot_machine import SlotMachine

folder = None  # set by `run`
MIB = 1 << 20
SLOT_AT = {"A": (1 + images.ESP_MIB) * MIB, "B": (1 + images.ESP_MIB + images.SLOT_MIB) * MIB}
LIVE_S = 1200  # a machine that is not live by then is not slow, but dark


class Updates(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.images = folder / "images"
        shutil.rmtree(folder / "machine", ignore_errors=True)
        (folder / "machine").mkdir()
        disk = folder / "machine/disk.img"
        images.run("cp", "--sparse=always", "--reflink=auto", cls.images / "disk.img", disk)
        cls.kiosk = SlotMachine(cls.images, disk, folder / "machine")
        cls.addClassCleanup(cls.kiosk.kill)
        cls.kiosk.run("echo kept >/var/lib/kasumi/marker && cp /etc/machine-id /var/lib/kasumi/marker-id")

    @classmethod
    def wait_live(cls):
        """BLOCKS until visitors see a few pictures."""
        cls.kiosk.wait_until("live", lambda: (now := cls.status()).get("shown") in ("live", "degraded") and now["pictures"] > 5, LIVE_S, every_s=2)
        print(f"slot {cls.kiosk.slot()}, version {cls.kiosk.version()}, live {cls.kiosk.clock():.0f} s after its kernel started ... ",
              end="", flush=True)

    @classmethod
    def wait_started(cls):
        """BLOCKS until the kiosk has begun; returns whether it began in safe mode."""
        cls.kiosk.wait_until("a status", lambda: cls.status().get("start"), LIVE_S, every_s=2)
        return cls.status()["start"]["safe_mode"]

    @classmethod
    def status(cls):
        try:
            return json.loads(cls.kiosk.read("/run/kasumi/status.json"))
        except ValueError:
            return {}

    def setUp(self):
        self.began = time.monotonic()
        self.kiosk.run("mountpoint -q /mnt || mount -o ro /dev/vdb /mnt")

    def tearDown(self):
        name = self._testMethodName
        (self.kiosk.folder / f"{name}.journal").write_text(self.kiosk.run("journalctl -b --no-pager -o short-monotonic", check=False))
        print(f"{time.monotonic() - self.began:.0f} s by the host's clock ... ", end="", flush=True)

    def install(self, name, deadline_s=1800):
        self.wait_live()
        self.kiosk.run(f"printf 'PROBATION_S=10\\nDEADLINE_S={deadline_s}\\nASK_AGAIN_S=30\\n' >/etc/kasumi/updates.conf")
        started = self.kiosk.clock()
        self.kiosk.run(f"rauc install /mnt/{name}.raucb")
        print(f"{name} installed in {self.kiosk.clock() - started:.0f} s ... ", end="", flush=True)

    def slots(self):
        """Of each slot what RAUC says: booted or not, and its boot status."""
        said = json.loads(self.kiosk.run("rauc status --output-format=json 2>/dev/null"))
        return {slot["bootname"]: slot for entry in said["slots"] for slot in entry.values()}

    def went_back(self):
        """Why the last update went back; empty if it did not."""
        said = self.kiosk.read("/var/lib/rauc/went-back.json")
        return json.loads(said) if said else {}

    def begins_of(self, slot):
        """What lies at a slot's beginning and at the end of what the bundle `2` writes there, as the disk has it."""
        size = (self.images / "2.squashfs").stat().st_size
        with open(self.kiosk.disk, "rb") as disk:
            disk.seek(SLOT_AT[slot])
            first = disk.read(MIB)
            disk.seek(SLOT_AT[slot] + size - MIB)
            return first, disk.read(MIB)

    def assert_state_kept(self):
        self.assertEqual(self.kiosk.read("/var/lib/kasumi/marker"), b"kept\n")
        self.assertEqual(self.kiosk.read("/var/lib/kasumi/marker-id"), self.kiosk.read("/etc/machine-id"))
        self.assertGreater(int(self.kiosk.run("journalctl --list-boots | wc -l")), 1)

    def assert_went_back(self, slot, version, why):
        went_back = self.went_back()
        self.assertEqual((went_back["slot"], went_back["version"]), (slot, version))
        self.assertRegex(went_back["why"], why)
        self.assertRegex(self.kiosk.run("journalctl -o cat --no-pager -u kasumi-slot -u kasumi-slot-trial"), f"slot {slot} went back: .*{why}")
        self.assertEqual(self.slots()[slot]["boot_status"], "bad")
        self.assertFalse(self.wait_started())
        self.assert_state_kept()
        print(f"{went_back['why']} ... ", end="", flush=True)

    def test_1_runs_from_a_read_only_slot(self):
        self.assertEqual((self.kiosk.slot(), self.kiosk.version()), ("A", "1"))
        self.assertRegex(self.kiosk.run("findmnt -no FSTYPE,OPTIONS /"), r"^squashfs +ro\b")
        self.assertTrue(self.kiosk.holds("! touch /usr/x && ! touch /etc/x && ! touch /var/x"))
        self.assertEqual(len(self.kiosk.read("/etc/machine-id").strip()), 32)
        for place in ("/etc/kasumi", "/var/lib/kasumi", "/var/lib/rauc", "/var/log/journal"):
            self.assertTrue(self.kiosk.holds(f"touch {place}/x && rm {place}/x"), place)
        self.wait_started()
        self.assertEqual(self.kiosk.run("systemctl --failed --plain --no-legend"), "")
        self.assertEqual(self.slots()["A"]["state"], "booted")

    def test_2_bundles_of_others_are_refused(self):
        before = self.begins_of("B")
        for name, why in (("foreign", "signature verification failed|Verify error"), ("unsigned", "signature|Invalid bundle|Failed to")):
            said = self.kiosk.run(f"rauc install /mnt/{name}.raucb || echo refused", check=False)
            self.assertRegex(said, why)
            self.assertTrue(said.endswith("refused"), said)
        self.assertEqual(self.begins_of("B"), before)
        self.assertEqual(self.slots()["B"]["boot_status"], "bad")

    def test_3_a_power_cut_while_writing_leaves_the_old_slot(self):
        before = self.begins_of("B")
        self.wait_live()
        self.kiosk.agent.ask("guest-exec", path="/usr/bin/rauc", arg=["install", "/mnt/2.raucb"])
        began = time.monotonic()
        while (now := self.begins_of("B"))[0] == before[0]:
            self.assertLess(time.monotonic() - began, LIVE_S, "nothing is written")
            time.sleep(0.02)
        self.kiosk.kill()
        now = self.begins_of("B")
        self.assertNotEqual(now[0], before[0], "nothing was written yet")
        self.assertEqual(now[1], before[1], "all was written already")
        self.kiosk.power_on()
        self.assertEqual(self.kiosk.starts()[-1], ("A", 1, False))
        self.assert_went_back("B", "2", "its installation was not finished")

    def test_4_a_good_update_stays(self):
        self.install("2")
        self.assertEqual(self.kiosk.reboot(), [("B", 1, True)])
        said = self.kiosk.run("mount -o ro /dev/vdb /mnt; rauc install /mnt/2.raucb || echo refused", check=False)
        self.assertTrue(said.endswith("refused"), said)
        self.assertRegex(self.kiosk.run("journalctl -b -u rauc -o cat --no-pager"), "this slot is itself on trial")
        self.kiosk.wait_until("the verdict", "journalctl -b -u kasumi-slot-trial | grep -q 'has proven itself'", LIVE_S)
        self.assertEqual(self.slots()["B"]["boot_status"], "good")
        self.assertEqual((self.kiosk.slot(), self.kiosk.version(), self.went_back()), ("B", "2", {}))
        self.assertEqual(self.kiosk.reboot(), [("B", 1, False)])
        self.assertEqual(self.kiosk.version(), "2")
        self.assert_state_kept()

    def test_5_what_does_not_boot_falls_back(self):
        self.install("dead")
        self.assertEqual(self.kiosk.reboot(starts=4), [("A", 1, True), ("A", 2, True), ("A", 3, True), ("B", 1, False)])
        self.assert_went_back("A", "dead", "did not come up in three starts")

    def test_6_what_shows_no_picture_falls_back(self):
        self.install("dark", deadline_s=100)
        self.assertEqual(self.kiosk.reboot(starts=2), [("A", 1, True), ("B", 1, False)])
        self.assert_went_back("A", "dark", "no pictures for 10 s within 100 s")

    def test_7_what_makes_the_doctor_complain_falls_back(self):
        self.install("ill")
        self.assertEqual(self.kiosk.reboot(starts=2), [("A", 1, True), ("B", 1, False)])
        self.assert_went_back("A", "ill", "kasumi doctor: disk.write")

    def test_8_a_damaged_environment_of_the_boot_loader(self):
        """Starts what last proved itself, though the order it comes with is the other."""
        self.kiosk.run(": >/boot/efi/grub/grubenv; sync")
        before = len(self.kiosk.starts())
        self.kiosk.cut_power()
        self.kiosk.wait_for_starts(before + 1)
        self.assertEqual(self.kiosk.starts()[-1][0], "B")
        self.wait_started()
        self.assertEqual((self.slots()["B"]["boot_status"], self.kiosk.version()), ("good", "2"))

    def test_9_a_changed_bundle_is_not_installed(self):
        """Its signature is good, its content is not: what is read is compared block by block."""
        said = self.kiosk.run("rauc install /mnt/changed.raucb || echo refused", check=False)
        self.assertTrue(said.endswith("refused"), said)
        self.assertEqual(self.kiosk.reboot(), [("B", 1, False)])
        self.assert_went_back("A", "dead", "its installation was not finished")

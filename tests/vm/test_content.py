"""Content that comes by itself, by the shipped units on a machine with systemd and udev: on a USB stick, in a folder, from the
reporter. The appliance's place is taken by a stand-in, which answers when it is asked to reload: what a kiosk shows of it is tested
without a machine (test_probation, test_content)."""

import json
import pathlib
import shutil
import subprocess
import time
import unittest

import kiosk
import live
from live import long
from machine import Machine

SOURCE = pathlib.Path(__file__).resolve().parents[2]
SLOW_BYTES_S = 60_000  # of a stick that is pulled out half-way
COMES_S = 30  # a bundle is read, checked twice and unpacked on one emulated core
STANDIN = """\
#!/bin/sh
tell() { printf '{"pid": %d, "content": {"reload_began_s": %s, "problems": []}}' $$ $1 >/run/kasumi/new; mv /run/kasumi/new /run/kasumi/status.json; }
trap 'read up rest </proc/uptime; tell $((${up%.*} + 1))' HUP
tell 0
while :; do sleep .2; done
"""


def run(*command):
    subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL, timeout=300)


class Desk:
    """A curator's: bundles signed for this kiosk, and sticks with them."""

    def __init__(self, folder, build):
        self.folder, self.build = folder, build
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        demo = SOURCE / "fixtures/demo"
        for name in ("pagoda.glb", "sky-mask.png", "scene-mask.png"):
            shutil.copy(demo / name, folder)
        self.configuration = kiosk.configuration(demo)
        run("minisign", "-G", "-W", "-f", "-p", folder / "curator.pub", "-s", folder / "curator.key")

    def pack(self, name, signed=True):
        (self.folder / "kasumi.toml").write_text(f"# {name}\n" + self.configuration)
        out = self.folder / f"{name}.kasumi"
        run(self.build / "kasumi", "content", "pack", self.folder / "kasumi.toml", "--out", out, "--name", name,
            *(("--key", self.folder / "curator.key") if signed else ()))
        time.sleep(1)  # the next is newer
        return out

    def stick(self, name, *files, label="KASUMI"):
        """An image of a stick: FAT, with these files."""
        image = self.folder / f"{name}.img"
        run("mformat", "-i", image, "-C", "-T", "131072", "-v", label, "::")
        for file in files:
            run("mcopy", "-i", image, file, "::")
        with image.open("r+b") as whole:  # mformat makes up a table of partitions, of which the stick would be one, too
            whole.seek(0x1BE)
            whole.write(bytes(64))
        return image


@long
class Content(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        setup = live.setup
        folder = setup.folder / "content"
        cls.desk = Desk(folder, setup.build)
        spring, summer, winter = (cls.desk.pack(name) for name in ("Spring", "Summer", "Winter"))
        cls.sticks = {"good": cls.desk.stick("good", winter), "plain": cls.desk.stick("plain", cls.desk.pack("Plain", signed=False)),
                      "other": cls.desk.stick("other", winter, label="HOLIDAYS")}
        inside = folder / "disk"
        inside.mkdir()
        run("cpack", "--config", setup.build / "CPackConfig.cmake", "-D", "CPACK_COMPONENTS_ALL=kasumi", "-B", folder / "package")
        shutil.copy(next((folder / "package").glob("kasumi_*.deb")), inside / "kasumi.deb")
        for file in (spring, summer, cls.desk.folder / "curator.pub", SOURCE / "systemd/kasumi-fetched.path"):
            shutil.copy(file, inside)
        (inside / "kasumi").write_text(STANDIN)
        run("mke2fs", "-q", "-t", "ext4", "-d", inside, folder / "disk.img", "100M")
        cls.machine = Machine(setup.image, setup.folder / "content-machine", (384, 216), extra_disk=folder / "disk.img")
        cls.addClassCleanup(cls.machine.stop)
        cls.machine.run("mount -o ro /dev/vdb /mnt && dpkg -i /mnt/kasumi.deb && install -m 755 /mnt/kasumi /tmp/kasumi"
                        " && install -D -m 644 -t /etc/kasumi/keys /mnt/curator.pub && udevadm control --reload && systemctl daemon-reload")
        # As the appliance's unit: the sandbox of a stick's unit must find it, and may ask it.
        cls.machine.run("systemd-run --unit=standin -p User=kasumi -p RuntimeDirectory=kasumi -p PrivateUsers=yes"
                        " -p ProtectProc=invisible -p PrivateTmp=no /tmp/kasumi")
        cls.machine.wait_until("the stand-in", "test -e /run/kasumi/status.json", COMES_S)
        cls.machine.run("sync")
        cls.machine.keep("ready")

    def setUp(self):
        self.machine.return_to("ready")

    def tearDown(self):
        self.unplug()  # the snapshot knows no stick
        journal = self.machine.run("journalctl -b --no-pager -u 'kasumi-*'; ls -la /var/lib/kasumi /var/lib/kasumi/content", check=False)
        (self.machine.folder / f"{self._testMethodName}.journal").write_text(journal)

    def plug(self, image, bytes_s=None):
        ask = self.machine.qmp.ask
        file = {"driver": "file", "filename": str(image), "read-only": True}
        ask("blockdev-add", **{"driver": "raw", "node-name": "stick", "read-only": True, "file": file})
        if bytes_s:
            ask("object-add", **{"qom-type": "throttle-group", "id": "pace", "limits": {"bps-total": bytes_s}})
            ask("blockdev-add", **{"driver": "throttle", "node-name": "slow", "throttle-group": "pace", "file": "stick", "read-only": True})
        ask("device_add", driver="usb-storage", id="stick", bus="usb.0", drive="slow" if bytes_s else "stick", removable=True)

    def unplug(self):
        for command, arguments in (("device_del", {"id": "stick"}), ("blockdev-del", {"node-name": "slow"}),
                                   ("object-del", {"id": "pace"}), ("blockdev-del", {"node-name": "stick"})):
            for _ in range(100):
                try:
                    self.machine.qmp.ask(command, **arguments)
                    break
                except RuntimeError as error:
                    if "use" not in str(error) and "busy" not in str(error):
                        break  # there is none
                    self.machine.pause()

    def arrived(self):
        """What came of the last, as the appliance tells it in its status."""
        try:
            return json.loads(self.machine.read("/var/lib/kasumi/content/arrived.json"))
        except ValueError:
            return {"words": "", "taken": False}

    def wait_words(self, part):
        took = self.machine.wait_until(f"it is told: {part}", lambda: part in self.arrived()["words"], COMES_S)
        print(f"told after {took:.1f} s ... ", end="", flush=True)

    def wait_released(self):
        self.machine.wait_until("the stick is let go of", "! grep -q kasumi-stick /proc/mounts && ! ls -d /run/kasumi-stick/*", COMES_S)
        self.machine.wait_until("its unit has ended", "! systemctl is-active 'kasumi-stick@*' | grep -v -e inactive -e failed", COMES_S)

    def shown(self):
        return self.machine.run("kasumi content list", check=False)

    def assert_on_probation(self, name):
        self.assertRegex(self.shown(), rf"(?m)^\* [0-9a-f]{{16}} .* by curator  {name}: on probation$")

    def test_row_22_a_stick_is_read_and_let_go_of(self):
        self.plug(self.sticks["good"])
        self.wait_words("signed by curator: installed")
        self.wait_released()
        self.machine.wait_until("the running appliance was asked", lambda: self.arrived()["taken"], COMES_S)
        self.assert_on_probation("Winter")
        self.assertIn("shown now, on probation", self.machine.run("journalctl -b --no-pager -u 'kasumi-stick@*'"))
        self.unplug()
        self.plug(self.sticks["good"])
        self.machine.wait_until("it is known already", "journalctl -b --no-pager -u 'kasumi-stick@*' | grep -q 'it is shown already'", COMES_S)
        self.wait_released()

    def test_row_22_what_nobody_signed_changes_nothing(self):
        self.plug(self.sticks["plain"])
        self.wait_words("it is not signed")
        self.wait_released()
        self.assertIn("* /etc/kasumi/kasumi.toml: set up by hand", self.shown())
        self.assertEqual(self.machine.run("ls /var/lib/kasumi/content"), "arrived.json", "nothing is unpacked")

    def test_row_22_a_stick_pulled_out_half_way(self):
        self.plug(self.sticks["good"], SLOW_BYTES_S)
        self.wait_words("is being read")
        self.unplug()
        self.wait_released()
        self.assertNotIn("installed", self.arrived()["words"])
        self.assertFalse(self.arrived()["taken"])
        self.assertIn("* /etc/kasumi/kasumi.toml: set up by hand", self.shown())
        self.plug(self.sticks["good"])  # put in again, it is taken
        self.wait_words("signed by curator: installed")
        self.wait_released()
        self.assert_on_probation("Winter")

    def test_row_22_another_stick_is_not_looked_at(self):
        self.plug(self.sticks["other"])
        self.machine.wait_until("the kernel has it", "ls /dev/disk/by-label/HOLIDAYS", COMES_S)
        self.machine.run("udevadm settle")
        self.assertEqual(self.machine.run("systemctl list-units --all --no-legend 'kasumi-stick@*'"), "")
        self.assertEqual(self.arrived()["words"], "")

    def test_row_22_a_folder_and_what_the_reporter_fetched(self):
        # As the reporter's account keeps it: nobody else may look into its folder, which is not there yet.
        self.machine.run("cp /mnt/kasumi-fetched.path /etc/systemd/system && systemctl daemon-reload && systemctl start kasumi-fetched.path")
        self.machine.run("cp /mnt/Spring.kasumi /tmp && install -d -m 700 /var/lib/private /var/lib/private/kasumi-report"
                         " && install -d /var/lib/private/kasumi-report/content"
                         " && mv /tmp/Spring.kasumi /var/lib/private/kasumi-report/content/fetched.kasumi")
        self.wait_words("Spring (")
        self.wait_words("signed by curator: installed")
        self.machine.run("systemctl enable --now kasumi-content.path")
        self.machine.run("cp /mnt/Summer.kasumi /var/lib/kasumi/incoming/.new"
                         " && mv /var/lib/kasumi/incoming/.new /var/lib/kasumi/incoming/Summer.kasumi")
        self.wait_words("Summer (")
        self.wait_words("signed by curator: installed")
        self.machine.wait_until("the running appliance was asked", lambda: self.arrived()["taken"], COMES_S)
        self.assert_on_probation("Summer")

"""The appliance in its virtual machine: installed from its package, fed by fixture frames or by the kernel's test drivers."""

import json
import os
import pathlib
import re
import shutil
import subprocess

from container import Container
from machine import Machine

FIXTURE_STARTS_UTC = "2026-10-20T00:50:00"  # the preset "fine-morning"
# Of scene and screen: small, because software GL draws them on an emulated processor, but one that QEMU can describe (its EDID has
# no vertical sync below 200 lines) and vimc can deliver (multiples of 6 only).
SIZE = 384, 216
SCENE_LOOPBACK = 'source = "v4l2"\ndevice = "/dev/v4l/by-id/kasumi-scene"\n'
SKY_LOOPBACK = 'source = "v4l2"\ndevice = "/dev/v4l/by-id/kasumi-sky"\n'
VIMC = 'source = "libcamera"\ncamera = "platform/vimc.0 Sensor B"\n'
VIVID = 'source = "v4l2"\ndevice = "/dev/v4l/by-id/vivid-000"\nformat = "YUYV"\nframes_per_second = 5\n'
# Camera and display of the same size, in a format that both know: among the few that vivid has, and the modes of vkms.
PLANES_SIZE = 640, 480
VIVID_FOR_PLANES = 'source = "v4l2"\ndevice = "/dev/v4l/by-id/vivid-000"\nformat = "XR24"\nframes_per_second = 25\n'
VKMS = 'device = "/dev/dri/by-path/platform-vkms-card"\nmode = "640x480"\n'

# Kernel test drivers have no serial number and no unique bus path, so their stable names come from their card names.
UDEV_RULES = """\
SUBSYSTEM=="video4linux", ATTR{name}=="kasumi-scene", SYMLINK+="v4l/by-id/kasumi-scene"
SUBSYSTEM=="video4linux", ATTR{name}=="kasumi-sky", SYMLINK+="v4l/by-id/kasumi-sky"
SUBSYSTEM=="video4linux", ATTR{name}=="vivid-000-vid-cap", SYMLINK+="v4l/by-id/vivid-000"
SUBSYSTEM=="input", KERNEL=="event*", ATTRS{name}=="Kasumi panel", SYMLINK+="input/by-id/kasumi-panel"
"""
DRIVERS = """\
options v4l2loopback devices=2 exclusive_caps=1,1 card_label=kasumi-scene,kasumi-sky
options vivid n_devs=1 node_types=0x1 input_types=0x0
options vkms enable_overlay=1
"""
EVERYTHING = os.environ.get("KASUMI_VM_ALL") == "1"
FONTS = ("/usr/share/fonts/truetype/vlgothic/VL-Gothic-Regular.ttf",)  # this machine's, for Japanese
PACKAGES = ("kasumi", "kasumi-kiosk", "kasumi-report")
NEXT_VERSION = "99.0"
DEVICE_TESTS = ("test_v4l2_live", "test_libcamera_live", "test_kms", "test_gles")
STATISTICS = """\
[Service]
ExecStart=
ExecStart=/usr/bin/kasumi run --config /etc/kasumi/kasumi.toml --stats
"""
# A program that crashes as it starts, but not in safe mode: once it has noted this start, which wait-before-start begins.
CRASH = """\
[Service]
ExecStart=/bin/sh -c 'while sleep .3; do test /var/lib/kasumi/starts.json -nt /run/kasumi/starts && \\
  grep -q mode.*whole /var/lib/kasumi/starts.json && systemctl kill -s KILL --kill-whom=main kasumi; done'
[Install]
WantedBy=multi-user.target
"""
FEEDER = """\
[Service]
ExecStart=/opt/kasumi-vm/feed_loopback /opt/kasumi-vm/fixture/%i /dev/v4l/by-id/kasumi-%i
Restart=always
RestartSec=1
[Unit]
StartLimitIntervalSec=0
[Install]
WantedBy=multi-user.target
"""


def configuration(fixture, scene=SCENE_LOOPBACK, sky=SKY_LOOPBACK, clock="trusted", scene_size=SIZE, display=""):
    """A fixture's cameras and building as kasumi.toml, with live cameras instead of recorded ones."""
    described = (fixture / "fixture.toml").read_text()
    if scene_size != SIZE:
        size = "width = {}\nheight = {}\n"
        described = described.replace(size.format(*SIZE), size.format(*scene_size)).replace('mask = "scene-mask.png"\n', "")
    return (described[described.index("[site]"):]
            + f"\n[sky.camera]\n{sky}\n[scene.camera]\n{scene}\n"
            + f"\n[display]\n{display}"
            + f'[clock]\npolicy = "{clock}"\n[state]\nfolder = "/var/lib/kasumi"\n'
            + '[still]\ncaption = "The view returns in a moment."\n')


def make_disk(build, folder):
    """Makes the disk with Kasumi's package, the fixtures, their feeder and the device tests, and renders the fixtures without
    a screen into folder/NAME-reference."""
    shutil.rmtree(folder, ignore_errors=True)
    content = folder / "content"
    ours = content / "opt/kasumi-vm"
    fixture = ours / "fixture"
    ours.mkdir(parents=True)

    def run(*command):
        subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL, timeout=300)

    for name, encoding, frames in (("fixture", "MJPG", 10), ("fixture-yuyv", "YUYV", 2)):
        run(build / "kasumi-generate-fixture", "fine-morning", "--scene-size", "{}x{}".format(*SIZE), "--sky-size", "320", "--frames", frames,
            "--period", "0.5", "--truth-frames", "0", "--scene-format", encoding, "--out", ours / name)
        run(build / "kasumi", "replay", ours / name, "--out", folder / f"{name}-reference")
    index = fixture / "sky/index.csv"  # every second picture: estimates are half the work of an emulated processor
    lines = index.read_text().splitlines(keepends=True)
    index.write_text("".join(lines[:1] + lines[1::2]))
    versions = {"packages": (), "packages/next": ("-D", f"CPACK_PACKAGE_VERSION={NEXT_VERSION}")}
    for place in versions if EVERYTHING else ("packages",):
        run("cpack", "--config", build / "CPackConfig.cmake", "-B", folder / place, *versions[place])
        (content / place).mkdir(parents=True)
        for name in PACKAGES:
            shutil.copy(next((folder / place).glob(f"{name}_*.deb")), content / place / f"{name}.deb")
    for script in ("hostile-peers", "panel"):
        shutil.copy(pathlib.Path(__file__).with_name(script), ours)
    (ours / "fonts").mkdir()
    for font in FONTS if EVERYTHING else ():
        shutil.copy(font, ours / "fonts")
    for program in ("feed_loopback", *(DEVICE_TESTS if EVERYTHING else ())):
        run("strip", "-o", ours / program, build / program)
    kasumi = content / "etc/kasumi"
    kasumi.mkdir(parents=True)
    for name in ("temple.glb", "sky-mask.png", "scene-mask.png"):
        shutil.copy(fixture / name, kasumi)
    for path, text in {"etc/udev/rules.d/72-kasumi-vm.rules": UDEV_RULES, "etc/modprobe.d/kasumi-vm.conf": DRIVERS,
                       "etc/modules-load.d/kasumi-vm.conf": "v4l2loopback\n",
                       "etc/systemd/system/feed@.service": FEEDER,
                       "etc/systemd/system/kasumi.service.d/statistics.conf": STATISTICS}.items():
        (content / path).parent.mkdir(parents=True, exist_ok=True)
        (content / path).write_text(text)
    run("mke2fs", "-q", "-t", "ext4", "-d", content, folder / "kasumi.img", "400M")
    return folder / "kasumi.img"


class Appliance:
    """Kasumi on a machine that runs commands."""

    def start_kasumi(self):
        """BLOCKS until systemd has received READY. Returns the seconds it took by the guest's clock."""
        started = self.clock()
        self.run("systemctl restart kasumi || { journalctl -u kasumi -b --no-pager | tail -n 40; false; }")
        return self.clock() - started

    def write(self, path, text):
        self.run(f"mkdir -p $(dirname {path}) && cat > {path} <<'END'\n{text}\nEND")

    def status(self):
        """Kasumi's own status; empty while there is none."""
        try:
            return json.loads(self.read("/run/kasumi/status.json"))
        except ValueError:
            return {}

    def wait_shown(self, *shown, timeout_s=30):
        """BLOCKS until the visitor sees one of `shown`; returns the seconds it took."""
        return self.wait_until(f"shown: {' or '.join(shown)}", lambda: self.status().get("shown") in shown, timeout_s)

    def wait_status(self, what, condition, timeout_s=30):
        return self.wait_until(what, lambda: bool((status := self.status()) and condition(status)), timeout_s)

    def wait_new_picture(self, timeout_s=30):
        """BLOCKS until a new frame of the scene camera has arrived."""
        before = self.status().get("scene_camera", {}).get("good_frames", 0)
        self.wait_status("a new picture", lambda status: status["scene_camera"]["good_frames"] > before, timeout_s)

    def wait_settled(self):
        """BLOCKS until all that is drawn has been drawn a few times: software GL compiles its shaders at the first."""
        self.wait_status("the building", lambda status: status["turbidity"] and status["building_drawn"])
        pictures = self.status()["pictures"]
        self.wait_status("a few pictures", lambda status: status["pictures"] >= pictures + 5)

    def unit(self, *properties, of="kasumi"):
        """Properties of a service as systemd reports them."""
        lines = self.run(f"systemctl show {of} " + " ".join(f"-p {name}" for name in properties)).splitlines()
        return dict(line.split("=", 1) for line in lines)

    def journal(self):
        return self.run("journalctl -u kasumi -b --no-pager -o short-monotonic", check=False)

    def exposure_of_security(self, of="kasumi"):
        """A service's exposure according to `systemd-analyze security`, 0 (closed) to 10."""
        return float(re.search(f"exposure level for {of}.service: ([0-9.]+)", self.run(
            f"systemd-analyze security --no-pager {of}.service", check=False)).group(1))


class Kiosk(Appliance, Machine):
    def __init__(self, image, disk, folder, **options):
        super().__init__(image, folder, extra_disk=disk, size=SIZE, utc=FIXTURE_STARTS_UTC, **options)
        self.fixture = disk.parent / "content/opt/kasumi-vm/fixture"

    def install(self):
        self.run("mount -o ro /dev/vdb /mnt && dpkg -i /mnt/packages/kasumi.deb")
        self.run("cp -a /mnt/opt /mnt/etc / && chown -R root:root /opt /etc/kasumi && umount /mnt"
                 " && udevadm control --reload && systemctl daemon-reload && modprobe v4l2loopback && udevadm settle")
        self.run("systemctl enable --now feed@sky feed@scene")
        self.configure()
        self.run("systemctl daemon-reload && systemctl enable kasumi")

    def configure(self, **choices):
        self.write("/etc/kasumi/kasumi.toml", configuration(self.fixture, **choices))


class ContainerKiosk(Appliance, Container):
    """Without cameras and screen: both are played from a recording, and nobody sees the picture."""

    def __init__(self, image, disk, folder):
        super().__init__(image, folder)
        content = disk.parent / "content"
        for name in ("packages", "opt", "etc/kasumi"):
            shutil.copytree(content / name, self.root / name, dirs_exist_ok=True)
        described = (content / "opt/kasumi-vm/fixture/fixture.toml").read_text()
        replay = 'source = "replay"\nfixture = "/opt/kasumi-vm/fixture"\n'
        self.write("/etc/kasumi/kasumi.toml", described[described.index("[site]"):]
                   + f"\n[sky.camera]\n{replay}[scene.camera]\n{replay}"
                   + '[display]\nkind = "headless"\nwidth = {}\nheight = {}\n'.format(*SIZE)
                   + '[clock]\npolicy = "trusted"\n[state]\nfolder = "/var/lib/kasumi"\n')

    def install_packages(self, *names, place="packages"):
        """As dpkg does when nobody answers its questions; returns what it said."""
        return self.run("DEBIAN_FRONTEND=noninteractive dpkg -i " + " ".join(f"/{place}/{name}.deb" for name in names))

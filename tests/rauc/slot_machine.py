"""A kiosk with two slots in QEMU, started by its own boot loader from its own disk."""

import pathlib
import re
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "vm"))
import machine  # noqa: E402

FIRMWARE = "/usr/share/ovmf/OVMF.fd"
# By the host's clock: the firmware does not start where the guest's counts instructions, as in tests/vm. Without AVX, software GL compiles
# its shaders in half the time.
EMULATION = ("-accel", "tcg,thread=multi,tb-size=512", "-cpu", "max,avx=off,avx2=off,fma=off,f16c=off", "-smp", "2")
START_S = 1800  # a machine that has not started within this time by the host's clock hangs


class SlotMachine(machine.Machine):
    """`disk` and `bundles` are raw images; what is written to `disk` stays there when the machine is killed."""

    def __init__(self, images, disk, folder):
        self.folder = folder
        self.folder.mkdir(parents=True, exist_ok=True)
        self.disk, self.bundles, self.images = disk, images / "bundles.img", images
        self.console = self.folder / "console.log"
        self.power_on()

    def power_on(self):
        """BLOCKS until the guest answers."""
        accelerator = machine.accelerator(str(self.images))
        arguments = [
            "qemu-system-x86_64", *(EMULATION if accelerator == machine.EMULATION else accelerator), "-machine", "q35", "-m", "1536", "-nodefaults", "-no-user-config",
            "-bios", FIRMWARE, "-vga", "none", "-display", "none",
            "-drive", f"file={self.disk},if=virtio,format=raw", "-drive", f"file={self.bundles},if=virtio,format=raw,readonly=on",
            "-chardev", f"file,id=console,path={self.console},append=on", "-serial", "chardev:console",
            "-device", "virtio-serial", "-device", "virtserialport,chardev=agent,name=org.qemu.guest_agent.0",
            "-chardev", f"socket,id=agent,path={self.socket_of('agent')},server=on,wait=off",
            "-qmp", f"unix:{self.socket_of('qmp')},server=on,wait=off", "-nic", "none", "-rtc", "base=utc,clock=vm",
        ]
        before = len(self.starts())
        with open(self.folder / "qemu.log", "ab") as log:
            self.process = subprocess.Popen(arguments, stdout=log, stderr=subprocess.STDOUT)
        self.qmp = self.agent = None
        self.pace = 1.0
        try:
            self.qmp = self.connect("qmp")
            self.qmp.read()
            self.qmp.ask("qmp_capabilities")
            self.agent = self.connect("agent")
            self.wait_for_starts(before + 1)
        except BaseException:
            self.kill()
            raise

    def starts(self):
        """What the boot loader has said of each start, over all reboots: ("B", 1, True) is slot B's first, on trial."""
        said = self.console.read_bytes().decode(errors="replace") if self.console.exists() else ""
        return [(slot, int(start), bool(trial)) for slot, start, trial in re.findall(r"Kasumi: slot ([AB]), start (\d)( kasumi\.trial)?", said)]

    def wait_for_starts(self, count):
        """BLOCKS until the machine has been started so often, and the last of these answers."""
        began = time.monotonic()
        while len(self.starts()) < count:
            if self.process.poll() is not None:
                raise ConnectionError("qemu has ended, see " + str(self.folder / "qemu.log"))
            if time.monotonic() - began > START_S:
                raise TimeoutError(f"{len(self.starts())} starts, not {count}, see {self.console}")
            time.sleep(0.5)
        self.wait_for_agent()
        self.run("systemctl start kasumi-slot", check=False)  # BLOCKS until it has said what came of the last update

    def reboot(self, starts=1):
        """BLOCKS until the machine has started so often again, and answers; returns what the boot loader said of each start."""
        before = len(self.starts())
        self.agent.ask("guest-exec", path="/bin/systemctl", arg=["reboot"])
        self.wait_for_starts(before + starts)
        return self.starts()[before:]

    def slot(self):
        return re.search(r"rauc\.slot=([AB])", self.read("/proc/cmdline").decode()).group(1)

    def version(self):
        return re.search(r"IMAGE_VERSION=(\S+)", self.read("/usr/lib/os-release").decode()).group(1)

    def kill(self):
        """The plug is pulled: what the guest has not written to its disk is lost."""
        self.stop()

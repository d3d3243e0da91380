"""One virtual machine: boots the image, runs commands, takes screenshots, connects and disconnects devices, cuts the power."""

import base64
import calendar
import functools
import itertools
import json
import os
import pathlib
import shutil
import socket
import struct
import subprocess
import time


ANSWER_S = 300  # longest time for an answer from QEMU or the guest's agent, by the host's clock
HANG_S = 900  # a command that lasts longer by the host's clock hangs; limits are by the guest's clock
FIRMWARE_S = 2  # within this time after a reset the firmware resets the machine once more, as it finds that it ran before
SLOWEST = 60  # times slower than its own clock: such a machine is useless
POLL_S = 0.2  # of the guest's time, since looking costs an emulated processor some of it
# An emulated processor executes 1e9 instructions a second of the guest's time, however long that takes: its clock counts them. One
# core only: the count belongs to one thread. Without AVX, software GL compiles its shaders in half the time.
EMULATION = ("-accel", "tcg,thread=single,tb-size=512", "-cpu", "max,avx=off,avx2=off,fma=off,f16c=off", "-smp", "1",
             "-icount", "shift=0,sleep=on")


class JsonSocket:
    """QEMU's monitor (QMP) and the guest's agent (QGA) both speak one JSON object a line."""

    def __init__(self, path, timeout_s):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(timeout_s)
        try:
            self.socket.connect(str(path))
        except OSError:
            self.socket.close()
            raise
        self.received = b""
        self.news = []

    def read(self):
        while True:
            while b"\n" not in self.received:
                part = self.socket.recv(1 << 16)
                if not part:
                    raise ConnectionError("the machine is gone")
                self.received += part
            line, self.received = self.received.split(b"\n", 1)
            try:
                return json.loads(line)
            except ValueError:
                continue  # remainder of an answer from before a reset

    def send(self, command, **arguments):
        self.socket.sendall(json.dumps({"execute": command, "arguments": arguments}).encode() + b"\n")

    def ask(self, command, **arguments):
        self.send(command, **arguments)
        while True:
            answer = self.read()
            if "error" in answer:
                raise RuntimeError(f"{command}: {answer['error'].get('desc', answer['error'])}")
            if "return" in answer:
                return answer["return"]
            if "event" in answer:
                self.news.append(answer)

    def events(self):
        """What QEMU has told since it was last asked for events; they come with the answers to commands."""
        news, self.news = self.news, []
        return news


class Monitor:
    """Controls the machine's display through QEMU's VNC server (RFC 6143): a viewer that requests a desktop size."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(ANSWER_S)
        self.socket.connect(str(path))
        self.socket.recv(12)
        self.socket.sendall(b"RFB 003.008\n")
        self.socket.recv(256)  # security types
        self.socket.sendall(b"\x01")  # none
        self.socket.recv(4)
        self.socket.sendall(b"\x01")  # shared
        self.socket.recv(1024)  # the desktop's size, format and name
        self.socket.sendall(struct.pack(">BxHi", 2, 1, -308))  # SetEncodings: ExtendedDesktopSize

    def plug(self, width, height):
        self.socket.sendall(struct.pack(">BxHHBx", 251, width, height, 1) + struct.pack(">IHHHHI", 0, 0, 0, width, height, 0))

    def unplug(self):
        self.plug(0, 0)

    def leave(self, width, height):
        """Leaves a display of this size plugged in, for the tests to come: no snapshot tells QEMU which it was. BLOCKS until it is."""
        self.plug(width, height)
        self.socket.shutdown(socket.SHUT_WR)
        while self.socket.recv(4096):  # QEMU hangs up once it has done all that it was asked
            pass
        self.socket.close()


@functools.cache
def accelerator(image):
    """KVM where it runs the image's kernel (a /dev/kvm that opens may still not), else emulation."""
    kvm = ("-accel", "kvm", "-cpu", "host", "-smp", "2")
    if os.environ.get("KASUMI_VM_ACCEL", "kvm") == "kvm" and os.access("/dev/kvm", os.R_OK | os.W_OK) and runs(image, kvm):
        return kvm
    return EMULATION


def runs(image, acceleration):
    trial = subprocess.Popen(
        ["qemu-system-x86_64", *acceleration, "-machine", "q35", "-m", "512", "-nodefaults", "-kernel", f"{image}/vmlinuz",
         "-append", "console=ttyS0 earlyprintk=serial", "-display", "none", "-serial", "stdio", "-nic", "none"],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        os.set_blocking(trial.stdout.fileno(), False)
        said = b""
        for _ in range(50):
            time.sleep(0.1)
            said += trial.stdout.read() or b""
            if b"Linux version" in said or trial.poll() is not None:
                break
        return b"Linux version" in said
    finally:
        trial.kill()
        trial.wait()


class Machine:
    def __init__(self, image, folder, size, extra_disk=None, utc=None):
        """`image`: what image/build printed. `folder`: for sockets, logs and pictures. `extra_disk`: a file that the guest
        sees as /dev/vdb. `utc`: what its clock says at the start, like 2026-10-20T00:50:00."""
        self.folder = pathlib.Path(folder)
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        self.pace = 1.0  # host's seconds for one of the guest's
        self.emulated = accelerator(str(image)) == EMULATION
        arguments = [
            "qemu-system-x86_64", *accelerator(str(image)), "-machine", "q35", "-m", "2048", "-nodefaults", "-no-user-config",
            "-kernel", f"{image}/vmlinuz", "-initrd", f"{image}/initrd.img",
            "-append", "root=/dev/vda rw console=ttyS0 quiet loglevel=4 systemd.show_status=false"
            " no_timer_check",  # on a busy host the kernel's timer check may fail and panic
            # Every machine starts from the same disk; its writes survive power cuts and are discarded with the machine.
            "-drive", f"file={image}/disk.img,if=virtio,format=raw,snapshot=on",
            "-device", f"virtio-gpu-pci,id=gpu,xres={size[0]},yres={size[1]}", "-vnc", f"unix:{self.socket_of('vnc')}",
            "-device", "qemu-xhci,id=usb",
            "-device", "i6300esb", "-action", "watchdog=reset",
            "-serial", f"file:{self.folder}/console.log",
            "-device", "virtio-serial", "-device", "virtserialport,chardev=agent,name=org.qemu.guest_agent.0",
            "-chardev", f"socket,id=agent,path={self.socket_of('agent')},server=on,wait=off",
            "-qmp", f"unix:{self.socket_of('qmp')},server=on,wait=off", "-nic", "none",
        ]
        if extra_disk:
            arguments += ["-drive", f"file={extra_disk},if=virtio,format=raw,readonly=on"]
        # Guest time: restoring a snapshot restores its clock.
        arguments += ["-rtc", f"base={utc or 'utc'},clock=vm"]
        with open(self.folder / "qemu.log", "wb") as log:
            self.process = subprocess.Popen(arguments, stdout=log, stderr=subprocess.STDOUT)
        self.qmp = self.agent = None
        try:
            self.qmp = self.connect("qmp")
            self.qmp.read()
            self.qmp.ask("qmp_capabilities")
            self.agent = self.connect("agent")
            self.boot_s = self.wait_for_boot()
        except BaseException:
            self.stop()
            raise

    def socket_of(self, name):
        return self.folder / f"{name}.sock"

    def connect(self, name):
        for _ in range(200):
            if self.process.poll() is not None:
                raise RuntimeError("qemu ended: " + (self.folder / "qemu.log").read_text())
            try:
                return JsonSocket(self.socket_of(name), ANSWER_S)
            except (FileNotFoundError, ConnectionRefusedError):
                time.sleep(0.05)
        raise TimeoutError(f"qemu opened no socket {name}")

    def wait_for_boot(self):
        """BLOCKS until the guest has started all its units; returns the seconds since its kernel started."""
        self.wait_for_agent()
        self.run("systemctl is-system-running --wait", check=False)
        return self.clock()

    def wait_for_agent(self):
        started = time.monotonic()
        for ticket in itertools.count(1):
            self.agent.socket.settimeout(1)
            try:
                self.agent.send("guest-sync", id=ticket)
                while self.agent.read().get("return") != ticket:
                    pass
                break
            except socket.timeout:
                if self.process.poll() is not None:
                    raise ConnectionError("qemu has ended, see qemu.log") from None
                if time.monotonic() - started > HANG_S:
                    raise TimeoutError(f"no answer from the guest after {HANG_S} s, see {self.folder}/console.log") from None
        self.agent.socket.settimeout(ANSWER_S)

    def clock(self):
        """The guest's clock: seconds since its kernel started. All limits are by it, so that a slow host breaks none."""
        return float(self.read("/proc/uptime").split()[0])

    def run(self, command, check=True):
        """Runs a shell command in the guest as root and returns its output, standard error included."""
        pid = self.agent.ask("guest-exec", path="/bin/sh", arg=["-c", f"exec 2>&1\n{command}"], **{"capture-output": True})["pid"]
        started, pause_s = time.monotonic(), POLL_S / 10
        while not (status := self.agent.ask("guest-exec-status", pid=pid))["exited"]:
            if time.monotonic() - started > HANG_S:
                raise TimeoutError(f"in the guest, still running after {HANG_S} s: {command}")
            time.sleep(pause_s * self.pace)
            pause_s = min(1.5 * pause_s, POLL_S)
        output = base64.b64decode(status.get("out-data", "")).decode(errors="replace").strip()
        if check and status.get("exitcode", -1) != 0:
            raise AssertionError(f"in the guest, exit code {status.get('exitcode')}: {command}\n{output}")
        return output

    def read(self, path):
        """A file of the guest, empty if absent. Starts no process, which is slow on an emulated machine."""
        try:
            handle = self.agent.ask("guest-file-open", path=path)
        except RuntimeError:
            return b""
        content = b""
        while (part := self.agent.ask("guest-file-read", handle=handle, count=1 << 16))["count"] > 0:
            content += base64.b64decode(part["buf-b64"])
        self.agent.ask("guest-file-close", handle=handle)
        return content

    def holds(self, command):
        """Whether a command in the guest succeeds."""
        return self.run(f"({command}) >/dev/null && echo yes", check=False).endswith("yes")

    def wait_until(self, what, condition, timeout_s, every_s=POLL_S):
        """BLOCKS until `condition` (a shell command, or a function) holds; returns the seconds it took by the guest's clock."""
        started, began = self.clock(), time.monotonic()
        seen, seen_at = started, began
        while not (condition() if callable(condition) else self.holds(condition)):
            now, now_at = self.clock(), time.monotonic()
            if now - started > timeout_s:
                raise AssertionError(f"not within {timeout_s} s: {what}")
            if now_at - began > HANG_S + SLOWEST * timeout_s:
                raise TimeoutError(f"the machine hangs: {now - started:.1f} s in {now_at - began:.0f} s, {what}")
            if now > seen:
                self.pace = min(max((now_at - seen_at) / (now - seen), 1.0), SLOWEST)
            seen, seen_at = now, now_at
            self.pause(every_s)
        return self.clock() - started

    def pause(self, moment_s=POLL_S):
        """BLOCKS for a moment of the guest's time, as quick as it was when it was last waited for."""
        time.sleep(moment_s * self.pace)

    def photograph(self, name):
        """A screenshot, as a PPM file."""
        picture = self.folder / f"{name}.ppm"
        self.qmp.ask("screendump", filename=str(picture))
        return picture

    def monitor(self):
        return Monitor(self.socket_of("vnc"))

    def keep(self, name):
        """Takes a snapshot of the whole machine, running programs included, for return_to()."""
        self.hmp(f"savevm {name}")

    def return_to(self, name):
        self.hmp(f"loadvm {name}")
        self.wait_for_agent()

    def hmp(self, command):
        if answer := self.qmp.ask("human-monitor-command", **{"command-line": command}).strip():
            raise RuntimeError(f"{command}: {answer}")

    def cut_power(self):
        """Power cycle: data that the guest has not written to its disk is lost."""
        self.qmp.ask("system_reset")

    def real_time_clock(self):
        """The machine's battery-backed clock in whole seconds: guest time that a reboot does not reset."""
        now = self.qmp.ask("qom-get", path="/machine", property="rtc-time")
        return calendar.timegm((now["tm_year"] + 1900, now["tm_mon"] + 1, now["tm_mday"], now["tm_hour"], now["tm_min"], now["tm_sec"]))

    def wait_for_reboot(self, timeout_s):
        """BLOCKS until the guest has rebooted itself; returns the seconds it took by the guest's clock."""
        started, began = self.real_time_clock(), time.monotonic()
        while (took_s := self.real_time_clock() - started) <= timeout_s and time.monotonic() - began < HANG_S + SLOWEST * timeout_s:
            for news in self.qmp.events():
                if news["event"] == "RESET" and news["data"]["reason"] == "guest-reset" and took_s > FIRMWARE_S:
                    return took_s
            time.sleep(POLL_S)  # QEMU is asked, not the guest
        raise AssertionError(f"not within {timeout_s} s: the machine reboots itself")

    def stop(self):
        for talk in (self.qmp, self.agent):
            if talk:
                talk.socket.close()
        self.process.kill()
        self.process.wait()
        for name in ("qmp", "agent", "vnc"):
            self.socket_of(name).unlink(missing_ok=True)

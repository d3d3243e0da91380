"""kasumi-report beside the appliance, under its own unit: how it runs, and that neither the network nor its peers cost a picture."""

import base64
import html
import json
import re
import struct

from live import InContainer, long

CONFIG = "/etc/kasumi/report.toml"
SCREEN_SOCKET = "/run/kasumi-screen/screen.sock"
PORT = 8750
MOST_MEMORY_KB = 20 * 1024  # row 28
# The town's network: a broker at the other end of a cable.
REPORT = f"""\
[http]
port = {PORT}
screen_picture = true
[mqtt]
host = "10.9.0.2"
tls = false
port = 1883
topic = "kasumi/hill"
every_s = 10
"""
BROKER = "listener 1883 10.9.0.2\\nallow_anonymous true"
CABLE = """\
ip netns add town
ip link add kiosk0 type veth peer name town0 netns town
ip addr add 10.9.0.1/24 dev kiosk0
ip link set kiosk0 up
ip -n town addr add 10.9.0.2/24 dev town0
ip -n town link set lo up
ip -n town link set town0 up
"""


@long
class Reporter(InContainer):
    """kasumi-report tells a browser on the machine, and a broker in the town."""

    def setUp(self):
        super().setUp()
        self.kiosk.run(CABLE)
        self.kiosk.run(f"printf '{BROKER}\\n' > /run/broker.conf && systemd-run -q --unit=broker"
                       " -p NetworkNamespacePath=/run/netns/town mosquitto -c /run/broker.conf")
        self.kiosk.install_packages("kasumi-report")
        self.kiosk.write(CONFIG, REPORT)
        self.kiosk.run("systemctl enable --now kasumi-report")
        self.kiosk.wait_until("the broker is told", lambda: self.figures()["report_mqtt_connected"] == 1.0, 30)

    def ask(self, path):
        return self.kiosk.run(f"curl -sS --max-time 20 http://127.0.0.1:{PORT}{path}")

    def figures(self):
        """What Prometheus reads, by name without labels; of several with labels the sum."""
        found = {}
        for name, value in re.findall(r"(?m)^kasumi_(\w+)(?:\{.*\})? (\S+)$", self.ask("/metrics")):
            found[name] = found.get(name, 0.0) + float(value)
        return found

    def told_broker(self):
        """The state that the broker keeps for whoever subscribes now."""
        return json.loads(self.kiosk.run("ip netns exec town mosquitto_sub -h 10.9.0.2 -t kasumi/hill/state -C 1 -W 10"))

    def processor_s(self, process):
        """What it has taken so far (proc(5): utime and stime, in ticks of 10 ms)."""
        fields = self.kiosk.read(f"/proc/{process}/stat").decode().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / 100

    def assert_no_picture_lost(self, meanwhile):
        """Calls meanwhile() until it is done: each frame of the scene camera is shown, as before."""
        before, began = self.kiosk.status(), self.kiosk.clock()
        shown = set()
        while not meanwhile():
            shown.add(self.kiosk.status().get("shown", "status being written"))
            self.kiosk.pause()
        self.kiosk.wait_new_picture()
        after, took_s = self.kiosk.status(), self.kiosk.clock() - began
        frames = after["scene_camera"]["good_frames"] - before["scene_camera"]["good_frames"]
        pictures = after["pictures"] - before["pictures"]
        dropped = after["frames_dropped"] - before["frames_dropped"]
        print(f"in {took_s:.0f} s {frames} frames, {pictures} pictures, {dropped} dropped ... ", end="", flush=True)
        # What the host keeps from the recording's camera is not asked for here; what came of it is shown.
        self.assertLessEqual(shown, {"live", "held"})
        self.assertEqual(dropped, 0)
        self.assertGreater(frames, took_s, "of a camera with two a second")
        self.assertGreaterEqual(pictures, frames - 1)
        self.assertEqual(after["scene_camera"]["reopened"], before["scene_camera"]["reopened"])
        self.assertEqual(str(after["pid"]), self.process, "the appliance was restarted")

    def test_00_unit(self):
        """Under its shipped unit: an account of its own, a closed sandbox, the page on loopback alone, an end within seconds."""
        unit = self.kiosk.unit("ActiveState", "SubState", "MainPID", "NRestarts", of="kasumi-report")
        self.assertEqual((unit["ActiveState"], unit["SubState"], unit["NRestarts"]), ("active", "running", "0"))
        process = f"/proc/{unit['MainPID']}"
        account = int(self.kiosk.run(f"stat -c %u {process}"))
        print(f"account {account}, exposure {self.kiosk.exposure_of_security('kasumi-report')} ... ", end="", flush=True)
        self.assertTrue(61184 <= account <= 65519, "not an account made for as long as it runs")
        groups = re.search(r"Groups:\s*(.*)", self.kiosk.read(f"{process}/status").decode()).group(1).split()
        # The one that may ask for the picture of the screen, and nothing else.
        screen = self.kiosk.run("getent group kasumi-screen | cut -d: -f3")
        self.assertLessEqual(set(groups), {str(account), screen})
        self.assertLessEqual(self.kiosk.exposure_of_security("kasumi-report"), 1.5)
        self.assertEqual(self.kiosk.run("ss -Hltn | awk '{ print $4 }'"), f"127.0.0.1:{PORT}")
        page = self.ask("/")
        self.assertRegex(page, "<html")
        self.assertRegex(page, "Visitors see the live view with the building")
        figures = self.figures()
        self.assertEqual((figures["up"], figures["picture_well"]), (1.0, 1.0))
        self.assertEqual(self.kiosk.run("journalctl -u kasumi-report -b -p warning -o cat --no-pager | grep -v '^mqtt:'", check=False), "")
        self.kiosk.run("systemctl stop kasumi")
        self.kiosk.wait_until("the page says that the appliance is gone", lambda: self.figures()["up"] == 0.0, 15)
        began = self.kiosk.clock()
        self.kiosk.run("systemctl stop kasumi-report")
        stopped_s = self.kiosk.clock() - began
        print(f"ended in {stopped_s:.1f} s ... ", end="", flush=True)
        self.assertLessEqual(stopped_s, 5.0)
        self.assertEqual(self.kiosk.unit("Result", of="kasumi-report")["Result"], "success")

    def press(self):
        """The button on the state page; returns the page that answers it."""
        action = html.unescape(re.search('<form method="post" action="[.]([^"]+)"', self.ask("/")).group(1))
        return self.kiosk.run(f"curl -sS --max-time 20 -X POST 'http://127.0.0.1:{PORT}{action}'")

    def test_00_screen_picture(self):
        """Not before the kiosk allows it, too; then a small picture, over a socket that is closed to everybody else."""
        self.assertNotRegex(self.ask("/"), "<form method")
        self.kiosk.run("printf '[snapshot]\\nscreen_picture = true\\n' >> /etc/kasumi/kasumi.toml && systemctl reload kasumi")
        self.kiosk.wait_until("the socket is there", f"test -S {SCREEN_SOCKET}", 10)
        owner = self.kiosk.run(f"stat -c '%U %G %a' /run/kasumi-screen {SCREEN_SOCKET}").splitlines()
        self.assertEqual(owner, ["kasumi kasumi-screen 2750", "kasumi kasumi-screen 660"])
        ask_as = "runuser -u {} -- curl -sS --max-time 5 --http0.9 --unix-socket " + SCREEN_SOCKET + " http://localhost/"
        self.assertFalse(self.kiosk.holds(ask_as.format("nobody")))
        self.kiosk.wait_shown("live")
        self.kiosk.wait_new_picture()
        self.kiosk.wait_until("the page has its button", lambda: "<form method" in self.ask("/"), 10)
        page = self.press()
        bitmap = base64.b64decode(re.search("data:image/bmp;base64,([^\"]+)", page).group(1))
        width, height = struct.unpack_from("<ii", bitmap, 18)
        colours = {bitmap[at:at + 3] for at in range(54, len(bitmap) - 2, 3)}
        print(f"{width} x {abs(height)}, {len(colours)} colours ... ", end="", flush=True)
        self.assertEqual((width, abs(height)), (32, 18))
        self.assertGreater(len(colours), 100, "no blank")
        self.assertNotRegex(self.press(), "data:image", "at most one a minute")
        self.kiosk.wait_status("it is counted", lambda status: status["screen_picture"]["taken"] == 1, 10)
        self.assertEqual(self.kiosk.run("journalctl -u kasumi -b -o cat --no-pager | grep -c 'blurred picture for the state page was sent'"), "1")
        self.assertEqual(self.kiosk.run("find /run/kasumi* /var/lib/kasumi* /tmp -name '*.bmp' -o -name '*.png' -newer /etc/kasumi/kasumi.toml"), "")

    def test_27_network_gone(self):
        """The cable is pulled: no picture is lost, the page on the machine answers; put back, the broker has the newest state."""
        self.assertEqual(self.told_broker()["sight"], "live")
        self.kiosk.run("ip link set kiosk0 down")
        self.assert_no_picture_lost(lambda: self.figures()["report_mqtt_connected"] == 0.0)
        self.kiosk.run("systemctl stop kasumi")
        self.assertRegex(self.ask("/"), "<html")
        self.kiosk.run("ip link set kiosk0 up")
        began = self.kiosk.clock()
        self.kiosk.wait_until("the broker knows", lambda: "not-running" in self.told_broker()["symptoms"], 125)
        print(f"{self.kiosk.clock() - began:.0f} s after the cable is back the broker knows ... ", end="", flush=True)
        told = self.kiosk.run("journalctl -u kasumi-report -b -p warning -o cat --no-pager | grep '^mqtt:'").splitlines()
        self.assertEqual(len(told), len(set(told)), told)
        self.assertLessEqual(len(told), 3, told)  # it does not answer; it cannot be reached

    def test_28_hostile_peers(self):
        """Slow, huge, malformed, curious and many peers: refused and counted, in little memory; no picture is lost."""
        self.assert_no_picture_lost(lambda began=self.kiosk.clock(): self.kiosk.clock() - began > 10)  # as it is without them
        pid = self.kiosk.unit("MainPID", of="kasumi-report")["MainPID"]
        used_before_s = self.processor_s(pid)
        # The peers are far away: what they need of this processor is no cost of theirs.
        self.kiosk.run("systemd-run -q --unit=peers --remain-after-exit -p CPUSchedulingPolicy=idle -p LimitNOFILE=4096"
                       f" /opt/kasumi-vm/hostile-peers {PORT} 20")
        self.assert_no_picture_lost(lambda: self.kiosk.unit("SubState", of="peers")["SubState"] != "running")
        used_s = self.processor_s(pid) - used_before_s
        memory_kb = int(re.search(r"VmHWM:\s*(\d+) kB", self.kiosk.read(f"/proc/{pid}/status").decode()).group(1))
        print(f"{self.kiosk.run('journalctl -u peers -o cat --no-pager | grep traversal')}; the reporter took {used_s:.1f} s and"
              f" {memory_kb / 1024:.1f} MB ... ", end="", flush=True)
        self.assertGreater(self.figures()["report_refused_total"], 100)
        self.assertLess(memory_kb, MOST_MEMORY_KB)
        self.assertEqual(self.kiosk.unit("MainPID", of="kasumi-report")["MainPID"], pid)

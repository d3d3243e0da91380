"""The Debian packages: installed, upgraded while the kiosk runs, removed and purged, as dpkg does it with nobody there to answer."""

import re

import kiosk
from live import CONFIG, STATE, InContainer, long

ALL = kiosk.PACKAGES
REPORT = "/etc/kasumi/report.toml"
OVERRIDE = "/etc/systemd/system/kasumi.service.d/operator.conf"
# What a container has no kernel for: devices, and its settings.
NO_KERNEL = "(?m)^(Failed to send reload request|sysctl): .*"
# What the test brought, and what every package leaves: dpkg's own notes, logs, and an account, whose number must not be given away again.
NOT_OURS = "/packages/|/opt/|/var/lib/dpkg/|/var/log/|/etc/(passwd|shadow|group|gshadow)-?$|/etc/.pwd.lock$|.*/machine-id$"


@long
class Packages(InContainer):
    def installed(self, name):
        """Version, empty if it is not; and dpkg's word for its state."""
        return self.kiosk.run(f"dpkg-query -W -f='${{Version}} ${{db:Status-Status}}' {name} 2>/dev/null", check=False)

    def service(self, name):
        """enabled or disabled, active or inactive."""
        return tuple(self.kiosk.run(f"systemctl {what} {name}", check=False) for what in ("is-enabled", "is-active"))

    def wait_live_again(self, process):
        self.kiosk.wait_status("live again", lambda status: status["shown"] == "live" and str(status["pid"]) != process, 60)

    def test_upgrade_while_it_runs(self):
        """A newer version over one that runs: it is restarted; what the operator wrote, enabled and disabled stays; no question."""
        self.kiosk.install_packages("kasumi-report", "kasumi-kiosk")
        self.assertEqual([self.service(name) for name in ("kasumi", "kasumi-report")], [("enabled", "active"), ("disabled", "inactive")])
        self.kiosk.write(REPORT, "[http]\n")
        self.kiosk.run(f"systemctl enable --now kasumi-report && echo '# the operator was here' >> {CONFIG}")
        self.kiosk.write(OVERRIDE, "[Service]\nEnvironment=OPERATOR=here")
        self.kiosk.run("systemctl daemon-reload && mkdir -p /etc/kasumi/keys && echo key > /etc/kasumi/keys/curator.pub")
        belongs = "find /etc/kasumi -type f -exec sha256sum {} +; stat -c '%n %A %U' /etc/kasumi /var/lib/kasumi"
        before = self.kiosk.run(belongs)
        reporter = self.kiosk.unit("MainPID", of="kasumi-report")["MainPID"]
        version = self.installed("kasumi")
        began = self.kiosk.clock()
        said = "\n".join(self.kiosk.install_packages(name, place="packages/next") for name in ALL)
        self.wait_live_again(self.process)
        print(f"{version}, {self.kiosk.clock() - began:.0f} s later {self.installed('kasumi')} and live ... ", end="", flush=True)
        self.assertNotRegex(re.sub(NO_KERNEL, "", said), "(?i)warning|error|failed|denied")
        self.assertEqual({self.installed(name) for name in ALL}, {f"{kiosk.NEXT_VERSION} installed"})
        self.assertEqual(self.kiosk.run(belongs), before)
        self.assertEqual([self.service(name) for name in ("kasumi", "kasumi-report")], [("enabled", "active")] * 2)
        self.assertNotEqual(self.kiosk.unit("MainPID", of="kasumi-report")["MainPID"], reporter, "the reporter was not restarted")
        self.assertRegex(self.kiosk.unit("Environment")["Environment"], "OPERATOR=here")
        # dpkg asks about conffiles alone, and there is none: what is in /etc/kasumi was written by people.
        self.assertEqual(self.kiosk.run("dpkg-query -W -f='${Conffiles}' " + " ".join(ALL)), "")
        self.assertEqual(self.kiosk.status()["start"]["failed_boots"], 0)

        self.kiosk.run("systemctl disable --now kasumi kasumi-report")
        self.kiosk.install_packages(*ALL, place="packages/next")
        self.assertEqual([self.service(name) for name in ("kasumi", "kasumi-report")], [("disabled", "inactive")] * 2)
        self.kiosk.run("systemctl mask kasumi")
        self.kiosk.install_packages("kasumi", place="packages/next")
        self.assertEqual(self.service("kasumi"), ("masked", "inactive"))

    def test_remove_and_purge(self):
        """Removed, it keeps what people wrote and what it has learnt; purged, nothing is left but what people wrote elsewhere."""
        self.kiosk.install_packages("kasumi-report", "kasumi-kiosk")
        self.kiosk.write(REPORT, '[http]\n[mail]\nto = ["a@b.org"]\n')
        self.kiosk.write(OVERRIDE, "[Service]\nEnvironment=OPERATOR=here")
        self.kiosk.run("systemctl daemon-reload && systemctl enable --now kasumi-report")
        self.kiosk.wait_until("the reporter runs", "systemctl is-active kasumi-report", 20)
        self.kiosk.run("systemctl stop kasumi")
        learnt = self.kiosk.run(f"ls {STATE}")
        self.kiosk.run("dpkg --remove " + " ".join(reversed(ALL)))
        self.assertEqual({self.installed(name).split()[-1] for name in ALL}, {"config-files"})
        self.assertEqual([self.service(name)[1] for name in ("kasumi", "kasumi-report")], ["inactive"] * 2)
        for path in ("/usr/bin/kasumi", "/usr/bin/kasumi-report", "/etc/systemd/system/ctrl-alt-del.target"):
            self.assertFalse(self.kiosk.holds(f"test -e {path} -o -L {path}"), path)
        self.assertEqual(self.kiosk.run(f"ls {STATE}"), learnt)
        self.assertTrue(self.kiosk.holds(f"test -e {CONFIG} -a -e {REPORT}"))
        self.assertEqual(self.kiosk.run("systemctl --failed --no-legend --plain"), "")

        self.kiosk.run("dpkg --purge " + " ".join(reversed(ALL)))
        self.assertEqual([self.installed(name) for name in ALL], [""] * 3)
        left = [path for path in self.kiosk.written() if not re.match(NOT_OURS, path)]
        print(f"left: {', '.join(left)} ... ", end="", flush=True)
        self.assertEqual(left, [OVERRIDE], "beside the operator's own")
        self.assertEqual(self.kiosk.run("find /run -xdev -iname '*kasumi*'"), "")

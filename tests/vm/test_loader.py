"""A program that the service manager starts, and the loader does not."""

from live import STATE, InContainer, long

NEVER_BEGAN, NO_REBOOT = f"{STATE}/never-began", "/run/kasumi/no-reboot"


@long
class Loader(InContainer):
    def starts(self):
        """Since the boot, that came to nothing."""
        return self.kiosk.journal().count("cannot open shared object file")

    def test_39_library_missing(self):
        """Two reboots, then the machine stays on and says why, however often it fails; the picture follows the library's return."""
        library = self.kiosk.run("ldd /usr/bin/kasumi | sed -n 's/.*=> \\(.*liberfa[^ ]*\\) .*/\\1/p'")
        burst = 3  # of the unit's ten: else each boot takes three minutes
        self.kiosk.write("/etc/systemd/system/kasumi.service.d/impatient.conf", f"[Unit]\nStartLimitBurst={burst}")
        boot = self.kiosk.boot_id()
        self.kiosk.run(f"mv {library} {library}.away && systemctl daemon-reload && systemctl kill -s KILL --kill-whom=main kasumi")
        for reboots in (1, 2):
            self.kiosk.wait_for_boot(after=boot)
            boot = self.kiosk.boot_id()
            print(f"reboot {reboots} ... ", end="", flush=True)
        self.kiosk.wait_until("more starts than lead to a reboot", lambda: self.starts() > burst + 1, 60)
        self.assertEqual(self.kiosk.boot_id(), boot, "it was rebooted again")
        print(f"still on after {self.starts()} starts ... ", end="", flush=True)
        said = self.kiosk.run("journalctl -u kasumi -b -p err --no-pager -o cat")
        self.assertRegex(said, "never began in this boot and the 2 before it.*stays on")
        self.assertTrue(self.kiosk.holds(f"test -e {NEVER_BEGAN}"))
        self.kiosk.run(f"mv {library}.away {library}")
        print(f"live {self.kiosk.wait_shown('live', timeout_s=60):.0f} s after it was mended ... ", end="", flush=True)
        self.assertFalse(self.kiosk.holds(f"test -e {NEVER_BEGAN} -o -e {NO_REBOOT}"))
        self.assertEqual(self.kiosk.status()["start"]["failed_boots"], 0)
        # What crashes after it began is counted as ever.
        self.kiosk.run("systemctl kill -s KILL --kill-whom=main kasumi; sleep 2")
        self.assertFalse(self.kiosk.holds(f"test -e {NO_REBOOT}"))

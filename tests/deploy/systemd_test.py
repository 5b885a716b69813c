#!/usr/bin/env python3
"""The systemd units: accepted by systemd's own checkers, hardened, and with options that exist."""

import pathlib
import re
import shutil
import subprocess
import sys
import unittest

from options import problems_of
from programs import ROOT, Programs, program, skip

FOLDER = ROOT / "deploy" / "systemd"


def settings(path):
    """The KEY=value lines of a file, without comments."""
    lines = path.read_text().splitlines()
    return [tuple(line.split("=", 1)) for line in lines if "=" in line and not line.startswith("#")]


class SystemdTest(unittest.TestCase):
    def setUp(self):
        self.programs = self.enterContext(Programs("systemd"))
        bin_folder = str(pathlib.Path(program("shutterline-server")).parent)
        self.units = []
        for template in sorted(FOLDER.glob("*.in")):
            unit = self.programs.folder / template.stem
            unit.write_text(template.read_text().replace("@BINDIR@", bin_folder).replace("@DOCDIR@", "/usr/share/doc"))
            self.units.append(unit)
        self.assertEqual([unit.name for unit in self.units],
                         ["shutterline-server.service", "shutterline-worker@.service"])

    def test_systemd_accepts_the_units(self):
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", *self.units], capture_output=True, text=True)
        # Of other units on the machine it may complain.
        ours = [line for line in done.stderr.splitlines() if "shutterline" in line]
        self.assertEqual(ours, [])

    def test_verify_would_find_a_mistake(self):
        unit = self.programs.folder / "shutterline-wrong.service"
        unit.write_text("[Service]\nExecStart=/nowhere/shutterline\nProtectSytem=strict\n")
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True)
        self.assertIn("ProtectSytem", done.stderr)

    def test_units_are_hardened(self):
        for unit in self.units:
            # The scale is from 0, confined, to 10. Nine in ten units of a distribution are above 9.
            done = subprocess.run(["systemd-analyze", "security", "--offline=true", "--threshold=20", unit],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_options_exist(self):
        for unit in self.units:
            (start,) = [value for key, value in settings(unit) if key == "ExecStart"]
            self.assertEqual(problems_of(start.split()), [])

    def test_settings_are_those_that_the_units_read(self):
        for name, unit in (("server.env", self.units[0]), ("worker.env", self.units[1])):
            given = [key for key, _ in settings(FOLDER / name)]
            read = re.findall(r"\$\{?(SHUTTERLINE_\w+)", unit.read_text())
            self.assertEqual(given, read)
            self.assertIn(f"-/etc/shutterline/{name}", dict((v, k) for k, v in settings(unit)))

    def test_user_and_folder_are_made(self):
        (self.programs.folder / "etc").mkdir()  # Where the users of the made-up root are written.
        for tool, file in (("systemd-sysusers", "shutterline.sysusers"), ("systemd-tmpfiles", "shutterline.tmpfiles")):
            arguments = [] if tool == "systemd-sysusers" else ["--create"]
            done = subprocess.run([tool, f"--root={self.programs.folder}", *arguments, FOLDER / file],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
        users = (self.programs.folder / "etc" / "passwd").read_text()
        (user,) = [line.split(":") for line in users.splitlines() if line.startswith("shutterline:")]
        self.assertEqual(user[5], "/var/lib/shutterline")
        folder = (self.programs.folder / "etc" / "shutterline").stat()
        self.assertEqual(folder.st_mode & 0o777, 0o750)
        self.assertEqual(folder.st_gid, int(user[3]))
        for unit in self.units:
            self.assertIn(("User", "shutterline"), settings(unit))


if __name__ == "__main__":
    if shutil.which("systemd-analyze") is None:
        skip("there is no systemd-analyze")
    sys.exit(unittest.main())

#!/usr/bin/env python3
"""`cmake --install` into a made-up root: everything arrives, names its final place, and works."""

import os
import pathlib
import re
import subprocess
import sys
import unittest

from programs import ROOT, Programs, program

LINK = re.compile(r"\]\(([^)\s#]+)")


class InstallTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.programs = cls.enterClassContext(Programs("install"))
        cls.root = cls.programs.folder / "root"
        cls.build = pathlib.Path(program("shutterline")).parents[1]
        subprocess.run(["cmake", "--install", cls.build, "--prefix", "/opt/farm", "--strip"], check=True,
                       env={**os.environ, "DESTDIR": str(cls.root)}, capture_output=True, cwd=cls.programs.folder)
        cls.prefix = cls.root / "opt" / "farm"

    def test_everything_arrives_and_nothing_else(self):
        for file in ("bin/shutterline", "bin/shutterline-server", "bin/shutterline-worker", "bin/shutterline-scenes",
                     "lib/systemd/system/shutterline-server.service", "lib/systemd/system/shutterline-worker@.service",
                     "lib/sysusers.d/shutterline.conf", "lib/tmpfiles.d/shutterline.conf",
                     "share/bash-completion/completions/shutterline", "share/zsh/site-functions/_shutterline",
                     "share/doc/shutterline/README.md", "share/doc/shutterline/LICENSE", "share/doc/shutterline/NOTICE",
                     "share/doc/shutterline/docs/operating.md", "share/doc/shutterline/deploy/slurm/scale",
                     "share/doc/shutterline/deploy/kubernetes/kustomization.yaml"):
            self.assertTrue((self.prefix / file).is_file(), file)
        self.assertEqual([path.name for path in self.root.iterdir()], ["opt"])
        self.assertEqual(sorted(path.name for path in self.prefix.iterdir()), ["bin", "lib", "share"])
        self.assertTrue(os.access(self.prefix / "share/doc/shutterline/deploy/slurm/scale", os.X_OK))

    def test_programs_run(self):
        for name in ("shutterline", "shutterline-server", "shutterline-worker", "shutterline-scenes"):
            done = subprocess.run([self.prefix / "bin" / name, "--help"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, name + done.stderr)

    def test_no_file_speaks_of_the_build_or_of_a_placeholder(self):
        for path in self.prefix.rglob("*"):
            if path.is_file() and path.suffix != ".png" and "doc" not in path.parts:
                data = path.read_bytes()
                self.assertNotIn(str(self.programs.folder).encode(), data, path)
                if "bin" not in path.parts:
                    self.assertNotIn(str(self.build).encode(), data, path)
                    self.assertNotRegex(data.decode(), r"@[A-Z]+@", path)

    def test_units_name_the_installed_programs(self):
        for unit in (self.prefix / "lib/systemd/system").iterdir():
            text = unit.read_text()
            (start,) = re.findall(r"^ExecStart=(\S+)", text, re.MULTILINE)
            self.assertTrue(start.startswith("/opt/farm/bin/"), start)
            self.assertTrue(os.access(f"{self.root}{start}", os.X_OK), start)
            (document,) = re.findall(r"^Documentation=file://(\S+)", text, re.MULTILINE)
            self.assertTrue(pathlib.Path(f"{self.root}{document}").is_file(), document)

    def test_completions_are_those_of_the_program(self):
        for shell, file in (("bash", "share/bash-completion/completions/shutterline"),
                            ("zsh", "share/zsh/site-functions/_shutterline")):
            made = subprocess.run([self.prefix / "bin/shutterline", "completion", shell], capture_output=True, text=True,
                                  check=True).stdout
            self.assertEqual(made, (self.prefix / file).read_text())
        # As a login shell's completion loads it, by the command's name.
        file = self.prefix / "share/bash-completion/completions/shutterline"
        done = subprocess.run(["bash", "-c", f"source {file} && complete -p shutterline"], capture_output=True, text=True)
        self.assertEqual(done.stdout, "complete -F _shutterline shutterline\n", done.stderr)

    def test_the_operators_documents_find_each_other(self):
        folder = self.prefix / "share/doc/shutterline"
        pages = [folder / "docs/operating.md", *folder.glob("deploy/*/README.md")]
        self.assertGreaterEqual(len(pages), 6)
        for page in pages:
            for link in LINK.findall(page.read_text()):
                if "://" not in link:
                    self.assertTrue((page.parent / link).exists(), f"{page.relative_to(folder)}: {link}")


if __name__ == "__main__":
    sys.exit(unittest.main())

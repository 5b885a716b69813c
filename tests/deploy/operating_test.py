#!/usr/bin/env python3
"""docs/operating.md tells the truth: its commands run as written, and its messages are those of the programs."""

import pathlib
import re
import shutil
import subprocess
import sys
import unittest

from programs import ROOT, Programs, program

PAGE = ROOT / "docs" / "operating.md"
BLOCK = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
# Each command is shown as it runs; the first that fails ends the script and its name is in the message.
PROLOGUE = "set -euo pipefail\ntrap 'echo \"line $LINENO failed: $BASH_COMMAND\" >&2' ERR\nset -x\n"


def blocks(text):
    """(language words, text) of each fenced block."""
    return [(words.split(), body) for words, body in BLOCK.findall(text)]


def isolated():
    """Words that run a command where port 7400 is free for certain, and where nothing outlives it."""
    namespaces = ["unshare", "--net", "--pid", "--fork", "--kill-child"]
    for words in (namespaces, ["unshare", "--map-root-user", *namespaces[1:]]):
        if shutil.which("unshare") and subprocess.run([*words, "ip", "link", "set", "lo", "up"],
                                                      capture_output=True).returncode == 0:
            return [*words, "bash", "-c", 'ip link set lo up && exec "$@"', "isolated"]
    return None


class OperatingTest(unittest.TestCase):
    def test_commands_run_as_written(self):
        runnable = [body for words, body in blocks(PAGE.read_text()) if words == ["sh", "run"]]
        self.assertGreaterEqual(len(runnable), 8)
        words = isolated()
        if words is None:
            self.skipTest("no namespaces here, and port 7400 may be somebody's")
        with Programs("operating") as programs:
            (programs.folder / "script").write_text(PROLOGUE + "".join(runnable))
            folder = pathlib.Path(program("shutterline")).parent
            work = programs.folder / "work"
            work.mkdir()
            done = subprocess.run([*words, "bash", programs.folder / "script"], capture_output=True, text=True,
                                  timeout=250, stdin=subprocess.DEVNULL, cwd=work,
                                  env={"PATH": f"{folder}:/usr/bin:/bin:/usr/sbin:/sbin", "HOME": str(work)})
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr[-6000:])
            # What the commands are for has happened.
            self.assertEqual(sorted(path.name for path in work.iterdir()), [
                "after_the_upgrade.exr", "demo.01.exr", "demo.01.png", "demo.02.exr", "demo.02.png", "demo.glb",
                "fetched.0003.exr", "restored.0003.exr"])
            self.assertIn("no worker is connected", done.stdout)
            self.assertIn("complete -F _shutterline shutterline", done.stdout)

    def test_messages_are_those_of_the_programs(self):
        section = PAGE.read_text().partition("## What messages mean")[2].partition("\n## ")[0]
        messages = re.findall(r"^\| `([^`]+)`", section, re.MULTILINE)
        self.assertGreaterEqual(len(messages), 12)
        sources = ""
        for folder in ("server", "worker", "client", "common"):
            for path in sorted((ROOT / folder).rglob("*.cpp")):
                # Literals that the line's width has cut, or a variable, are joined.
                sources += re.sub(r'"\s*(?:,\s*)?"', "", path.read_text())
        # Put together from a field's name and a reason.
        composed = {"lease_ttl must be at least two heartbeat intervals": "must be at least two heartbeat intervals"}
        missing = [message for message in messages if composed.get(message, message) not in sources]
        self.assertEqual(missing, [])

    def test_other_blocks_name_options_that_exist(self):
        known = {name: subprocess.run([program(name), "--help"], capture_output=True, text=True).stdout
                 for name in ("shutterline-server", "shutterline-worker")}
        for words, body in blocks(PAGE.read_text()):
            self.assertIn(words, ([], ["sh", "run"]))
            for line in body.splitlines():
                for name in known:
                    command = line.partition(f"{name} ")[2]
                    for option in re.findall(r"(--[a-z-]+)", command):
                        self.assertIn(option, known[name], line)


if __name__ == "__main__":
    sys.exit(unittest.main())

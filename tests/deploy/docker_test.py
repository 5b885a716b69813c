#!/usr/bin/env python3
"""The container files, as far as they can be checked without a container engine."""

import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import yaml
from options import problems_of
from programs import ROOT, program

FOLDER = ROOT / "deploy" / "docker"
COMPOSE = FOLDER / "compose.yaml"


def instructions():
    """(word, rest) of each instruction of the Dockerfile, lines joined."""
    text = re.sub(r"^#.*\n", "", (FOLDER / "Dockerfile").read_text(), flags=re.MULTILINE).replace("\\\n", " ")
    return [tuple(line.split(None, 1)) for line in text.splitlines() if line.strip()]


def installed_packages():
    """What the last stage installs."""
    last = max(i for i, (word, _) in enumerate(instructions()) if word == "FROM")
    (run,) = [rest for word, rest in instructions()[last:] if word == "RUN" and "apt-get install" in rest]
    return run.partition("--no-install-recommends")[2].partition("&&")[0].split()


def needed_packages():
    """The packages of the shared libraries that our programs name themselves."""
    libraries = set()
    for name in ("shutterline", "shutterline-server", "shutterline-worker"):
        dynamic = subprocess.run(["objdump", "-p", program(name)], capture_output=True, text=True, check=True).stdout
        needed = set(re.findall(r"NEEDED\s+(\S+)", dynamic))
        paths = subprocess.run(["ldd", program(name)], capture_output=True, text=True, check=True).stdout
        libraries |= {path for library, path in re.findall(r"(\S+) => (/\S+)", paths) if library in needed}
    # What a distribution moved from /lib to /usr/lib is known to dpkg by the old name. Asked once: it is slow.
    names = {library: {library, str(pathlib.Path(library).resolve())} for library in libraries}
    names = {library: paths | {path.removeprefix("/usr") for path in paths} for library, paths in names.items()}
    answers = subprocess.run(["dpkg-query", "--search", *sorted(set().union(*names.values()))], capture_output=True,
                             text=True).stdout
    owners = {line.rpartition(": ")[2]: line.partition(":")[0] for line in answers.splitlines()}
    unowned = [library for library, paths in names.items() if not paths & set(owners)]
    assert not unowned, f"of no package: {unowned}"
    return {owners[path] for paths in names.values() for path in paths if path in owners}


class DockerTest(unittest.TestCase):
    def test_dockerfile_is_sound(self):
        words = [word for word, _ in instructions()]
        self.assertLessEqual(set(words), {"FROM", "WORKDIR", "COPY", "RUN", "USER", "VOLUME", "STOPSIGNAL", "CMD"})
        self.assertEqual(words[0], "FROM")
        stages = [rest for word, rest in instructions() if word == "FROM"]
        self.assertEqual(stages, ["debian:12 AS build", "debian:12-slim"])
        for word, rest in instructions():
            if word == "COPY" and not rest.startswith("--from=build "):
                for source in rest.split()[:-1]:
                    self.assertTrue((ROOT / source).exists(), source)
            if word == "RUN":
                shell = subprocess.run(["bash", "-n", "-c", rest], capture_output=True, text=True)
                self.assertEqual(shell.returncode, 0, shell.stderr)
        users = [rest for word, rest in instructions() if word == "USER"]
        self.assertEqual(users, ["7400:7400"])

    def test_image_installs_the_libraries_of_the_programs(self):
        # Part of every Debian image.
        everywhere = {"libc6", "libgcc-s1", "libstdc++6"}
        self.assertEqual(needed_packages() - everywhere - set(installed_packages()), set())

    def test_compose_is_sound(self):
        compose = yaml.safe_load(COMPOSE.read_text())
        services = compose["services"]
        self.assertEqual(set(services), {"coordinator", "worker"})
        for name, service in services.items():
            self.assertEqual(problems_of(service["command"]), [], name)
            self.assertTrue((COMPOSE.parent / service["build"]["context"] / service["build"]["dockerfile"]).exists())
            self.assertLessEqual(set(service["networks"]), set(compose["networks"]), name)
            folders = dict(volume.split(":") for volume in service["volumes"])
            self.assertLessEqual(set(folders), set(compose["volumes"]), name)
            for word in service["command"]:
                option, _, value = word.partition("=")
                if option in ("--data", "--cache-dir"):
                    self.assertIn(value, folders.values(), f"{name}: the root is read-only")
            self.assertLessEqual(set(service.get("depends_on", ())), set(services), name)
        check = services["coordinator"]["healthcheck"]["test"]
        self.assertEqual(check[0], "CMD")
        self.assertEqual(problems_of(check[1:]), [])
        (port,) = services["coordinator"]["ports"]
        self.assertTrue(port.startswith("127.0.0.1:"), "published to other machines, though nothing is encrypted")
        self.assertIn("--coordinator=coordinator:7400", services["worker"]["command"])
        self.assertIn("--listen=0.0.0.0:7400", services["coordinator"]["command"])

    def test_docker_accepts_the_compose_file(self):
        has = shutil.which("docker") and subprocess.run(["docker", "compose", "version"],
                                                        capture_output=True).returncode == 0
        if not has:
            self.skipTest("there is no docker compose: only its structure was checked")
        done = subprocess.run(["docker", "compose", "-f", COMPOSE, "config", "--quiet"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    sys.exit(unittest.main())

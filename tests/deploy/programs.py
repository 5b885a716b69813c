"""Programs under test as real processes, below one temporary folder.

Everything that was started is ended, and the folder removed, when the `with` block is left, however it is
left; where it is left by an exception, the ends of all logs are printed first. Where the test itself is
killed, the kernel kills what it started.
"""

import ctypes
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = 77  # ctest's word for it, see CMakeLists.txt.
_LIBC = ctypes.CDLL(None, use_errno=True)
_PR_SET_PDEATHSIG = 1


def program(name):
    """The path of one of our programs, from the build that SHUTTERLINE_BUILD names (default: build/release)."""
    build = pathlib.Path(os.environ.get("SHUTTERLINE_BUILD", ROOT / "build" / "release"))
    path = build / "bin" / name
    if not path.exists():
        sys.exit(f"error: {path} does not exist: build it first")
    return str(path)


def skip(reason):
    """Ends the test as skipped. In a place that must not skip, SHUTTERLINE_NO_SKIP=1 makes it a failure."""
    print(f"SKIPPED: {reason}", file=sys.stderr, flush=True)
    sys.exit(1 if os.environ.get("SHUTTERLINE_NO_SKIP") == "1" else SKIPPED)


def isolate():
    """Runs this test anew in a process namespace of its own, where that is allowed: all that it starts ends with
    it, whatever detaches itself and however the test ends."""
    words = ["unshare", "--pid", "--fork", "--kill-child", "--mount-proc"]
    if os.environ.get("SHUTTERLINE_ISOLATED") != "1" and shutil.which("unshare") and subprocess.run(
            [*words, "true"], capture_output=True).returncode == 0:
        os.environ["SHUTTERLINE_ISOLATED"] = "1"
        os.execvp(words[0], [*words, sys.executable, "-B", *sys.argv])


def say(text):
    print(f"{time.strftime('%H:%M:%S')} {text}", flush=True)


def wait_until(done, what, timeout=60, every=0.05):
    """Polls, for what other processes do and offer no event for; returns what `done` did."""
    deadline = time.monotonic() + timeout
    while True:
        value = done()
        if value:
            return value
        if time.monotonic() >= deadline:
            raise AssertionError(f"not within {timeout} s: {what}")
        time.sleep(every)


def _die_with_parent():
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


class Programs:
    """`netns`, where given, names the network namespace in which a program runs."""

    def __init__(self, name):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix=f"shutterline-{name}."))
        self.started = {}  # Popen by name, in order of starting.
        self._finally = []

    def __enter__(self):
        # A test that ctest or a person asks to stop cleans up as well.
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            signal.signal(number, lambda *_: sys.exit(128 + signal.SIGTERM))
        return self

    def __exit__(self, kind, *_):
        if kind is not None and kind is not SystemExit:
            self._print_logs()
        self.stop(*reversed(list(self.started)))
        for action in reversed(self._finally):
            action()
        shutil.rmtree(self.folder, ignore_errors=True)

    def finally_do(self, action):
        """Called after all programs have ended, the last given first."""
        self._finally.append(action)

    def _print_logs(self):
        for log in sorted(self.folder.rglob("*.log")):
            text = log.read_text(errors="replace")[-2000:]
            if text.strip():
                print(f"--- {log.relative_to(self.folder)}\n{text}", file=sys.stderr, flush=True)

    def log(self, name):
        return self.folder / f"{name}.log"

    def start(self, name, command, netns=None, stop_signal=signal.SIGTERM, **kwargs):
        if netns is not None:
            command = ["ip", "netns", "exec", netns, *command]
        with open(self.log(name), "ab") as log:
            process = subprocess.Popen([str(word) for word in command], stdin=subprocess.DEVNULL, stdout=log,
                                       stderr=log, preexec_fn=_die_with_parent, **kwargs)
        process.stop_signal = stop_signal
        self.started[name] = process
        return process

    def stop(self, *names, timeout=10):
        """Asks them to end, all at once, and kills what does not."""
        processes = [self.started.pop(name) for name in names]
        for process in processes:
            process.send_signal(process.stop_signal)
        deadline = time.monotonic() + timeout
        for process in processes:
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def run(self, command, netns=None, timeout=120, check=True, **kwargs):
        """Runs to the end; its standard output. A failure of it fails the test."""
        if netns is not None:
            command = ["ip", "netns", "exec", netns, *command]
        done = subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=timeout, **kwargs)
        if check and done.returncode != 0:
            raise AssertionError(f"{' '.join(map(str, command))} ended with {done.returncode}:\n"
                                 f"{done.stdout}{done.stderr}")
        return done.stdout


class Farm:
    """A coordinator and what clients ask of it, in the network namespace `netns` if one is given."""

    def __init__(self, programs, host="127.0.0.1", netns=None, server_options=()):
        self.programs, self.netns = programs, netns
        port_file = programs.folder / "port"
        self.server = programs.start(
            "server", [program("shutterline-server"), "--listen", f"{host}:0", "--data", programs.folder / "data",
                       "--port-file", port_file, *server_options], netns)

        def served():
            assert self.server.poll() is None, "the coordinator ended while starting"
            return port_file.exists()

        wait_until(served, "the coordinator serves", 30)
        self.address = f"{host}:{port_file.read_text().strip()}"

    def client(self, *arguments, timeout=120):
        return self.programs.run([program("shutterline"), *arguments, "--server", self.address], self.netns, timeout)

    def workers(self):
        return json.loads(self.client("workers", "--json"))["workers"]

    def wait_for_workers(self, count, timeout=60):
        """Of those that this test started itself none may have left."""
        def connected():
            for name, process in self.programs.started.items():
                assert not name.startswith("worker") or process.poll() is None, f"{name} has left"
            return len(self.workers()) == count

        wait_until(connected, f"{count} workers are connected", timeout)

    def submit(self, scene, *picture):
        return self.client("submit", scene, *picture).strip()

    def job(self, job):
        return json.loads(self.client("status", job, "--json"))

    def tiles_done(self, job):
        return self.job(job)["tiles_done"]

    def fetch(self, job, file, timeout=120):
        """Waits for the job's one frame and fetches it."""
        self.client("watch", job, "--quiet", timeout=timeout)
        self.client("fetch", job, "-o", file, timeout=timeout)


def make_scene(programs, name):
    file = programs.folder / f"{name}.glb"
    programs.run([program("shutterline-scenes"), name, "-o", file])
    return file


def render_alone(programs, scene, file, *picture):
    """The truth: one process, without any network."""
    programs.run([program("shutterline"), "render", scene, *picture, "-o", file], timeout=300)


def assert_same_picture(file, truth):
    """Equal in every byte, headers included: what `render` writes and what a farm assembles must not differ."""
    a, b = pathlib.Path(file).read_bytes(), pathlib.Path(truth).read_bytes()
    assert len(b) > 10000, f"{truth} holds no picture: {len(b)} bytes"
    if a != b:
        first = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
        raise AssertionError(f"{file} ({len(a)} bytes) and {truth} ({len(b)} bytes) differ from byte {first} on")

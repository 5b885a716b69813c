"""Two hosts in network namespaces of their own, with a bad link between them.

The link is a veth pair under `tc netem` where the kernel has netem, else the TUN devices of wire.py; both
delay every packet by the same time, each way, and lose the same share.
"""

import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys

from programs import wait_until

HERE = pathlib.Path(__file__).resolve().parent


def _ip(*words):
    return subprocess.run(["ip", *words], capture_output=True, text=True)


def why_not_here():
    """Why no namespaces can be made here; empty where they can."""
    if os.geteuid() != 0:
        return "only root can make network namespaces"
    if shutil.which("ip") is None or shutil.which("tc") is None:
        return "there is no ip or tc (package iproute2)"
    probe = f"shutterline-probe-{os.getpid()}"
    made = _ip("netns", "add", probe)
    if made.returncode != 0:
        return f"ip netns add: {made.stderr.strip()}"
    try:
        if _netem_works(probe) or os.path.exists("/dev/net/tun"):
            return ""
        return "neither netem nor /dev/net/tun"
    finally:
        _ip("netns", "del", probe)


def _netem_works(namespace):
    return subprocess.run(["tc", "-n", namespace, "qdisc", "add", "dev", "lo", "root", "netem", "delay", "1ms"],
                          capture_output=True).returncode == 0


class TwoHosts:
    """`near` and `far` are names of namespaces, `near_address` and `far_address` their addresses."""

    near_address, far_address = "10.77.31.1", "10.77.31.2"  # In namespaces of our own: nobody else's.

    def __init__(self, programs, delay, loss, seed):
        self.programs, self.delay, self.loss = programs, delay, loss
        self.near, self.far = (f"shutterline-{os.getpid()}-{side}" for side in ("near", "far"))
        programs.finally_do(self._remove)
        for namespace in (self.near, self.far):
            self._do("ip", "netns", "add", namespace)
        self.netem = _netem_works(self.near)
        if self.netem:
            self._do("ip", "-n", self.near, "link", "add", "wire", "type", "veth", "peer", "name", "wire", "netns",
                     self.far)
            for namespace, address in ((self.near, self.near_address), (self.far, self.far_address)):
                self._do("ip", "-n", namespace, "addr", "add", f"{address}/24", "dev", "wire")
                self._do("ip", "-n", namespace, "link", "set", "lo", "up")
                self._do("ip", "-n", namespace, "link", "set", "wire", "up")
                self._netem(namespace, "add", loss)
        else:
            self.wire = programs.start(
                "wire", [sys.executable, "-B", HERE / "wire.py", f"{self.near}:{self.near_address}",
                         f"{self.far}:{self.far_address}", "--delay", delay, "--loss", loss, "--seed", seed])
            wait_until(lambda: "ready" in programs.log("wire").read_text(), "the wire is laid", 10)

    def kind(self):
        return "tc netem" if self.netem else "wire.py, as this kernel has no netem"

    def cut(self):
        """From now on nothing arrives, in either direction, and nobody is told."""
        self._set_cut(True)

    def mend(self):
        self._set_cut(False)

    def _set_cut(self, cut):
        if self.netem:
            for namespace in (self.near, self.far):
                self._netem(namespace, "change", 1.0 if cut else self.loss)
        else:
            self.wire.send_signal(signal.SIGUSR1 if cut else signal.SIGUSR2)

    def _netem(self, namespace, action, loss):
        self._do("tc", "-n", namespace, "qdisc", action, "dev", "wire", "root", "netem", "limit", "20000", "delay",
                 f"{self.delay * 1000:g}ms", "loss", f"{loss * 100:g}%")

    def _do(self, *command):
        self.programs.run(command)

    def _remove(self):
        with contextlib.suppress(OSError):
            for namespace in (self.near, self.far):
                _ip("netns", "del", namespace)

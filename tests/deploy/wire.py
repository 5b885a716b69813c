#!/usr/bin/env python3
"""A long wire between two network namespaces: delays every packet, and loses some.

Usage: wire.py NAMESPACE:ADDRESS NAMESPACE:ADDRESS --delay SECONDS --loss SHARE --seed N

For kernels without netem. Each namespace gets a TUN device `wire`; packets, whole and of any protocol, go
from one to the other `delay` later, so that TCP on both sides meets what it meets on a bad link: late
acknowledgements, and losses to be repaired. SIGUSR1 cuts the wire without a word to either side, SIGUSR2
mends it. Prints "ready", and when told to end (SIGTERM) what went through. Needs root.
"""

import argparse
import collections
import ctypes
import fcntl
import os
import random
import select
import signal
import struct
import subprocess
import sys
import time

_CLONE_NEWNET = 0x40000000
_TUNSETIFF = 0x400454CA
_IFF_TUN_NO_PI = 0x0001 | 0x1000
_QUEUE = 20000  # Packets on their way; more than a link of this delay holds.


def tun_in(namespace, address, netmask_bits=24):
    """A TUN device in a namespace, up and with an address; the file descriptor of its far end."""
    libc = ctypes.CDLL(None, use_errno=True)
    home = os.open("/proc/self/ns/net", os.O_RDONLY)
    there = os.open(f"/var/run/netns/{namespace}", os.O_RDONLY)
    try:
        if libc.setns(there, _CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), f"enter {namespace}")
        device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
        fcntl.ioctl(device, _TUNSETIFF, struct.pack("16sH22x", b"wire", _IFF_TUN_NO_PI))
    finally:
        libc.setns(home, _CLONE_NEWNET)
        os.close(home)
        os.close(there)
    for words in (["addr", "add", f"{address}/{netmask_bits}", "dev", "wire"], ["link", "set", "wire", "up"],
                  ["link", "set", "lo", "up"]):
        subprocess.run(["ip", "-n", namespace, *words], check=True)
    return device


class Wire:
    def __init__(self, ends, delay, loss, seed):
        self.ends, self.delay, self.loss = ends, delay, loss
        self.random = random.Random(seed)
        self.cut = False
        self.under_way = collections.deque()  # (when it arrives, where, packet): in order, all wait equally long.
        self.counts = collections.Counter()

    def take(self, end):
        """Reads what one side sends."""
        while True:
            try:
                packet = os.read(end, 65536)
            except BlockingIOError:
                return
            if self.cut:
                self.counts["cut"] += 1
            elif self.random.random() < self.loss or len(self.under_way) >= _QUEUE:
                self.counts["lost"] += 1
            else:
                other = self.ends[1] if end == self.ends[0] else self.ends[0]
                self.under_way.append((time.monotonic() + self.delay, other, packet))

    def deliver(self):
        """Hands over what has arrived; how long until the next packet does, or None."""
        while self.under_way:
            due, end, packet = self.under_way[0]
            wait = due - time.monotonic()
            if wait > 0:
                return wait
            self.under_way.popleft()
            if self.cut:
                self.counts["cut"] += 1
                continue
            try:
                os.write(end, packet)
                self.counts["passed"] += 1
            except OSError:
                self.counts["lost"] += 1  # The receiver's queue is full.
        return None

    def set_cut(self, cut):
        self.cut = cut

    def run(self):
        while True:
            wait = self.deliver()
            readable, _, _ = select.select(self.ends, [], [], wait)
            for end in readable:
                self.take(end)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ends", nargs=2, metavar="NAMESPACE:ADDRESS")
    parser.add_argument("--delay", type=float, required=True)
    parser.add_argument("--loss", type=float, required=True)
    parser.add_argument("--seed", type=int, required=True)
    given = parser.parse_args()
    wire = Wire([tun_in(*end.split(":", 1)) for end in given.ends], given.delay, given.loss, given.seed)
    signal.signal(signal.SIGUSR1, lambda *_: wire.set_cut(True))
    signal.signal(signal.SIGUSR2, lambda *_: wire.set_cut(False))
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    print("ready", flush=True)
    try:
        wire.run()
    finally:
        print(" ".join(f"{name}={count}" for name, count in sorted(wire.counts.items())), flush=True)


if __name__ == "__main__":
    main()

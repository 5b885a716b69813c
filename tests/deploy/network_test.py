#!/usr/bin/env python3
"""A coordinator and its workers with a bad network between them, which then breaks in mid-frame.

Every packet takes 50 ms and one of a hundred is lost. The link is cut for twice the time after which the
coordinator gives a silent worker's tiles away, without either side being told, and mended. The frame must
come out equal, byte by byte, to that of one process, and no tile may be rendered more than twice.

SHUTTERLINE_LONG=1: with the coordinator's own times (15 s, 5 s), and a cut of 30 s.
"""

import collections
import json
import os
import re
import sys
import time

import two_hosts
from programs import Farm, Programs, assert_same_picture, make_scene, program, render_alone, say, skip, wait_until

LONG = os.environ.get("SHUTTERLINE_LONG") == "1"
LEASE_TTL, HEARTBEAT, CUT = (15, 5, 30) if LONG else (3, 1, 6)
PICTURE = ("--size", "270x200", "--float", "--frame", "3", "--integrator", "reference", "--spp", "128")
SEED = int(os.environ.get("SHUTTERLINE_SEED", "1"))


def main():
    reason = two_hosts.why_not_here()
    if reason:
        skip(f"no two hosts: {reason}")
    with Programs("network") as programs:
        check(programs)
    say("passed")


def renderings(programs, names):
    """How often each tile was rendered, from the workers' own logs."""
    line = re.compile(r"tile rendered job=(\S+) frame=(\S+) tile=(\S+)")
    return collections.Counter(match for name in names for match in line.findall(programs.log(name).read_text()))


def check(programs):
    scene = make_scene(programs, "debris")
    truth = programs.folder / "truth.exr"
    render_alone(programs, scene, truth, *PICTURE)

    hosts = two_hosts.TwoHosts(programs, delay=0.05, loss=0.01, seed=SEED)
    say(f"the link is {hosts.kind()}; seed {SEED}")
    farm = Farm(programs, hosts.near_address, hosts.near,
                ["--insecure-listen", "--lease-ttl", LEASE_TTL, "--heartbeat", HEARTBEAT])
    names = ["worker-1", "worker-2"]
    for name in names:
        programs.start(name, [program("shutterline-worker"), "--coordinator", farm.address, "--name", name, "--threads",
                              1, "--cache-dir", programs.folder / f"cache-{name}", "--log-level", "debug"], hosts.far)
    farm.wait_for_workers(2, timeout=10)  # Some round trips; it used to take many tries.
    say("two workers are connected")
    job = farm.submit(scene, *PICTURE)
    wait_until(lambda: farm.tiles_done(job) >= 6, "some tiles are done")

    hosts.cut()
    began = time.monotonic()
    done = farm.tiles_done(job)
    assert done < 50, f"{done} of 63 tiles: too fast to be cut in mid-frame"
    wait_until(lambda: not any(worker["leased_tiles"] for worker in farm.workers()), "the leases ran out", CUT)
    say(f"cut with {done} tiles done: all leases ran out after {time.monotonic() - began:.1f} s")
    time.sleep(max(0.0, CUT - (time.monotonic() - began)))  # The cut's length is what is tested.
    assert farm.tiles_done(job) <= done + 6, "the link was not cut"
    hosts.mend()
    mended = time.monotonic()
    wait_until(lambda: any(worker["leased_tiles"] for worker in farm.workers()), "work goes on")
    say(f"mended after {CUT} s; {time.monotonic() - mended:.1f} s later a worker had tiles again")

    file = programs.folder / "farm.exr"
    farm.fetch(job, file)
    assert_same_picture(file, truth)
    assert farm.job(job)["mismatched_tiles"] == 0
    farm.wait_for_workers(2)
    for name in names:
        assert programs.started[name].poll() is None, f"{name} has left"
    programs.stop(*names)
    programs.stop("server")  # Before the wire: it says goodbye to its peers.
    times = collections.Counter(renderings(programs, names).values())
    say(f"the frame is the same; times that tiles were rendered: {json.dumps(dict(sorted(times.items())))}")
    assert sum(times.values()) == 63 and max(times) <= 2, times


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Workers in a real Slurm: scaled up and down, and a node killed, all in the middle of one frame.

The frame must come out equal, byte by byte, to that of one process. Starts a Slurm of its own; skipped,
and says why, where none can be started. With SHUTTERLINE_LONG=1 it also waits until Slurm has restarted the
task of the lost node, for some minutes.
"""

import os
import pathlib
import sys

import private_slurm
from programs import (ROOT, Farm, Programs, assert_same_picture, isolate, make_scene, program, render_alone, say, skip,
                      wait_until)

SCALE = ROOT / "deploy" / "slurm" / "scale"
# Slow enough for all that happens meanwhile: 63 tiles of some 0.16 s.
PICTURE = ("--size", "270x200", "--float", "--frame", "3", "--integrator", "reference", "--spp", "192")


def main():
    reason = private_slurm.why_not_here()
    if reason:
        skip(f"no private Slurm: {reason}")
    isolate()
    with Programs("slurm") as programs:
        check(programs)
    say("passed")


def check(programs):
    scene = make_scene(programs, "debris")
    truth = programs.folder / "truth.exr"
    render_alone(programs, scene, truth, *PICTURE)
    say("rendered by one process")

    slurm = private_slurm.PrivateSlurm(programs, ["w1", "w2"])
    farm = Farm(programs)
    say(f"a Slurm of two nodes runs; the coordinator serves {farm.address}")

    bin_folder = str(pathlib.Path(program("shutterline-worker")).parent)

    def scale(count):
        return slurm.run(SCALE, str(count), f"--output={programs.folder}/task-%A_%a.log", "--time=5",
                         SHUTTERLINE_COORDINATOR=farm.address, SHUTTERLINE_CACHE_DIR=str(programs.folder / "cache"),
                         PATH=f"{bin_folder}:{slurm.environment['PATH']}").strip()

    def assert_scale(count, answer):
        said = scale(count)
        assert said == answer, f"scale {count} said '{said}' instead of '{answer}'"

    # Up, and the number is kept.
    assert_scale(1, "submitted 1 workers: 1")
    assert_scale(1, "let 0 workers go: 1")
    assert_scale(2, "submitted 1 workers: 2")
    farm.wait_for_workers(2)
    say(f"two workers: {[worker['name'] for worker in farm.workers()]}")
    job = farm.submit(scene, *PICTURE)
    wait_until(lambda: farm.tiles_done(job) >= 1, "the first tile is done")

    # Down: the worker that goes delivers what it holds, and Slurm sees it end well.
    before = {task for task, *_ in slurm.tasks()}
    assert_scale(1, "let 1 workers go: 1")
    assert_scale(1, "let 0 workers go: 1")  # A worker that drains does not count.
    farm.wait_for_workers(1)
    wait_until(lambda: len(slurm.tasks()) == 1, "Slurm knows of one worker")
    (gone,) = before - {task for task, *_ in slurm.tasks()}
    state = slurm.job_state(gone)
    assert (state["JobState"], state["ExitCode"]) == ("COMPLETED", "0:0"), state
    log = programs.log("server").read_text()
    assert log.count("orderly=true") == 1 and "orderly=false" not in log, log
    say(f"task {gone} has drained, {farm.tiles_done(job)} tiles are done")

    # Up again, and a node dies.
    scale(2)
    farm.wait_for_workers(2)
    (victim,) = [node for task, _, node in slurm.tasks() if task != sorted(before - {gone})[0]]
    done = farm.tiles_done(job)
    killed = slurm.kill_node(victim)
    assert killed >= 3, f"slurmd, slurmstepd and the worker: only {killed} processes were found"
    assert done < 63, "the frame was finished before the node died: nothing was tested"
    say(f"node {victim} was killed, {killed} processes, with {done} of 63 tiles done")
    farm.wait_for_workers(1)

    file = programs.folder / "farm.exr"
    farm.fetch(job, file)
    assert_same_picture(file, truth)
    say(f"the frame is finished and the same; Slurm still believes: {slurm.node_states()}")
    assert farm.job(job)["mismatched_tiles"] == 0

    # Slurm will queue the lost task again, which takes it minutes: nobody waits for that unless asked.
    (lost,) = [task for task, _, node in slurm.tasks() if node == victim]
    assert slurm.job_state(lost)["Requeue"] == "1", slurm.job_state(lost)
    if os.environ.get("SHUTTERLINE_LONG") == "1":
        wait_until(lambda: slurm.node_states()[victim].startswith("down"), f"Slurm misses {victim}", 200, every=1)
        say(f"Slurm misses {victim}")
        slurm.start_node(victim)
        farm.wait_for_workers(2, timeout=400)
        say(f"task {lost} runs again on its own: {slurm.tasks()}")
    scale(0)
    farm.wait_for_workers(0)


if __name__ == "__main__":
    sys.exit(main())

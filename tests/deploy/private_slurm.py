"""A Slurm of our own on loopback: munged, slurmctld and slurmd nodes, below the folder of a `Programs`.

It has its own ports, key, sockets and folders, and needs neither systemd nor a configured machine; a Slurm
that already runs here is not touched. Everything runs as root, because slurmd must.
"""

import contextlib
import ctypes
import os
import pathlib
import shutil
import signal
import socket
import time

from programs import wait_until

_CONF = """\
ClusterName=shutterline
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmctldPort={ctld_port}
StateSaveLocation={folder}/ctld
SlurmdSpoolDir={folder}/spool/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.own
SlurmdLogFile={folder}/slurmd-%n.own
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
# A job starts at once, not after some seconds' thought.
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,sched_interval=1
# What is lost here is to be missed by our coordinator, long before Slurm misses it.
SlurmdTimeout=40
KillWait=5
ReturnToService=2
{nodes}
PartitionName=render Nodes={names} Default=YES MaxTime=10 State=UP
"""
_PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol")
_PR_SET_CHILD_SUBREAPER = 36


def why_not_here():
    """Why no private Slurm can be started here; empty where it can."""
    missing = [name for name in _PROGRAMS if shutil.which(name, path=_search_path()) is None]
    if missing:
        return f"not installed: {', '.join(missing)} (packages slurm-wlm and munge)"
    if os.geteuid() != 0:
        return "only root can start slurmd"
    return ""


def _search_path():
    return os.environ.get("PATH", "") + ":/usr/sbin:/sbin"


def _free_ports(count):
    """Ports that nobody serves. Another program may take one before we do; then starting fails, loudly."""
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def _processes():
    """(process id, parent's id, environment) of every process that we may look at."""
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            yield int(entry.name), parent, (entry / "environ").read_bytes()
        except (OSError, ValueError):
            continue  # It ended meanwhile.


class PrivateSlurm:
    def __init__(self, programs, nodes):
        self.programs, self.nodes = programs, nodes
        self.folder = programs.folder / "slurm"
        for folder in ("munge", "ctld", *(f"spool/{node}" for node in nodes)):
            (self.folder / folder).mkdir(parents=True)
        # munged wants its socket's folder to be open to all; the key lies below it, readable by us alone.
        os.chmod(programs.folder, 0o711)
        ctld_port, *node_ports = _free_ports(1 + len(nodes))
        self.conf = self.folder / "slurm.conf"
        self.conf.write_text(_CONF.format(
            folder=self.folder, ctld_port=ctld_port, names=",".join(nodes),
            nodes="\n".join(f"NodeName={node} NodeHostname=localhost NodeAddr=127.0.0.1 Port={port} CPUs=1 "
                            "RealMemory=500 State=UNKNOWN" for node, port in zip(nodes, node_ports))))
        self.environment = {**os.environ, "PATH": _search_path(), "SLURM_CONF": str(self.conf)}
        # Slurm detaches what it starts; so it becomes our child, to be found and ended.
        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)
        programs.finally_do(self._end_what_is_left)
        self._start_munge()
        # Asked to end, it would wait for answers of nodes that are dead.
        programs.start("slurmctld", ["slurmctld", "-D", "-i", "-f", self.conf], stop_signal=signal.SIGKILL,
                       env=self.environment)
        for node in nodes:
            self.start_node(node)
        wait_until(lambda: self.node_states() == {node: "idle" for node in nodes}, "all nodes are idle", 30)

    def _start_munge(self):
        munge = self.folder / "munge"
        key = munge / "key"
        key.touch(0o600)
        key.write_bytes(os.urandom(128))
        self.programs.start(
            "munged", ["munged", "--foreground", "--num-threads=2", f"--socket={munge}/socket", f"--key-file={key}",
                       f"--pid-file={munge}/pid", f"--seed-file={munge}/seed", f"--log-file={munge}/own"],
            env=self.environment)
        wait_until((munge / "socket").exists, "munged serves", 10)

    def start_node(self, node):
        # The mark is inherited by slurmstepd; what a job runs has SLURMD_NODENAME.
        self.programs.start(f"slurmd-{node}", ["slurmd", "-D", "-f", self.conf, "-N", node],
                            env={**self.environment, "SHUTTERLINE_TEST_NODE": node})

    def kill_node(self, node):
        """The node and all that runs on it are gone without a word, as if somebody pulled the plug."""
        marks = [f"{name}={node}".encode() for name in ("SHUTTERLINE_TEST_NODE", "SLURMD_NODENAME")]
        ours = f"SLURM_CONF={self.conf}".encode()
        victims = [pid for pid, _, environment in _processes()
                   if ours in environment.split(b"\0") and any(mark in environment.split(b"\0") for mark in marks)]
        for pid in victims:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.programs.started.pop(f"slurmd-{node}").wait()
        return len(victims)

    def run(self, *command, **more_environment):
        """Runs a command of Slurm's, or a script that uses them."""
        return self.programs.run(command, env={**self.environment, **more_environment})

    def node_states(self):
        """States by node: idle, alloc, mix, down*, …"""
        lines = self.run("sinfo", "--noheader", "--Node", "--format=%N %t").splitlines()
        return dict(line.split() for line in lines)

    def tasks(self):
        """(task, state, node) of all that is queued or runs."""
        lines = self.run("squeue", "--noheader", "--array", "--format=%i|%T|%N").splitlines()
        return [tuple(line.split("|")) for line in lines]

    def job_state(self, task):
        """What Slurm knows of a task, ended ones too, as a dictionary: JobState, ExitCode, …"""
        text = self.run("scontrol", "--oneliner", "show", "job", task)
        return dict(word.split("=", 1) for word in text.split() if "=" in word)

    def _end_what_is_left(self):
        """slurmstepd and what it runs: everything that descends from this process."""
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline:
            parents = {pid: parent for pid, parent, _ in _processes()}
            ours = {os.getpid()}
            while more := {pid for pid, parent in parents.items() if parent in ours} - ours:
                ours |= more
            ours.remove(os.getpid())
            for pid in ours:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            with contextlib.suppress(ChildProcessError):
                while os.waitpid(-1, os.WNOHANG)[0] != 0:
                    pass
                continue
            return  # No child is left.

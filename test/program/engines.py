#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile parallel make munge slurmctld slurmd slurm-client
"""Draws a picture in parts by GNU parallel, Make and Slurm, with the scripts that are installed as samples: the stack is that
of one process, byte for byte, also where a part is killed. Slurm's own daemons run here, on loopback, and are ended at the
end. Prints TAP."""
import contextlib
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time

from rendered import SPECTRAL, TMP, bytes_of, check, done, remove

SAMPLES = os.path.abspath("data/samples")
HOME = os.path.abspath(TMP)
STACK = os.path.join(HOME, "the stack.tif")
PLAIN = os.path.join(HOME, "stack.tif")  # Make takes no blanks
WHOLE = os.path.join(HOME, "whole.tif")
SCENE = ["patches", "--size", "1600x1300", "--wavelengths", "450:650:100"]  # three rows of tiles
OURS = {**os.environ, "SPECTRAL": os.path.abspath(SPECTRAL), "HOME": HOME}


def start(words):
    return subprocess.Popen(words, cwd=HOME, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            universal_newlines=True, env=OURS)


def run(words):
    process = start(words)
    said = process.communicate(timeout=200)[0]
    return process.returncode, said


PARALLEL = ["sh", os.path.join(SAMPLES, "parts-parallel.sh"), "3", STACK, *SCENE]
MAKE = ["make", "-s", "-f", os.path.join(SAMPLES, "parts.mk"), "-j2", f"STACK={PLAIN}", f"SCENE={SCENE[0]}",
        "OPTIONS=" + " ".join(SCENE[1:]), "PARTS=3"]
# Waits for the job that joins.
SLURM = ["sh", "-c", 'said=$(sh "$0" "$@") && echo "$said" && join=${said##* } && while squeue -h -j "$join" -o %T | grep -q .; do '
         'sleep 0.2; done; cat "$2.join.log"; test -f "$2"', os.path.join(SAMPLES, "parts-slurm.sh"), "3", STACK, *SCENE]


def parts():
    return sorted(name for name in os.listdir(HOME) if "-of-" in name)


def is_same(what, path, code, said):
    check(code == 0 and os.path.exists(path) and bytes_of(path) == bytes_of(WHOLE) and not parts(),
          f"the same bytes, and no part is left: {what}", code, said, os.listdir(HOME))
    remove(path)


def kill_one():
    """Kills the process that draws part 2 of the stack."""
    for pid in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            words = bytes_of(f"/proc/{pid}/cmdline").decode(errors="replace").split("\0")
            if words[0] == OURS["SPECTRAL"] and {STACK + ".2-of-3.tif", PLAIN + ".2-of-3.tif"} & set(words):
                os.kill(int(pid), signal.SIGKILL)
                return True
    return False


def draws(name, words, path):
    is_same(f"parts by {name}", path, *run(words))
    process = start(words)
    killed = wait_until(kill_one)
    said = process.communicate(timeout=200)[0]
    check(killed, f"a part by {name} is killed", said)
    if name == "Make":  # gives up, and its user gives the command again
        check(process.returncode != 0 and not os.path.exists(path), "Make stops at a killed part", said)
        process.returncode, said = run(words)
    is_same(f"a killed part by {name}", path, process.returncode, said)


# ---- Slurm's daemons ----

CONFIGURATION = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
"""


def free_ports(n):
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(n)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


def wait_until(holds):
    for _ in range(2000):
        if holds():
            return True
        time.sleep(0.03)
    return False


@contextlib.contextmanager
def daemons():
    # A socket's path is short: at most 107 bytes.
    with tempfile.TemporaryDirectory(prefix="slurm.", dir="/tmp") as folder:
        with open(f"{folder}/munge.key", "wb") as file:
            os.fchmod(file.fileno(), 0o400)
            file.write(os.urandom(1024))
        for name in ("state", "spool"):
            os.mkdir(os.path.join(folder, name))
        OURS["SLURM_CONF"] = f"{folder}/slurm.conf"
        with open(OURS["SLURM_CONF"], "w", encoding="ascii") as file:
            file.write(CONFIGURATION.format(host=socket.gethostname().split(".")[0], ports=free_ports(2), folder=folder,
                                            user=subprocess.getoutput("id -un")))
        munge = [f"--{name}-file={folder}/munge.{name}" for name in ("key", "pid", "log", "seed")] + [f"--socket={folder}/munge.socket"]
        started = []
        try:
            for words in (["/usr/sbin/munged", "--foreground", "--force", *munge], ["/usr/sbin/slurmctld", "-D", "-c"],
                          ["/usr/sbin/slurmd", "-D", "-c"]):
                started.append(subprocess.Popen(words, env=OURS, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
                wait_until(lambda: os.path.exists(f"{folder}/munge.socket"))
            yield wait_until(lambda: run(["sinfo", "-h", "-o", "%T"])[1].strip() == "idle")
        finally:
            for daemon in reversed(started):
                daemon.terminate()
                daemon.wait()


shutil.rmtree(TMP, ignore_errors=True)
os.makedirs(TMP)
check(run([OURS["SPECTRAL"], "render", *SCENE, "-o", WHOLE, "-q"])[0] == 0, "one process draws the picture")
draws("GNU parallel", PARALLEL, STACK)
draws("Make", MAKE, PLAIN)
with daemons() as ready:
    check(ready, "Slurm's daemons are ready")
    draws("Slurm", SLURM, STACK)
done()

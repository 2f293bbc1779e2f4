#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile parallel make munge slurmctld slurmd slurm-client
"""Draws a picture in parts by GNU parallel, Make and Slurm, with the scripts that are installed as samples: the stack is that
of one process, byte for byte, also where parts are killed, and where two engines draw the same parts at once. Slurm's own
daemons run here, on loopback, and are ended at the end. With FULL, more numbers of parts and more kills. Prints TAP."""
import contextlib
import glob
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
from rendered import SPECTRAL, TMP, check, done

FULL = "FULL" in os.environ
SEED = int(os.environ.get("SEED", time.time()))
SAMPLES = os.path.abspath("data/samples")
HOME = os.path.abspath(TMP)
STACK = os.path.join(HOME, "the stack.tif")
PLAIN = os.path.join(HOME, "stack.tif")  # Make takes no blanks
WHOLE = os.path.join(HOME, "whole.tif")
SCENE = ["patches", "--size", "3000x1300", "--wavelengths", "450:650:100"]
OURS = {**os.environ, "SPECTRAL": os.path.abspath(SPECTRAL), "HOME": HOME}


def start(words, **environment):
    return subprocess.Popen(words, cwd=HOME, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            universal_newlines=True, env={**OURS, **environment})


def run(words, **environment):
    process = start(words, **environment)
    said = process.communicate(timeout=120)[0]
    return process.returncode, said


def read(path):
    with open(path, "rb") as file:
        return file.read()


def remove():
    for path in glob.glob(glob.escape(STACK) + "*") + glob.glob(PLAIN + "*"):
        os.remove(path)


def is_same(what, path, *said):
    check(os.path.exists(path) and read(path) == read(WHOLE), f"the same bytes: {what}", *said)


# ---- the engines: the words that draw n parts and join them, in the foreground ----

def parallel(n):
    return ["sh", os.path.join(SAMPLES, "parts-parallel.sh"), str(n), STACK, *SCENE]


def make(n):
    return ["make", "-s", "-f", os.path.join(SAMPLES, "parts.mk"), "-j2", f"STACK={PLAIN}", f"SCENE={SCENE[0]}",
            "OPTIONS=" + " ".join(SCENE[1:]), f"PARTS={n}"]


def slurm(n):
    """Waits for the job that joins."""
    submit = " ".join(f"'{word}'" for word in ["sh", os.path.join(SAMPLES, "parts-slurm.sh"), str(n), STACK, *SCENE])
    wait = 'while squeue -h -j "$join" -o %T | grep -q .; do sleep 0.2; done; cat "$1.join.log"; test -f "$1"'
    return ["sh", "-c", f'said=$({submit}) && echo "$said" && join=${{said##* }} && {wait}', "sh", STACK]


def draws(name, words, path):
    for n in (1, 2, 4, 7) if FULL else (4,):
        remove()
        code, said = run(words(n))
        check(code == 0, f"{name} draws {n} parts", code, said)
        is_same(f"{n} parts by {name}", path, said)


# ---- kills ----

def renders():
    """The processes that draw parts of these stacks."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            words = read(f"/proc/{pid}/cmdline").decode(errors="replace").split("\0")
            if "--part" in words and (STACK in words or PLAIN in words) and words[0] == OURS["SPECTRAL"]:
                found.append(int(pid))
    return found


def kill_one():
    with contextlib.suppress(ProcessLookupError, IndexError):
        os.kill(random.choice(renders()), signal.SIGKILL)
        return True
    return False


def killed(name, words, path, kills):
    """The engine may give up after some kills: its user gives the command again."""
    remove()
    left, runs = kills, 0
    while left > 0 or not os.path.exists(path):
        if os.path.exists(path):
            remove()
        process = start(words(4))
        runs += 1
        while process.poll() is None:
            time.sleep(random.uniform(0.02, 0.25))
            left -= left > 0 and kill_one()
        said = process.communicate()[0]
        if runs > 10 * kills + 10:
            break
    is_same(f"{kills} kills of parts by {name}, {runs} runs", path, said)


def at_once():
    """Two engines draw the same parts."""
    remove()
    processes = [start(parallel(4)), start(parallel(4))]
    said = [process.communicate(timeout=120)[0] for process in processes]
    check([process.returncode for process in processes] == [0, 0], "two engines draw the same parts at once", *said)
    is_same("two engines at once", STACK, *said)


def incomplete():
    """Make draws only the missing parts again; join names the missing part."""
    remove()
    run(make(4))
    before = {path: os.stat(path).st_mtime_ns for path in glob.glob(PLAIN + ".*.part")}
    os.remove(PLAIN)
    os.remove(PLAIN + ".2-of-4.part")
    code, said = run(make(4))
    check(code != 0 and "part 2 of 4 is missing" in said, "the join of a missing part fails", code, said)
    os.remove(PLAIN + ".2-of-4.drawn")
    code, said = run(make(4))
    after = {path: os.stat(path).st_mtime_ns for path in before}
    check(code == 0 and sum(before[path] != after[path] for path in before) == 1, "Make draws the missing part alone", code, said)
    is_same("a part that was missing", PLAIN, said)
    run(make(4) + ["clean"])
    check(glob.glob(PLAIN + "*") == [PLAIN], "make clean removes the parts and leaves the stack", glob.glob(PLAIN + "*"))


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
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
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
    sockets = [socket.socket() for _ in range(n)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


@contextlib.contextmanager
def daemons():
    # A socket's path is short: at most 107 bytes.
    with tempfile.TemporaryDirectory(prefix="slurm.", dir="/tmp") as folder:
        paths = {name: os.path.join(folder, "munge." + name) for name in ("key", "socket", "pid", "log", "seed")}
        with open(paths["key"], "wb") as file:
            os.fchmod(file.fileno(), 0o400)
            file.write(os.urandom(1024))
        for name in ("state", "spool"):
            os.mkdir(os.path.join(folder, name))
        configuration = os.path.join(folder, "slurm.conf")
        with open(configuration, "w", encoding="ascii") as file:
            file.write(CONFIGURATION.format(host=socket.gethostname().split(".")[0], ports=free_ports(2), folder=folder,
                                            user=subprocess.getoutput("id -un")))
        OURS["SLURM_CONF"] = configuration
        try:
            subprocess.run(["/usr/sbin/munged", "--force", *(f"--{option}={paths[name]}" for option, name in
                           (("key-file", "key"), ("socket", "socket"), ("pid-file", "pid"), ("log-file", "log"), ("seed-file", "seed")))],
                           check=True, stderr=subprocess.DEVNULL)
            subprocess.run(["/usr/sbin/slurmctld", "-c"], check=True, env=OURS)
            subprocess.run(["/usr/sbin/slurmd", "-c"], check=True, env=OURS)
            yield wait_for_node()
        finally:
            for path in ("slurmd.pid", "slurmctld.pid", "munge.pid"):
                stop(os.path.join(folder, path))


def wait_for_node():
    for _ in range(200):
        said = run(["sinfo", "-h", "-o", "%T"])[1]
        if said.strip() == "idle":
            return said
        time.sleep(0.1)
    return said


def stop(path):
    """Ends the daemon whose number the file holds, and waits until it has gone."""
    with contextlib.suppress(OSError, ValueError):
        pid = int(read(path))
        os.kill(pid, signal.SIGTERM)
        for _ in range(100):
            os.kill(pid, 0)
            time.sleep(0.05)
        os.kill(pid, signal.SIGKILL)


random.seed(SEED)
shutil.rmtree(TMP, ignore_errors=True)
os.makedirs(TMP)
print(f"# SEED={SEED}")
check(run([OURS["SPECTRAL"], "render", *SCENE, "-o", WHOLE, "-q"])[0] == 0, "one process draws the picture")
KILLS = 20 if FULL else 3
draws("GNU parallel", parallel, STACK)
draws("Make", make, PLAIN)
killed("GNU parallel", parallel, STACK, KILLS)
killed("Make", make, PLAIN, KILLS)
at_once()
incomplete()
with daemons() as state:
    check(state.strip() == "idle", "Slurm's daemons are ready", state)
    draws("Slurm", slurm, STACK)
    killed("Slurm", slurm, STACK, KILLS)
    remove()
    jobs = [start(slurm(2)), start(slurm(2))]
    words = [job.communicate(timeout=120)[0] for job in jobs]
    is_same("two arrays of Slurm at once", STACK, *words)
done()

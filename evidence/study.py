"""What the questions share: jobs on all cores or on a cluster, kept as they come, and what an answer leaves.

A job is a function of a module and its argument, which pickles and which JSON can write but for scenes. Its result is kept in
runs.jsonl under a key that has the library of the kernel, the function's name and the argument, so that an answer that was
stopped goes on where it was.
"""

import hashlib
import json
import os
import pathlib
import platform
import shutil
import sys
import time

import fabric_kernel
import matplotlib
from fabric_kernel import Scene, drawing, ensembles
from fabric_kernel.about import scene_hash
from fabric_kernel.files import csv_of, written

from . import short

# A user's own settings of plots stay as they are.
matplotlib.rcParams.update(drawing.STYLE)

TOP = pathlib.Path(__file__).parent.parent
FULL, QUICK, SMOKE = "full", "quick", "smoke"
# What seconds are measured by: the processor time of a thread, in which other programs do not count.
clock = time.thread_time


def machine():
    """Name of the processor."""
    try:
        names = [
            line.split(":")[1].strip()
            for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines()
            if line.startswith("model name")
        ]
    except OSError:
        names = []
    return f"{names[0] if names else platform.machine()} ({os.cpu_count()} cores)"


def key_of(work, job):
    everything = [ensembles.BUILD, f"{work.__module__}.{work.__qualname__}", job]
    return hashlib.sha256(json.dumps(everything, sort_keys=True, default=Scene.to_dict).encode()).hexdigest()[:32]


def scenes_in(job):
    parts = job.values() if isinstance(job, dict) else job if isinstance(job, (list, tuple)) else []
    return [job] if isinstance(job, Scene) else [scene for part in parts for scene in scenes_in(part)]


class Study:
    """One question under way. effort: FULL, QUICK or SMOKE; docs: the folder of documents that gets tables and pictures, or None;
    source: the folder in which `fabric` has written numbers, for questions that read them."""

    def __init__(self, name, effort=FULL, out=TOP / "target/evidence", docs=None, on=None, source=None):
        self.source = source or TOP / "target/fabric" / name
        self.name, self.effort, self.out, self.folder, self.docs, self.on = name, effort, out, out / name, docs, on
        self.folder.mkdir(parents=True, exist_ok=True)
        self.scenes = {}
        self.kept = self.folder / "runs.jsonl"
        if effort == SMOKE:
            self.kept.unlink(missing_ok=True)  # A check that takes kept runs checks nothing.

    @property
    def command(self):
        return f"python -m evidence {self.name}" + ("" if self.effort == FULL else f" --{self.effort}")

    def of(self, full, quick, smoke):
        """What belongs to the effort."""
        return {FULL: full, QUICK: quick, SMOKE: smoke}[self.effort]

    def each(self, work, jobs, name=None):
        """What `work` gives for each job, in their order; those that take long go first."""
        keys = [key_of(work, job) for job in jobs]
        for job in jobs:
            self.scenes |= {scene_hash(scene): None for scene in scenes_in(job)}
        if not sys.stderr.isatty():
            print(f"{name or self.name}: {len(set(keys))} jobs ...", file=sys.stderr, flush=True)
        done = ensembles.each(work, dict(zip(keys, jobs)), keep=self.kept, on=self.on, name=name or self.name)
        return [done[key] for key in keys]

    def write(self, name, rows):
        """NAME.csv, and NAME.json with what made it."""
        heading = list(rows[0]) if rows else []
        written(
            self.folder / f"{name}.csv",
            csv_of(heading, [["" if row[key] != row[key] else row[key] for key in heading] for row in rows]),
        )
        self.note(name, {})

    def note(self, name, numbers):
        """NAME.json: numbers, and the command, version, library, machine and scenes that they come from."""
        origin = {"command": self.command, "version": fabric_kernel.VERSION, "library": ensembles.BUILD, "machine": machine()}
        origin |= {"scenes": list(self.scenes)}
        (self.folder / f"{name}.json").write_text(json.dumps(numbers | origin, indent=1) + "\n")

    def table(self, name, title, text):
        """Prints a table and writes it into NAME.md of the folder; a page of docs/tables, too."""
        if "CPU s" in text:
            text = (
                f"CPU seconds are those of one thread on {machine()}; everything else is the same to the bit on every machine.\n"
                f"\n{text}"
            )
        print(f"\n{title}\n\n{text}")
        (self.folder / f"{name}.md").write_text(f"# {title}\n\nMade by `{self.command}`.\n\n{text.rstrip()}\n")
        if self.docs and name in short.SHORT:
            short.write(self.docs, name, title, f"{self.command} --docs docs", text)

    def picture(self, file, name):
        """Copies a picture of the folder to docs/images."""
        if self.docs and (self.folder / file).exists():
            (self.docs / "images").mkdir(parents=True, exist_ok=True)
            shutil.copy(self.folder / file, self.docs / "images" / name)

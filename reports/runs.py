"""The runs of the paper study: what `fabric-study paper` has written, and how numbers are read off a run."""

import json
import math

import numpy

from evidence.statistics import Estimate, mean

CORNERS, TWO_SIDES, FOUR_SIDES = "corners", "two sides", "four sides"
ATTACHMENTS = [TWO_SIDES, FOUR_SIDES, CORNERS]
STOCHASTIC, UNIFORM = "stochastic", "uniform"
SYMMETRIC, WOVEN = "uniform, mirror-symmetric", "stochastic, one draw per yarn"
SMALL, LARGE = "3 in, sphere", "10 in, cylinder"


class Run:
    """One line of runs.jsonl. Energies in J, times in s."""

    def __init__(self, record):
        self.__dict__.update(record)
        keys = ("t", "lost", "kinetic", "strain", "dissipated", "loss")
        self.history = {key: numpy.array([sample[key] for sample in record["history"]]) for key in keys}
        self.torn = sorted(time for time in record["torn"] if time is not None)

    def sampled(self, key, time):
        """Between samples; the last one if the run was over before."""
        return float(numpy.interp(time, self.history["t"], self.history[key]))

    def at_detached(self):
        """Energy absorbed when the last contact lost its supports; at the end if it never did."""
        return self.detached[1] if self.detached else self.absorbed

    def dissipated_at_detached(self):
        return self.sampled("dissipated", self.detached[0] if self.detached else math.inf)

    def yarn_work_at_detached(self):
        """Strain energy and energy dissipated by rupture."""
        return self.dissipated_at_detached() + self.sampled("strain", self.detached[0] if self.detached else math.inf)

    def dissipated_at_end(self):
        return float(self.history["dissipated"][-1])

    def largest_yarn_work(self):
        return float((self.history["strain"] + self.history["dissipated"]).max())

    def absorbed_at(self, time):
        """At the end if the run was over before."""
        return self.sampled("lost", time) if time <= self.history["t"][-1] else self.absorbed

    def left(self):
        """Kinetic energy that the projectile keeps."""
        return self.energy - self.absorbed

    def share_at_attachments(self):
        """Part of the failed segments that lie near an attachment; NaN if none failed."""
        return self.failed_at[0] / self.failed if self.failed else math.nan

    def share_at_centre(self):
        return self.failed_at[1] / self.failed if self.failed else math.nan

    def residual(self):
        """Residual velocity, m/s: 0 if the projectile was arrested (it is then pushed back)."""
        return 0.0 if self.arrested else self.residual_velocity


class Runs:
    """All that was computed."""

    def __init__(self, folder):
        index = json.loads((folder / "paper.json").read_text())
        self.__dict__.update(index)
        records = {}
        for line in open(folder / "runs.jsonl"):
            try:
                record = json.loads(line)
            except ValueError:
                continue  # A line that was cut off.
            records[record["key"]] = record
        wanted = {key for point in self.points for key in point["keys"]}
        known = {key: Run(records[key]) for key in sorted(wanted)}
        for point in self.points:
            point["runs"] = [known[key] for key in point["keys"]]
        self.all = list(known.values())
        # The pictures are of one run of an ensemble: the longest list counts.
        self.by_name = {}
        for point in sorted(self.points, key=lambda point: len(point["runs"])):
            self.by_name[point["sheet"], point["attachment"], point["washer"], point["yarn"], round(point["impact_j"], 9)] = point["runs"]

    def wants(self, *figures):
        return not self.figures or any(figure in self.figures for figure in figures)

    def of(self, attachment, yarn, energy, washer=None, sheet=SMALL):
        """The runs of an ensemble; none if it was not computed."""
        return self.by_name.get((sheet, attachment, washer or self.washers[0], yarn, round(energy, 9)), [])

    def values(self, attachment, yarn, energy, value):
        return [value(run) for run in self.of(attachment, yarn, energy)]

    def mean_of(self, attachment, yarn, energy, value):
        """Mean of a number of the runs; those for which it is not defined are left out."""
        return Estimate.mean([x for x in self.values(attachment, yarn, energy, value) if math.isfinite(x)])

    def energies_among(self, wanted):
        return [energy for energy in self.energies if energy in wanted]

    def goes_through(self, attachment, yarn, energy):
        """Whether more than half of the runs are not arrested."""
        return mean(self.values(attachment, yarn, energy, lambda run: run.arrested)) < 0.5

    def uncapped(self, *ensembles):
        """Energies at which no run of these ensembles is arrested: there nothing is capped."""
        free = lambda energy: all(
            self.of(*ensemble, energy) and not any(run.arrested for run in self.of(*ensemble, energy)) for ensemble in ensembles
        )
        return [energy for energy in self.energies if free(energy)]

    def lacking(self):
        return f"Of {len(self.all) + self.missing} runs {self.missing} have not been done; points without runs are left out."

    def scope(self):
        """What the claims do not cover, in words."""
        parts = [f"Only what is read off figures {', '.join(self.figures)}."] if self.figures else []
        parts += [self.lacking()] if self.missing else []
        return " ".join([*parts, self.left_out or "Ten runs a point on the 3 in sheet."])


def number(value):
    """2.5, 10: without needless zeros."""
    return f"{value:g}"

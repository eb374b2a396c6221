"""The Pareto front of cost and error, and what to take for a wanted error.

An error below the resolution of the means (two standard errors of their difference) is no error that anyone has seen: it counts
as the resolution. The deviation behind it is pooled over the full network's accepted steps with velocity Verlet, because a
deviation of ten runs is itself uncertain by a quarter.

A setting is on the front of a measure if no other one costs no more and errs no more, with one of the two less. It is on the
front of all measures if no other one is at least as good in all of them and in cost, and better in one. Steps that the kernel
refuses, and the reference, which is the first setting, do not compete.
"""

import math

from .statistics import mean

MEASURES = ["absorbed", "velocity", "force", "exit", "failed", "residual"]
WORDS = dict(
    zip(MEASURES, ["absorbed energy", "residual velocity", "peak force", "exit time", "failed segments", "energy residual"])
)
INITIALS = dict(zip(MEASURES, "AVPXFE"))
# Costs, and whether only settings on the full network are compared.
FRONTS = [("node_steps", False), ("cpu_seconds", False), ("node_steps", True), ("cpu_seconds", True)]
WANTED = [0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001]


class Judged:
    """All settings of a case, rows of impact.csv, with their errors relative to the first; of the energy residual, whose true
    value is 0, its size over the kinetic energy at the start."""

    def __init__(self, rows):
        self.rows, reference = rows, rows[0]
        plain = [row for row in rows if row["accepted"] and row["plain"]]
        self.floor = {}
        for name in MEASURES:
            scale = 100.0 if name == "residual" else abs(reference[name])
            self.floor[name] = math.sqrt(mean([row[name + "_deviation"] ** 2 for row in plain])) / scale
        for row in rows:
            row["reference"] = row is reference
            row["error"], row["resolution"] = {}, {}
            for name in MEASURES:
                if name == "residual":
                    # The spread differs from step to step: each row has its own.
                    row["error"][name] = 0.01 * abs(row[name])
                    row["resolution"][name] = (
                        0.02 * row["residual_deviation"] / math.sqrt(row["runs"]) if row["runs"] else math.nan
                    )
                else:
                    row["error"][name] = abs(row[name] / reference[name] - 1)
                    runs = 1 / row["runs"] + 1 / reference["runs"] if row["runs"] else math.nan
                    row["resolution"][name] = 2 * self.floor[name] * math.sqrt(runs)
        self.resolution = reference["resolution"]
        for row in rows:
            row["fronts"] = [self.front(row, *front) for front in FRONTS]

    def front(self, row, cost, full_only):
        """The measures on whose front a row is, and "all"."""
        among = [other for other in self.rows if competes(other) and (other["full_network"] or not full_only)]
        if row not in among:
            return []
        beaten = lambda measures: any(beats(other, row, cost, measures) for other in among if other is not row)
        return [name for name in MEASURES if not beaten([name])] + ["all"] * (not beaten(MEASURES))


def competes(row):
    return not row["reference"] and row["accepted"] and row["runs"] > 0


def beats(other, row, cost, measures):
    """At least as good in cost and these measures, and better in one."""
    counted = lambda row, name: max(row["error"][name], row["resolution"][name])
    pairs = [(other[cost], row[cost])] + [(counted(other, name), counted(row, name)) for name in measures]
    return all(a <= b for a, b in pairs) and any(a < b for a, b in pairs)


def marks(row, front):
    """Initials of the measures on whose front it is; * if on the front of all."""
    if row["reference"]:
        return "reference"
    found = row["fronts"][front]
    return ("".join(INITIALS[name] for name in found if name != "all") + " *" * ("all" in found)).strip()


def verdict(judged):
    """Says whether the default is on the fronts."""
    default = [row for row in judged.rows if row["default"]]
    if not default:
        return "The default was not run."
    parts = []
    for words, front in (
        ("among the settings on the full network, by node-steps", 2),
        ("by seconds", 3),
        ("among all settings, by node-steps", 0),
        ("by seconds", 1),
    ):
        found = default[0]["fronts"][front]
        names = ", ".join(WORDS[name] for name in found if name != "all") or "none"
        parts.append(
            f"{words}: {'on' if 'all' in found else 'NOT on'} the front of all measures together, and on that of {names}"
        )
    return f"The default (Verlet, 0.4 dt_crit) is, {'; '.join(parts)}."


def choice(judged):
    """For each wanted error of the ensemble mean of the absorbed energy the cheapest (error, row, runs, expected error), or None.
    The error of a mean of n runs is taken as sqrt(error^2 + floor^2/n), with an error that cannot be distinguished from 0 counted
    as one standard error of the difference."""
    found, spread = [], judged.floor["absorbed"]
    for wanted in WANTED:
        best = None
        for row in filter(competes, judged.rows):
            own = max(row["error"]["absorbed"], 0.5 * row["resolution"]["absorbed"])
            if own < wanted:
                runs = max(1, math.ceil(spread**2 / (wanted**2 - own**2)))
                if best is None or runs * row["node_steps"] < best[0]:
                    best = runs * row["node_steps"], row, runs, math.sqrt(own**2 + spread**2 / runs)
        found.append((wanted, best and best[1:]))
    return found

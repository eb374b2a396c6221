"""The paper's question with attachments that slip: the energy absorbed over the impact energy for its three attachments (Figs 14
to 17); and the ballistic limit of one ply over the force at which its clamps let yarn slip.

Limit: Kevlar KM2 S706, 101 mm, four sides, sphere of 0.69 g; of each hit by bisection.
Energies: the 3 in sheet of stochastic yarn and the sphere of paper_runs.py, to the arrest or the exit. A yarn end slips at a part
of the force at which the yarn breaks, in a clamp without end; under a washer each yarn shares that force among its nodes, of
which the first slip sooner.
slack_balance is on, because torn cloth that flaps gains energy without it.
Limits: washers do not fail as a whole; an endless clamp feeds cloth that no clamp has, most of it in runs that end in an arrest.
"""

import itertools

from fabric_kernel import Scene, Simulation, drawing

from . import page
from .hits import BISECTION, limit
from .paper_runs import ATTACHMENTS, SMALL, STOCHASTIC, Point
from .statistics import Estimate
from .study import FULL, TOP

HOLDS, ENERGIES, RUNS = (1.0, 0.4, 0.15), (20.0, 80.0, 160.0, 320.0), 3
# Force at which a yarn end slips over the yarn's strength, 0: held without limit; first velocity of a search, m/s; time, s.
SLIPS, HITS, GUESS, LONGEST = (0.0, 1.0, 0.7, 0.55, 0.4, 0.3, 0.2, 0.15, 0.1), 6, 130.0, 2e-3


def measured(job):
    """A run, in parts of the impact energy: what the fabric absorbed, what the clamps took of it, and the residual of the
    balance."""
    scene, most = job
    simulation = Simulation(scene, warns=False)
    impact = simulation.energy()["projectile_kinetic"]
    simulation.run(("arrested", "exited"), most)
    energy = simulation.energy()
    parts = {"absorbed": energy["contact_work"], "clamps": energy["attachment"], "residual": energy["residual"]}
    ends = simulation.outcomes().keys() & {"arrested", "exited"}
    return {name: value / impact for name, value in parts.items()} | {"arrested": "arrested" in ends, "late": not ends}


def limit_of(job):
    """The ballistic limit of a hit, m/s."""
    scene, hit = job
    return limit(scene, GUESS, hit, LONGEST)


def limits(study):
    """The ballistic limit over the hold: the plot, and a table."""
    slips, hits = study.of((SLIPS, HITS), (SLIPS[::2], 3), ((0.0, 0.4), 2))
    ply = Scene.read(TOP / "examples/scenes/kevlar_km2_s706.toml")
    scenes = [ply.replace({"attachment.hold": f"{slip} of the yarn"}) if slip else ply for slip in slips]
    found = study.each(limit_of, [(scene, hit) for scene in scenes for hit in range(hits)], "clamps: limit")
    means = [Estimate.mean(found[k * hits : (k + 1) * hits], BISECTION) for k in range(len(slips))]
    study.write(
        "clamps_limit",
        [{"hold": slip, "limit m/s": mean.value, "low": mean.low, "high": mean.high} for slip, mean in zip(slips, means)],
    )
    points = [
        drawing.Series(
            "ends that slip",
            [(s, one.value) for s, one in zip(slips[1:], means[1:])],
            "marked",
            [(one.low, one.high) for one in means[1:]],
        )
    ]
    drawing.draw(
        study.folder / "clamps_limit.svg",
        "Ballistic limit of one ply over the hold of its clamps",
        "force at which a yarn end slips / strength of the yarn",
        "ballistic limit (m/s)",
        points,
        "from zero",
        levels=[("ends that cannot slip", means[0].value)],
    )
    study.picture("clamps_limit.svg", "clamps_limit.svg")
    return page.markdown(
        ["slips at", "limit, m/s"], [[f"{slip:g}" if slip else "never", mean.text(1)] for slip, mean in zip(slips, means)]
    )


def order(means):
    """The attachments by what they absorb, the most first; "~" where two intervals overlap."""
    names = sorted(means, key=lambda name: -means[name].value)
    signs = [">" if means[more].low > means[less].high else "~" for more, less in itertools.pairwise(names)]
    return "".join(name.split()[0] + sign for name, sign in zip(names, [*signs, ""]))


def answer(study):
    energies, runs = study.of((ENERGIES, RUNS), (ENERGIES[::2], 2), (ENERGIES[:1], 2))
    labels, jobs = [], []
    for hold, energy, kind in itertools.product(HOLDS, energies, ATTACHMENTS):
        point = Point(SMALL, kind, STOCHASTIC, energy)
        labels += [{"hold": hold, "impact J": energy, "attachment": kind, "run": k} for k in range(runs)]
        changes = {"attachment.hold": f"{hold} of the yarn", "slack_balance": True}
        jobs += [(point.scene(study.effort, k).replace(changes), point.steps(study.effort)) for k in range(runs)]
    rows = [label | found for label, found in zip(labels, study.each(measured, jobs))]
    study.write("clamps", rows)
    figure, plots = drawing.new(5.6, 3.0, len(HOLDS), sharey=True)
    lines = []
    for axes, hold in zip(plots, HOLDS):
        drawn = {kind: [] for kind in ATTACHMENTS}
        for energy in energies:
            own = {
                kind: [row for row in rows if (row["hold"], row["impact J"], row["attachment"]) == (hold, energy, kind)]
                for kind in ATTACHMENTS
            }
            means = {kind: Estimate.mean([row["absorbed"] for row in ends]) for kind, ends in own.items()}
            lines.append([f"{hold:g}", f"{energy:g}", *(one.text(2) for one in means.values()), order(means)])
            for kind in ATTACHMENTS:
                drawn[kind].append(means[kind])
        for kind, found in drawn.items():
            bars = [[max(one.value - one.low, 0.0) for one in found], [max(one.high - one.value, 0.0) for one in found]]
            axes.errorbar(energies, [one.value for one in found], bars, label=kind, marker="o", capsize=2)
        axes.set(xscale="log", xlabel="impact energy (J)")
        axes.set_title(f"hold {hold:g}", fontsize=10)
        axes.set_xticks(energies, [f"{energy:g}" for energy in energies])
        axes.set_xticks([], minor=True)
    plots[0].set(ylabel="absorbed over impact energy", ylim=(0.0, 1.05))
    figure.suptitle("Clamps that slip; hold: over the strength of the yarn", fontsize=11)
    drawing.below(figure, plots[0])
    drawing.save(figure, study.folder / "clamps.svg")
    study.picture("clamps.svg", "clamps.svg")
    worst = max(abs(row["residual"]) for row in rows)
    late, took = (
        sum(row["late"] for row in rows),
        {hold: [row["clamps"] for row in rows if row["hold"] == hold] for hold in HOLDS},
    )
    text = f"{NOTES.format(runs=runs)}\n{page.markdown(['slips at', 'impact, J', *ATTACHMENTS, 'order'], lines)}"
    text += (
        "\nThe clamps took "
        + ", ".join(f"{min(parts):.2f} to {max(parts):.2f} ({hold:g})" for hold, parts in took.items())
        + " of the impact energy."
    )
    text += (
        f"\nLargest residual {100 * worst:.2f} % of the impact energy; {late} of {len(rows)} runs ended by their step limit.\n"
    )
    text += "\n## Ballistic limit of one ply of Kevlar KM2\n\nMean of the limits of hits with its 95 % interval.\n\n" + limits(
        study
    )
    study.table("clamps", "The paper's attachments when clamps slip", text)
    return worst < 0.02 or study.effort != FULL


NOTES = """Slips at: force at which a yarn end slips, over that at which the yarn breaks; a clamp is without end.
Of each attachment: absorbed over impact energy, mean of {runs} runs with its 95 % interval.
Order: the most first; ~ where two intervals overlap.
"""

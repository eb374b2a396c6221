"""The map of time step against impact velocity, and the table of extreme scenes, from what `fabric stability` has written."""

import math

from . import page, plot

LIMIT = 0.5  # Steps above this part of dt_crit are refused.
CLASSES = [(0.01, "#a8d8b9", "sound: below 1 %"), (0.1, "#f6d678", "energy creep: 1 to 10 %"), (math.inf, "#eb8c6e", "unusable: above 10 %")]
SIGNS = {"arrested": "arrested", "exited": "through"}


def answer(study):
    rows = page.rows_of(study.source / "stability.csv")
    cells = page.rows_of(study.source / "map.csv", needed=False)
    for cell in cells:
        for key in ("fraction", "speed", "energy", "failed_segments"):
            cell[key] = float(cell[key])
        cell["class"] = next(number for number, (most, _, _) in enumerate(CLASSES) if abs(cell["energy"]) < most or most == math.inf)
    missed = [row for row in rows if row["pass"] != "true"]
    text = (in_words(cells) + "\n\n" if cells else "") + NOTES + f"\n\n{len(rows)} rows, {len(missed)} missed.\n"
    for theme in dict.fromkeys(row["theme"] for row in rows):
        text += f"\n## {theme}\n\n" + table([row for row in rows if row["theme"] == theme])
    study.table("stability", "Extreme scenes, and what happened", text, "fabric stability` and `python -m evidence stability --docs docs")
    if cells:
        draw(cells, study.folder / "map.svg")
        study.picture("map.svg", "stability_map.svg")


NOTES = (
    "A row passes only if the expected thing happened. Energy: what the balance does not close by, over the kinetic energy at the start (over "
    "the strain energy of a sheet that starts taut and at rest; in J where both are 0). Momentum: likewise, over the momentum at the start (N s "
    'where that is 0). Penetration: the deepest of any node at any time. "Sound": energy within 1 %, momentum within 1e-9, every contact solve '
    "converged. FMU: what `tests/fmi/test_stability.py` requires of both FMUs with the same parameters: the same refusal in the same words, or the "
    "same bits; empty where an FMU has no parameter for it. FMUs refuse every step above 0.5 dt_crit. \"N\" is the number of nodes along each side."
)


def residual(text):
    """Two figures; nothing where nothing ran."""
    return "" if text == "" else "0" if float(text) == 0 else page.power(float(text), 1)


def table(rows):
    heading = ["case", "expected", "happened", "energy", "momentum", "penetration, m", "FMU", ""]
    return page.markdown(heading, [
        [row["case"], row["expected"], row["happened"], *(residual(row[key]) for key in ("energy_residual", "momentum_residual", "worst_penetration_m")),
         row["fmu"], "ok" if row["pass"] == "true" else "**missed**"] for row in rows
    ], 3)


def in_words(cells):
    """The worst residual of each accepted step, and of the refused ones."""
    count = lambda allowed, *classes: sum((cell["fraction"] <= LIMIT) == allowed and cell["class"] in classes for cell in cells)
    worst = lambda at: 100 * max((abs(cell["energy"]) for cell in cells if cell["fraction"] == at), default=math.nan)
    steps = ", ".join(f"{worst(at):.2f} % at {at}" for at in (0.1, 0.2, 0.3, 0.4, 0.5) if not math.isnan(worst(at)))
    return (
        f"Of the {count(True, 0, 1, 2)} runs with a step that is accepted {count(True, 0)} are sound and {count(True, 1, 2)} creep ({count(True, 2)} above 10 %); "
        f"the worst of each step: {steps}. Of the {count(False, 0, 1, 2)} runs beyond it {count(False, 0)} are sound, {count(False, 1)} creep and "
        f"{count(False, 2)} are unusable."
    )


def percent(part):
    """About two figures."""
    value, size = 100 * part, abs(100 * part)
    if not math.isfinite(size):
        return "fault"
    if size < 0.01:
        return "0.00"
    return f"{value:+.2f}" if size < 1 else f"{value:+.1f}" if size < 10 else f"{value:+.0f}" if size < 1e5 else "+" * (value > 0) + page.power(value, 0)


def draw(cells, path):
    """A cell for each run, coloured by class, with its residual in percent; refused steps are hatched."""
    columns, rows = (sorted({cell[key] for cell in cells}) for key in ("fraction", "speed"))
    figure, axis = plot.new(1.6 + 0.72 * len(columns), 1.9 + 0.48 * len(rows))
    patches = plot.matplotlib.patches
    for cell in cells:
        # Fast ones at the top.
        x, y = columns.index(cell["fraction"]), rows.index(cell["speed"])
        axis.add_patch(patches.Rectangle((x, y), 1, 1, facecolor=CLASSES[cell["class"]][1], edgecolor="white", linewidth=2))
        sign = SIGNS.get(cell["outcome"], "")
        if not sign or (sign == "arrested" and cell["failed_segments"]):
            sign = "torn" if cell["failed_segments"] else "whole"
        axis.text(x + 0.5, y + 0.63, percent(cell["energy"]), ha="center", va="center", fontsize=9)
        axis.text(x + 0.5, y + 0.28, sign, ha="center", va="center", fontsize=7)
    allowed = sum(fraction <= LIMIT for fraction in columns)
    refused = (allowed, 0), len(columns) - allowed, len(rows)
    axis.add_patch(patches.Rectangle(*refused, fill=False, hatch="///", edgecolor="white", linewidth=0, alpha=0.6))
    axis.axvline(allowed, color="black", linewidth=2.5)
    axis.grid(False)
    axis.set(xlim=(0, len(columns)), ylim=(0, len(rows)), xlabel="dt / dt_crit (refused right of the line)", ylabel="impact velocity (m/s)")
    axis.set_xticks([k + 0.5 for k in range(len(columns))], [f"{fraction:g}" for fraction in columns])
    axis.set_yticks([k + 0.5 for k in range(len(rows))], [f"{speed:g}" for speed in rows])
    axis.tick_params(length=0)
    for spine in axis.spines.values():
        spine.set_visible(False)
    axis.set_title(
        "Energy that the time step creates: residual of the balance in % of the impact energy\n41 x 41 nodes, four sides held, 8.4 g sphere, 150 µs. "
        "through: the sphere has left; arrested: stopped,\nno yarn failed; whole: under way, no yarn failed; torn: under way or stopped, yarns failed",
        fontsize=9, loc="left",
    )
    keys = [patches.Patch(facecolor=colour, label=words) for _, colour, words in CLASSES]
    figure.legend(handles=keys, loc="outside lower center", ncols=3)
    plot.save(figure, path)

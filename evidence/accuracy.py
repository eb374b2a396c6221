"""Error against run time, as `fabric accuracy` finds it: what keeps 5, 2 and 1 % of the absorbed energy of the presets, six whole
impacts of the preset sphere (cases.py), and how often an error that was asked for is kept (kept.py)."""

from fabric_kernel import Scene, drawing, plot
from fabric_kernel.about import scene_hash
from fabric_kernel.accuracy import BARS, accuracy

from . import kept
from .cases import CASES, scene_of
from .page import markdown
from .study import SMOKE, machine

ONE, HALF = BARS[:3], BARS[:4]
"""Networks down to the scene's own, and down to bars half as long."""
PRESETS = {"sheet_3in_sphere": HALF, "sheet_10in_cylinder": ONE, "turbine_disc_sector": BARS[:2], "ring_40in": BARS[:2]}
"""Networks of each; finer ones take minutes."""
ERRORS = (5.0, 2.0)


def answer(study):
    presets(study)
    impacts(study)
    kept.answer(study)


def found(study, name, scene, shots, bars, **how):
    study.scenes[scene_hash(scene)] = None
    return accuracy(scene, shots=shots, bars=bars, budget=1e9, keep=study.kept, on=study.on, title=name, **how)


def presets(study):
    """Table of what keeps an error in the presets."""
    rows = []
    for preset, bars in list(PRESETS.items())[: study.of(4, 2, 1)]:
        cells = []
        for error in ERRORS:
            try:
                given = found(study, preset, Scene(preset), study.of(8, 4, 2), study.of(bars, bars, ONE[:2]), error=error)
                one = given.choices[0]
                why = f"none: {one.why}"
                cells.append(f"{one.row.name()}: {one.runs} shots, {one.runs * one.row.seconds:.2g} s" if one.row else why)
            except ValueError as refused:  # Too few networks can be run.
                cells.append(f"none: {str(refused).split(': ', 1)[1].split('. ')[0]}")
        rows.append([f"`{preset}`", *cells])
    heading = ["preset", *(f"absorbed energy within {error:g} %: bars, step" for error in ERRORS)]
    study.table("accuracy_presets", "What keeps an error in the presets", f"{legend()}\n\n{markdown(heading, rows, 3)}")


def legend():
    return (
        "Bars: length over the scene's; step: over the largest stable one. Errors are those of the mean against the finest "
        f"network, with 95 % intervals. Seconds are processor time on {machine()}."
    )


def impacts(study):
    """Tables and picture of the six cases."""
    judged, text = {}, f"{legend()}\n\n"
    for case in CASES[: study.of(6, 2, 1)]:
        scene = scene_of(case, study.effort == SMOKE)
        bars = ONE if case.kind == "four_corners" else HALF  # Torn sheets at corners fly long.
        one = found(study, f"40 J, {case.name}", scene, study.of(8, 4, 2), study.of(bars, ONE, ONE[:2]), as_aimed=True)
        judged[case.name] = one
        lines = "".join(f"- {line}\n" for line in one.answer())
        text += f"## 40 J, {case.name}\n\n{markdown(one.heading(), one.table(), 1)}\n{lines}\n"
    study.table("accuracy_impact", "Whole impacts", text)
    rows = (len(judged) + 1) // 2
    figure, panels = drawing.new(5.6, 0.7 + 1.9 * rows, min(len(judged), 2), rows, sharex=True, sharey=True, squeeze=False)
    for axis, (name, one) in zip(panels.flat, judged.items()):
        plot.accuracy_on(axis, one, named=False)
        axis.set_title(name, fontsize=10)
    for axis in panels[-1]:
        axis.set_xlabel("processor time of a shot (s)")
    figure.supylabel("error of the mean absorbed energy (%)", fontsize=10)
    drawing.below(figure, panels.flat[0])
    drawing.save(figure, study.folder / "front.svg")
    study.picture("front.svg", "front.svg")

"""One impact from start to end: its row of a table, and its history."""

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import scipy  # Its parts are loaded where they are used.

from ._kernel import Failed, Scene, Simulation, parameters
from .notes import Note

if TYPE_CHECKING:
    import pandas

UNTIL = ("arrested", "exited", "passed", "rebounded")
STOPPED = ("arrested", "rebounded")
"""Outcomes that end a run, if nothing else is asked for: those of `fabric run`. With "detached" besides, a run ends when the
contact is with torn cloth only, which is quicker, but that cloth may still slow the projectile."""
DECIDED = (*UNTIL, "through")
"""Outcomes that end a run once it is decided whether the fabric stops the projectile: that of `fabric v50` and `fabric
fragments`. After
"through" the speed may still change a little (docs/v50.md, "Method")."""
STEPS = 100_000
"""Most steps of a run, if nothing else is asked for."""
SAMPLE = 128
"""Steps between two looks at the deflection of a run, a few percent of its cost."""
MOST_UNCONVERGED = 0.01
"""Contact solves that do not converge are harmless below this share of the steps (docs/accuracy.md)."""
MOST_GAINED = 0.01
"""Largest part of the impact energy by which an energy balance may be open (docs/model.md, "Slack and taut")."""
MOST_FROM_NOTHING = 0.001
"""Largest part of the impact energy that contact may have given from nothing, as the kernel's MOST_GAINED."""
PARTS = ("fabric_kinetic", "strain", "dissipated", "viscous", "friction", "ply_loss", "casing_loss", "attachment", "contact_loss")
"""Parts of the energy balance, J, without those of the projectile and the supports."""
LOST = ("dissipated", "viscous", "friction", "ply_loss", "casing_loss", "attachment", "contact_loss")
"""Those of them that are dissipated."""
MOST_VISCOUS = 0.5
"""Largest part of the dissipated energy that the yarn's viscosity may take: it is on no data sheet."""
UNITS = {
    "m": ("position_", "ply_penetration", "max_deflection", "point_"),
    "s": ("time", "detached", "wall"),
    "m/s": ("velocity", "speed", "residual_speed"),
    "rad/s": ("angular_velocity_",),
    "N": ("force_",),
    "J": (
        *"work external_work initial_kinetic residual_kinetic absorbed support_work projectile_kinetic energy_residual".split(),
        *PARTS,
        "residual",
        "gained",
    ),
}
"""SI units of the columns of tables, by the beginnings of their names."""


def with_attrs(table: "pandas.DataFrame") -> "pandas.DataFrame":
    """The table with the units of its columns, as far as they have one, in `table.attrs["units"]`."""
    known = {row["name"]: row["unit"] for row in parameters() if row["unit"] not in ("", "1")}
    begins = sorted(((begin, unit) for unit, names in UNITS.items() for begin in names), key=lambda one: -len(one[0]))
    for column in map(str, table.columns):
        unit = known.get(column.split("[")[0]) or next((unit for begin, unit in begins if column.startswith(begin)), None)
        if unit:
            table.attrs.setdefault("units", {})[column] = unit
    return table


def with_units(table: "pandas.DataFrame") -> "pandas.DataFrame":
    """The table with its units in the names of its columns, as files have them."""
    units = {
        name: unit.replace("1/", "per_").replace("/", "_per_").replace(".", "_").lower()
        for name, unit in table.attrs.get("units", {}).items()
    }
    return table.rename(columns=lambda name: f"{name}_{units[name]}" if name in units else name)


def named(until: Sequence[str] | str) -> tuple[str, ...]:
    """Names of outcomes, of which one alone may be a text."""
    return (until,) if isinstance(until, str) else tuple(until)


def scene_of(scene: Scene | str) -> Scene:
    """A scene, or that of a preset or a file by its name."""
    return Scene.read(scene) if isinstance(scene, str) else scene


def fly(scene: Scene | str, *, until: Sequence[str] | str = UNTIL, steps: int = STEPS) -> dict[str, Any]:
    """Runs a scene, or the preset or the file of a name, to one of the outcomes `until`, or for so many steps, and returns what
    came of it as one row of a table.

    - `outcome`: the outcomes that ended the run, "failed" if the computation could not go on; if the steps ended it, "detached"
      where the projectile carries torn cloth, else "timeout";
    - `failure`: the code of that failure, else None;
    - `stopped`: whether the fabric stopped the projectile: True if it was arrested or has rebounded, False if it exited, went
      through or carries torn cloth, None if no outcome came: then it is not known; None also if it passed beside the sheet
      without contact, or if contact gave energy from nothing;
    - `detached`: time at which the contact was with torn cloth only, s, else None;
    - `steps`, `time`: steps taken, and the time at the end, s;
    - `velocity_x`, `_y`, `_z`, `speed`: of the projectile at the end, m/s: after "arrested" that of the rebound;
      `angular_velocity_x`, `_y`, `_z`, rad/s;
    - `initial_kinetic`, `residual_kinetic`: kinetic energy of the projectile at the start and at the end, J;
    - `absorbed`: work of the projectile on the fabric, J; `support_work`: what of it went into held nodes; `force_peak`: largest
      mean force over a force window, N;
    - `fabric_kinetic`, `strain`, `dissipated`, `viscous`, `friction`, `ply_loss`, `casing_loss`, `attachment`, `contact_loss`,
      `energy_residual`, and of it `gained`, what came from nothing: the energy balance at the end, J;
    - `max_deflection`: largest deflection of held cloth in the run, m, seen every SAMPLE steps and at the end (`plot.profile`
      draws the back face);
    - `failed_segments`: segments that have failed; `failed_near_held`: how many of them lie within three spacings of a held node;
    - `unconverged`: contact solves that did not converge; `ply_penetration`: deepest that plies were through each other, m;
      `beyond_fine`: steps in which the projectile met the sheet beyond the fine part of a graded network;
    - `digest`: hash of the state at the end.

    "through" among the outcomes sets `track_through`. The numbers are of the model with its random samples; of the model against
    tests `model_error(scene)` says how far a limit may be off.
    Of a projectile that went through, energies and `ply_penetration` hold what torn cloth did after it, too; `until=DECIDED` ends
    there, sooner.
    After a failure everything but the outcome, steps, these counters and the digest is None.

    Warns (RuntimeWarning) if the counters say that the numbers are not to be trusted as they are, and while it flies when the
    energy balance opens. Raises Refused, with the name of the field, if the scene cannot be simulated.
    """
    scene = scene_of(scene)
    row = flown(scene, until, steps, warns=True)
    for doubt in doubts([scene], [row]):
        warnings.warn(doubt, RuntimeWarning, stacklevel=2)
    return row


def stepped(simulation: Simulation, until: Sequence[str], last: int, every: Callable[[], int]) -> Iterator[int]:
    """Steps of a simulation on its way to one of the outcomes, at most to step `last`: after every `every()` steps, and at its
    end."""
    while simulation.step_count < last and not any(name in until for name in simulation.outcomes()):
        simulation.run(until, min(every(), last - simulation.step_count))
        yield simulation.step_count


def where(simulation: Simulation) -> str:
    """How far a run is, for who waits for it."""
    speed, work = math.hypot(*simulation.projectile()["velocity"]), simulation.contact()["work"]
    return f"{1e6 * simulation.time:.0f} us, {speed:.1f} m/s, {work:.2f} J absorbed"


def flown(
    scene: Scene,
    until: Sequence[str] | str,
    steps: int,
    watch: Callable[[Simulation], None] | None = None,
    *,
    warns: bool = False,
) -> dict[str, Any]:
    """What `fly` returns, without its warnings at the end, and while it flies if not asked for. watch: looks every SAMPLE
    steps."""
    until = named(until)
    if "through" in until and not scene["track_through"]:
        scene = scene.replace(track_through=True)
    simulation = Simulation(scene, warns=warns)
    initial = simulation.energy()["projectile_kinetic"]
    row: dict[str, Any] = {"outcome": "failed", "failure": None, "stopped": None}
    deepest = 0.0
    try:
        for _ in stepped(simulation, until, steps, lambda: SAMPLE):
            deepest = max(deepest, simulation.fabric()["max_deflection"])
            if watch:
                watch(simulation)
    except Failed as failed:
        row["failure"] = failed.code
    else:
        come = simulation.outcomes()
        ended = [name for name in come if name in until]
        if not ended and "detached" in come:
            ended = ["detached"]
        row["outcome"] = " and ".join(ended) or "timeout"
        row["stopped"] = any(name in come for name in STOPPED) if ended and "passed" not in ended else None
    broken, counters = row["failure"] is not None, simulation.counters()
    found: Any = ({}, {}, {}) if broken else (simulation.projectile(), simulation.energy(), simulation.contact())
    body, energy, contact = found
    detached = simulation.outcomes().get("detached")
    row |= {"detached": detached["time"] if detached else None, "steps": counters["steps"], "time": simulation.time}
    row |= {f"velocity_{axis}": part for axis, part in zip("xyz", body.get("velocity", [None] * 3))}
    row["speed"] = None if broken else math.hypot(*body["velocity"])
    row |= {f"angular_velocity_{axis}": part for axis, part in zip("xyz", body.get("angular_velocity", [None] * 3))}
    row |= {"initial_kinetic": initial, "residual_kinetic": energy.get("projectile_kinetic"), "absorbed": contact.get("work")}
    row |= {"support_work": energy.get("support_work"), "force_peak": contact.get("force_peak")}
    row |= {name: energy.get(name) for name in (*PARTS, "gained")} | {"energy_residual": energy.get("residual")}
    if share(row["gained"], initial) > MOST_FROM_NOTHING:
        row["stopped"] = None
    row["max_deflection"] = None if broken else deepest
    row["failed_near_held"] = None if broken else near_held(simulation) if counters["failed_segments"] else 0
    row |= {name: counters[name] for name in ("failed_segments", "unconverged", "ply_penetration", "beyond_fine")}
    row["digest"] = simulation.digest
    return row


def near_held(simulation: Simulation) -> int:
    """Failed segments within three spacings of a held node, which is one that does not move."""
    scene, velocities = simulation.scene, simulation.velocities()
    plies, (rows, columns, _) = scene["stack.plies"], velocities.shape
    shape = (plies, rows // plies, columns)
    near = scipy.ndimage.maximum_filter((velocities == 0.0).all(-1).reshape(shape), (1, 7, 7))
    failed, across = (
        simulation.damage().reshape(plies, -1) == 0.0,
        columns - 1 + (scene["symmetry.mirror_x"] or scene["sheet.closed"]),
    )
    # Without the segments to images and across the joint of a ring.
    along_x = failed[:, : across * shape[1]].reshape(plies, shape[1], across)[..., : columns - 1]
    along_y = failed[:, across * shape[1] :].reshape(plies, -1, columns)[:, : shape[1] - 1]
    return int((along_x & (near[..., :-1] | near[..., 1:])).sum() + (along_y & (near[:, :-1] | near[:, 1:])).sum())


def share(part: float | None, whole: float) -> float:
    return abs(part or 0.0) / whole if whole else 0.0


def doubts(scenes: Sequence[Scene], rows: Sequence[Mapping[str, Any]]) -> list[Note]:
    """Decisive warnings of runs, for every report and every function: why rows of `fly` and their scenes are not to be trusted as
    they are, and what to do. Nothing of sound runs; the sentence of one run does not count it."""
    speed = lambda scene: math.hypot(*scene["projectile.velocity"])
    unconverged = [share(row["unconverged"], row["steps"]) for row in rows]
    gains, nothing = ([share(row[name], row["initial_kinetic"]) for row in rows] for name in ("energy_residual", "gained"))
    viscous = [share(row["viscous"], sum(max(row[name] or 0.0, 0.0) for name in LOST)) for row in rows]
    counted = [
        (
            "energy_from_nothing",
            sum(one > MOST_FROM_NOTHING for one in nothing),
            max(nothing, default=0.0),
            f"contact has given energy from nothing (`gained`; at most {100 * max(nothing, default=0.0):.2g} % of the impact "
            "energy): the outcome is not known. Take half of time_step.fraction.",
        ),
        (
            "unconverged",
            sum(one > MOST_UNCONVERGED for one in unconverged),
            max(unconverged, default=0.0),
            f"more than {100 * MOST_UNCONVERGED:g} % of the steps have a contact solve that did not converge (`unconverged` over "
            f"`steps`; at most {100 * max(unconverged, default=0.0):.2g} %). Its impulses are inexact, and so are velocities and "
            "energies. Repeat such runs with half the time step (time_step.fraction) and with a smaller contact.friction: both "
            "usually reduce the share. A number that they change by more than the scatter of the runs is not a result.",
        ),
        (
            "energy_residual",
            sum(one > MOST_GAINED for one in gains),
            max(gains, default=0.0),
            f"the energy residual exceeds {100 * MOST_GAINED:g} % of the impact energy (`energy_residual`; at most "
            f"{100 * max(gains, default=0.0):.4g} %): yarn that goes slack and taut changes the energy. Write slack_balance = "
            'true at the top of the scene file (docs/model.md, "Slack and taut").',
        ),
        (
            "beyond_fine",
            sum(row["beyond_fine"] > 0 for row in rows),
            max((row["beyond_fine"] for row in rows), default=0),
            "the projectile met the sheet beyond the fine part of the graded network (`beyond_fine`), where nodes may be too far "
            "apart to meet it. Move sheet.grading.centre or enlarge sheet.grading.half_width.",
        ),
        (
            "viscous",
            sum(one > MOST_VISCOUS for one in viscous),
            max(viscous, default=0.0),
            f"the viscosity of the yarn takes more than half of the dissipated energy (`viscous`; at most "
            f"{100 * max(viscous, default=0.0):.0f} %). No data sheet gives it: repeat them with half of viscosity_linear, "
            "viscosity_quadratic and viscosity_bending of [yarn].",
        ),
        (
            "no_contact",
            sum(row["outcome"] == "timeout" and not row["absorbed"] for row in rows),
            None,
            "the projectile never touched the sheet: look at its position and velocity.",
        ),
        (
            "step_unchecked",
            sum(scene["step_check"] == "none" for scene in scenes),
            None,
            "the time step was not checked: above 0.5 dt_crit the results are wrong, although they may look plausible.",
        ),
        (
            "all_held",
            sum(
                not row["max_deflection"]
                and sum(end - first for _, first, end in scene.held()) == scene["sheet.nodes_x"] * scene["sheet.nodes_y"]
                for scene, row in zip(scenes, rows)
            ),
            None,
            "every node is held: there is nothing to hit.",
        ),
    ]
    fastest = sorted(scenes, key=speed, reverse=True)
    bodies = (
        ("unlikely_body", Scene.unlikely_body),
        ("sharp_edges", lambda scene: scene.sharp_edges(speed(scene))),
        ("coarse_network", Scene.coarse_network),
        ("loose_and_thick", Scene.loose_and_thick),
    )
    first = [(code, next(filter(None, map(said, fastest)), None)) for code, said in bodies]
    found = [Note(f"{note[0].upper()}{note[1:]}.", code, {"speed": speed(fastest[0])}) for code, note in first if note]
    for code, count, most, text in counted:
        if count:
            said = f"In {count} of {len(rows)} runs {text}" if len(rows) > 1 else text[0].upper() + text[1:]
            found.append(Note(said, code, {"runs": count, "of": len(rows)} | ({} if most is None else {"most": most})))
    return found


def history(
    simulation: Simulation | Scene | str, *, until: Sequence[str] | str = UNTIL, steps: int = STEPS, every: int = 64
) -> "pandas.DataFrame":
    """Runs a simulation, or a scene from its start, to one of the outcomes, for at most so many steps, and returns a row for
    every `every` steps.

    A row has step and time (s), position, velocity and angular velocity of the projectile, the mean force on it since the row
    before (N), `work`, the energies (J), failed segments, nodes in contact, and the largest deflection (m) and stretch.

    Raises Failed if the computation cannot go on.
    """
    import pandas  # Half a second, which workers need not spend.

    if every < 1:
        raise ValueError(f"every: must be at least 1; it is {every}")
    if not isinstance(simulation, Simulation):
        simulation = Simulation(scene_of(simulation))
    until, rows = named(until), [sample(simulation, None)]
    for _ in stepped(simulation, until, simulation.step_count + steps, lambda: every):
        rows.append(sample(simulation, rows[-1]))
    return with_attrs(pandas.DataFrame(rows).drop(columns=["impulse_x", "impulse_y", "impulse_z"]))


def sample(simulation: Simulation, before: dict[str, Any] | None) -> dict[str, Any]:
    """One row of a history; with the impulse, of which the next row needs it."""
    row: dict[str, Any] = {"step": simulation.step_count, "time": simulation.time}
    projectile, contact = simulation.projectile(), simulation.contact()
    for name in ("position", "velocity", "angular_velocity"):
        row |= {f"{name}_{axis}": number for axis, number in zip("xyz", projectile[name])}
    since = simulation.time - before["time"] if before else 0.0
    for axis, impulse in zip("xyz", contact["impulse"]):
        row[f"impulse_{axis}"] = impulse
        row[f"force_{axis}"] = (impulse - before[f"impulse_{axis}"]) / since if before and since > 0.0 else 0.0
    row["work"] = contact["work"]
    row |= {name: energy for name, energy in simulation.energy().items() if name != "contact_work"}
    counters = simulation.counters()
    row |= {name: counters[name] for name in ("failed_segments", "contacts")}
    return row | simulation.fabric()

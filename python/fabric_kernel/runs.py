"""One impact from start to end: its row of a table, and its history."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import scipy  # Its parts are loaded where they are used.

from ._kernel import Failed, Scene, Simulation, parameters
from .notes import Note, warn
from .record import record

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
CLAMPS = 0.5
"""Share of the failed segments near held nodes from which on the clamps are named as the cause."""
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
        *"external_work impact_energy residual_kinetic absorbed support_work projectile_kinetic energy_residual".split(),
        *PARTS,
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


@record
class Flight:
    """One impact from start to end: `dataclasses.asdict` makes a dictionary of it, and a list of them a pandas table.

    After a failure what has no other value is None. Energies of a projectile that went through hold what torn cloth did after it,
    too; `until=DECIDED` ends sooner.
    """

    outcome: Annotated[
        str, 'outcomes that ended the run; "failed", or where the steps ended it "detached" (carries cloth), "timeout"'
    ]
    failure: Annotated[str | None, "code of the failure that ended it"]
    stopped: Annotated[
        bool | None, "whether the fabric stopped it; None: not known, missed the sheet, or energy came from nothing"
    ]
    detached: Annotated[float | None, "time at which the contact was with torn cloth only, s"]
    steps: Annotated[int, "steps taken"]
    time: Annotated[float, "time at the end, s"]
    velocity_x: Annotated[float | None, 'velocity at the end, m/s; after "arrested" that of the rebound']
    velocity_y: Annotated[float | None, "likewise"]
    velocity_z: Annotated[float | None, "likewise"]
    speed: Annotated[float | None, "size of the velocity, m/s"]
    angular_velocity_x: Annotated[float | None, "angular velocity at the end, rad/s"]
    angular_velocity_y: Annotated[float | None, "likewise"]
    angular_velocity_z: Annotated[float | None, "likewise"]
    impact_energy: Annotated[float, "kinetic energy of the projectile at the start, J"]
    residual_kinetic: Annotated[float | None, "kinetic energy of the projectile at the end, J"]
    absorbed: Annotated[float | None, "work of the projectile on the fabric, J"]
    support_work: Annotated[float | None, "part of it on held nodes, J"]
    force_peak: Annotated[float | None, "largest mean force over a force window, N"]
    fabric_kinetic: Annotated[float | None, "kinetic energy of the fabric, J"]
    strain: Annotated[float | None, "strain energy of the yarns, J"]
    dissipated: Annotated[float | None, "dissipated by rupture, J"]
    viscous: Annotated[float | None, "dissipated by the viscosity of the yarn, J"]
    friction: Annotated[float | None, "dissipated by friction between yarn and projectile, J"]
    ply_loss: Annotated[float | None, "lost where plies meet, J"]
    casing_loss: Annotated[float | None, "lost on the case of a ring, J"]
    attachment: Annotated[float | None, "dissipated in clamps, J"]
    contact_loss: Annotated[float | None, "lost when nodes are swept up by the projectile, J"]
    gained: Annotated[float | None, "part of the residual that came from nothing, J"]
    energy_residual: Annotated[float | None, "residual of the energy balance, J"]
    max_deflection: Annotated[float | None, "largest deflection of held cloth, m, seen every SAMPLE steps and at the end"]
    failed_near_held: Annotated[int | None, "failed segments within three spacings of a held node"]
    failed_segments: Annotated[int, "failed segments"]
    unconverged: Annotated[int, "contact solutions that did not converge"]
    ply_penetration: Annotated[float, "deepest penetration of plies, m"]
    beyond_fine: Annotated[int, "steps in which the projectile met a graded network beyond its fine part"]
    digest: Annotated[str, "hash of the state at the end"]


def fly(scene: Scene | str, *, until: Sequence[str] | str = UNTIL, steps: int = STEPS) -> Flight:
    """Runs a scene to one of some outcomes.

    It warns (`ModelWarning`) where the result is in doubt, and while it flies when the energy balance opens. The numbers are of
    the model with its random samples; `model_error(scene)` says how far a limit may be off.

    Parameters
    ----------
    scene : Scene or str
        Scene, or the name of a preset or a scene file.
    until : str or sequence of str
        Outcomes that end it; "through" among them sets `track_through`.
    steps : int
        Most steps.

    Raises
    ------
    Refused
        The scene cannot be simulated; `field` names what is wrong.
    """
    scene = scene_of(scene)
    row = flown(scene, until, steps, warns=True)
    warn(doubts([scene], [row]))
    return Flight(**row)


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
    row |= {"impact_energy": initial, "residual_kinetic": energy.get("projectile_kinetic"), "absorbed": contact.get("work")}
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


def at_clamps(simulation: Simulation) -> str:
    """Sentence where yarn broke, or mostly broke, at the clamps; empty otherwise."""
    failed = simulation.counters()["failed_segments"]
    near = near_held(simulation) if failed else 0
    if near < CLAMPS * failed or not failed:
        return ""
    none = "none broke under the projectile" if near == failed else f"{failed - near} of {failed} failed elsewhere"
    return f"Yarns broke at the clamps: {near} failed segments lie within three spacings of a held node; {none}."


def share(part: float | None, whole: float) -> float:
    return abs(part or 0.0) / whole if whole else 0.0


def doubts(scenes: Sequence[Scene], rows: Sequence[Mapping[str, Any]]) -> list[Note]:
    """Decisive warnings of runs, for every report and every function: why rows of `fly` and their scenes are not to be trusted as
    they are, and what to do. Nothing of sound runs; the sentence of one run does not count it."""
    speed = lambda scene: math.hypot(*scene["projectile.velocity"])
    unconverged = [share(row["unconverged"], row["steps"]) for row in rows]
    gains, nothing = ([share(row[name], row["impact_energy"]) for row in rows] for name in ("energy_residual", "gained"))
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
    """Runs a simulation, or a scene from its start, and returns a row for every few steps.

    Parameters
    ----------
    simulation : Simulation, Scene or str
        Simulation, which goes on from where it is, or scene, or the name of a preset or a scene file.
    until : str or sequence of str
        Outcomes that end it.
    steps : int
        Most steps.
    every : int
        Steps between two rows.

    Returns
    -------
    pandas.DataFrame
        Step and time (s), position, velocity and angular velocity of the projectile, mean force on it since the row before (N),
        energies (J), failed segments, nodes in contact, largest deflection (m) and stretch.

    Raises
    ------
    Failed
        The computation cannot go on.
    """
    from .extras import pandas  # Half a second, which workers need not spend.

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
    energy = dict(simulation.energy())
    row |= {"absorbed": energy.pop("contact_work"), "energy_residual": energy.pop("residual")} | energy
    counters = simulation.counters()
    row |= {name: counters[name] for name in ("failed_segments", "contacts")}
    return row | simulation.fabric()

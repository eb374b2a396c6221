"""`fabric scene`, `fabric fabrics` and `fabric replay`: what there is, and a capsule done again."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from . import about as scenes
from . import page, results
from ._kernel import PRESETS, VERSION, Scene
from ._kernel import fabrics as named_fabrics
from ._kernel import replay as replayed
from .files import naming


def scene(arguments: Sequence[str]) -> None:
    """The command `fabric scene`."""
    about = "A scene file with every parameter, its unit and its meaning; without a name, the presets."
    parser = scenes.options("scene", about)
    parser.add_argument("scene", nargs="?", help=f"a scene file, or a preset: {', '.join(PRESETS)}")
    parser.add_argument(
        "--features", action="store_true", help="which features of the kernel the scene needs, and how a build has no others"
    )
    given = parser.parse_args(arguments)
    with scenes.ending(parser, given):
        if given.features:
            if given.scene is None:
                raise ValueError("--features: needs a scene")
            scene = Scene.read(given.scene)
            given.answer = scene.features()
            print(needed(scene), flush=True)
        elif given.scene is None:
            given.answer = PRESETS
            print("\n".join(PRESETS), flush=True)
        else:
            scene = Scene.read(given.scene)
            given.answer = scene.to_dict()
            print(scene.to_toml(), flush=True)


def needed(scene: Scene) -> str:
    """The features that a scene needs, and the lines of a build that leaves all others out."""
    features = scene.features()
    rows = [[name, field] for name, field in features.items()]
    listed, flags = (
        ", ".join(f'"{name}"' for name in features),
        ",".join(["bare", *(f"fabric-kernel/{name}" for name in features)]),
    )
    return (
        f"{page.printed(['feature', 'asked for by'], rows)}\n"
        f'Cargo.toml:  fabric-kernel = {{ version = "{VERSION}", default-features = false, features = [{listed}] }}\n'
        f"C library:   cargo build --profile ship -p capi-lib --no-default-features --features {flags}\n"
        'The feature "vectors" makes it faster; docs/tables/size.md has what each costs.'
    )


def fabrics(arguments: Sequence[str]) -> None:
    """The command `fabric fabrics`."""
    parser = scenes.options("fabrics", "The named fabrics for the table [fabric] of a scene file.")
    parser.add_argument("name", nargs="?", help="of one, or the file of one of your own: its numbers with their sources")
    given = parser.parse_args(arguments)
    with scenes.ending(parser, given):
        found = {one["name"]: one for one in named_fabrics()}
        if given.name in found:
            given.answer = found[given.name]
            print(found[given.name]["text"], end="", flush=True)
            return
        if given.name is not None:
            raise ValueError(f"no fabric {given.name}: one of {', '.join(found)}")
        given.answer = list(found.values())
        shown = lambda number, digits: f"{number:.{digits}f}" if math.isfinite(number) else "-"
        rows = [
            [
                name,
                shown(1e3 * one["areal_density"], 1),
                shown(1e3 * one["spacing"], 4),
                shown(1e6 * one["area"], 5),
                shown(one["wave_speed"], 0),
                shown(one["critical_stretch"], 5),
            ]
            for name, one in found.items()
        ]
        print(page.printed(["name", "g/m2", "spacing mm", "area mm2", "wave m/s", "U_c"], rows))
        print("\n".join(f"{name}: {one['title']}" for name, one in found.items()))
        print("sources: fabric fabrics NAME", flush=True)


def report(arguments: Sequence[str]) -> None:
    """The command `fabric report`."""
    from . import family, fragments, run
    from .accuracy import Accuracy
    from .compare import Comparison
    from .residual import Curve
    from .v50 import LimitTest, Share

    parser = scenes.options("report", "Pictures and report again, of what a command has written.")
    parser.add_argument("folder", type=Path, help="of `fabric run`, v50, accuracy, compare, tests, residual or fragments")
    given = parser.parse_args(arguments)
    kinds: dict[str, Any] = {
        "test.json": LimitTest,
        "at.json": Share,
        "accuracy.json": Accuracy,
        "compare.json": Comparison,
        family.FILE: family.OwnTests,
        "residual.json": Curve,
        "fragments.json": fragments.Map,
    }
    with scenes.ending(parser, given):
        found = [file for file in kinds if (given.folder / file).exists()]
        if found:
            given.answer = results.read(kinds[found[0]], given.folder / found[0])
            given.answer.write(given.folder)
        else:
            given.answer = run.reported(given.folder)
        print(f"written to {given.folder}: report.html", flush=True)


def replay(arguments: Sequence[str]) -> None:
    """The command `fabric replay`."""
    ends = "Exit status: 0 same bits; 1 a difference, or a capsule that is cut off; 2 for what is refused."
    parser = scenes.options("replay", "Does a capsule again and compares bit by bit.", ends)
    parser.add_argument("file", type=Path, help="as `fabric run --capsule`, Simulation(..., capsule=FILE), C or an FMU wrote it")
    given = parser.parse_args(arguments)
    with scenes.ending(parser, given):
        with naming(given.file):
            found = given.answer = replayed(given.file)
        if found["version"] != VERSION:
            print(f"warning: {given.file} is of version {found['version']}, this is {VERSION}, which may give other bits")
        if found["difference"] is not None:
            print(f"{given.file}: {found['difference']}", flush=True)
        else:
            print(
                f"{given.file}: same bits: {found['calls']} calls, {found['step']} steps, {found['digests']} digests, the last "
                f"{found['digest']}",
                flush=True,
            )
        if not found["whole"]:
            print(f"{given.file}: it is cut off, or its program did not end it; what is whole was replayed", flush=True)
    if not (found["same"] and found["whole"]):
        parser.exit(1)

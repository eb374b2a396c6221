"""What the commands share: scenes by file or preset, and what a report must say of the scene."""

import argparse
import contextlib
import hashlib
import io
import json
import logging
import math
import re
import sys
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NoReturn

from . import extras
from ._kernel import PRESETS, VERSION, Refused, Scene
from .files import FULL, Output, apart, shown, written
from .oneply import windowing
from .results import plain
from .textile import areal_density, of_the_paper, sides, spacings, strength

CAVEAT = "Not validated: the agreement with reality. docs/validation.md has the comparisons with measurements, misses among them."
PAPER = "The yarn is that of the source paper, about 3.7 times too stiff and strong for its mass."
VISCOSITY = "Results depend on the viscosity of the yarn."


def size(scene: Scene) -> str:
    """Sides of the sheet, mm."""
    return " x ".join(f"{1e3 * side:.4g}" for side in sides(scene))


def scene_hash(scene: Scene) -> str:
    """The start of the SHA-256 of a scene's parameters."""
    return hashlib.sha256(json.dumps(scene.to_dict(), sort_keys=True).encode()).hexdigest()[:16]


def described(scene: Scene, fabric: str = "") -> tuple[str, ...]:
    """Sheet, projectile and version, a sentence each."""
    value = scene.to_dict()
    bar = " x ".join(f"{1e3 * h:.3g}" for h in dict.fromkeys(spacings(scene)))
    lumped = "1 ply" if value["sheet.plies"] == 1 else f"{value['sheet.plies']} plies lumped into one sheet"
    plies = lumped
    if value["stack.plies"] > 1:
        each = "" if value["sheet.plies"] == 1 else f" of {lumped} each"
        plies = f"{value['stack.plies']} separate plies{each}, {1e3 * value['stack.gap']:.4g} mm apart"
        plies += ", every other one turned" if value["stack.turned"] else ""
        plies += f", the last {value['back.plies']} of another fabric" if value["back.plies"] else ""
    yarn = f"modulus {1e-9 * value['yarn.modulus_mean']:.4g} GPa, critical stretch {value['yarn.critical_stretch']:.5g}"
    viscosity = ", ".join(f"{value[f'yarn.viscosity_{kind}']:g}" for kind in ("linear", "quadratic", "bending"))
    body = [value["projectile.shape"].replace("_", " "), f"mass {1e3 * value['projectile.mass']:.4g} g"]
    if body[0] == "sphere" or "cylinder" in body[0]:
        body.append(f"radius {1e3 * value['projectile.radius']:.4g} mm")
    if "cylinder" in body[0]:
        body.append(f"length {1e3 * value['projectile.length']:.4g} mm")
    if "sector" in body[0]:
        body.append(f"outer radius {1e3 * value['projectile.sector.outer_radius']:.4g} mm")
    body[0] += f" of {scene.material}" if scene.material else ""
    body.append(f"friction {value['contact.friction']:g}")
    name = f"{fabric}, " if fabric else ""
    nodes = f"{value['sheet.nodes_x']} x {value['sheet.nodes_y']}"
    held = value["attachment.kind"].replace("_", " ")
    return (
        f"Sheet: {name}{plies}, {areal_density(scene):.4g} kg/m², {size(scene)} mm, held: {held}; {nodes} nodes {bar} mm apart; "
        f"yarn: {yarn}, viscosity {viscosity}.",
        f"Projectile: {', '.join(body)}.",
        f"fabric_kernel {VERSION}, scene {scene_hash(scene)} (the start of the SHA-256 of its parameters).",
    )


def attachments(scene: Scene) -> str:
    """What a limit assumes of the attachments, in one line with its numbers."""
    hold, grip, whole = (scene[f"attachment.{name}"] for name in ("hold", "grip", "strength"))
    bar = scene["sheet.yarn_area"] * strength(scene)
    slips = f"they hold every yarn without limit (no hold is set; a bar breaks at {bar:.4g} N)"
    if hold:
        length = f"{1e3 * grip:.4g} mm of yarn in the grip" if grip else "a grip without end"
        slips = f"they slip at {hold:.4g} N a bar, {hold / bar:.2f} of the {bar:.4g} N at which it breaks, with {length}"
    fails = f"each fails at {whole:.4g} N" if whole else "none fails as a whole"
    return (
        "No attachments: the sheet is free."
        if scene["attachment.kind"] == "free"
        else f"Assumed of the attachments: {slips}; {fails}."
    )


def thickness(scene: Scene) -> str:
    """What a limit assumes of the thickness of the cloth, in one line."""
    ply, assumed = scene["sheet.thickness"], scene.weave().get("assumed_thickness")
    if not ply:
        return "No thickness: the cloth is a surface, and edges of the projectile are sharp."
    known = "assumed, areal density over (fibre density x 0.48)" if ply == assumed else "given"
    return f"Thickness: {1e3 * ply:.3g} mm a ply, {known}; the projectile touches the middle of the cloth at half of it."


def cautions(scene: Scene) -> tuple[str, ...]:
    """What a reader of a limit must know first, a sentence or two each; the first two belong to the answer."""
    yarn, window = PAPER if of_the_paper(scene) else VISCOSITY, windowing(scene)
    width = (
        f"The limit is that of a sheet of this width and support, {size(scene)} mm and "
        f"{scene['attachment.kind'].replace('_', ' ')}, which decide it "
        "(docs/v50.md): fabric v50 --sensitivity measures by how much."
    )
    return (width, attachments(scene), thickness(scene), f"{CAVEAT} {yarn}", *filter(None, [window.sentence() if window else ""]))


SHOT_AT, SUMMARY, COMPARED, OWN = "shot_at.toml", "summary.json", "compare.json", "own_tests.json"
"""Files that tell whose results a folder has: the scene of most commands; what `fabric run`, compare and tests found."""


class Parser(argparse.ArgumentParser):
    """Options of which a refusal is one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"error: {message}\n")


def options(name: str, about: str, ends: str | None = None) -> Parser:
    """Options of the command `fabric NAME`, with --json for `ending`. ends: what its exit status says."""
    parser = Parser(prog=f"fabric {name}", description=about, epilog=ends, allow_abbrev=False)
    parser.add_argument("--json", action="store_true", help="print the answer as JSON, and all else on stderr")
    return parser


def of_a_scene(name: str, about: str, files: str) -> Parser:
    """What every command `fabric NAME` is given: a scene, a seed, and a folder for these files."""
    ends = (
        "Exit status: 0; 4 if slower shots go through while faster ones are stopped, so that there is no single limit; 1 after "
        "a failure; 2 for what is refused."
    )
    parser = options(name, about, ends)
    parser.add_argument("scene", help=f"a scene file, see docs/tables/scene.md, or a preset: {', '.join(PRESETS)}")
    parser.add_argument("--seed", type=int, default=1, help="of yarns and impact points; default: %(default)s")
    parser.add_argument("--out", type=Path, default=Path(name), help=f"folder for {files}")
    parser.set_defaults(command=name, files={SHOT_AT, *re.findall(r"\w+\.\w+", files)})
    return parser


def finished(given: argparse.Namespace, names: Sequence[str]) -> None:
    """Removes what the same command wrote before into its folder and has not written again, and prints what it has."""
    for name in given.files - {SHOT_AT, *names} if given.claimed else ():
        if not name.endswith(".jsonl"):
            (given.out / name).unlink(missing_ok=True)
    print(f"written to {given.out}: {', '.join(names)}", flush=True)


def own_tests_of(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--tests", type=Path, metavar="FOLDER", help="own firing tests, of `fabric tests`, that correct the limit"
    )


@contextlib.contextmanager
def folder(out: Path, *needed: str) -> Iterator[None]:
    """A folder for results: refused before the work if it cannot be written, or a library that is needed is missing, and gone
    after it if nothing was."""
    for name in needed or ("matplotlib", "pandas"):
        extras.found(name)
    new = [path for path in (out, *out.parents) if not path.exists()]
    try:
        try:
            out.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=out).close()
        except OSError as error:
            raise ValueError(f"--out: {out} cannot be written: {error.strerror}") from error
        yield
    finally:
        for path in new:
            with contextlib.suppress(OSError):
                path.rmdir()


def of_others(out: Path, own: str) -> None:
    """Raises ValueError if a folder has the results of another command; own: the file that tells this one."""
    for name in {SHOT_AT, SUMMARY, COMPARED, OWN} - {own}:
        if (out / name).exists():
            raise ValueError(f"--out: {out} has the results of another command ({name}): give another folder")


def goes_on(kept: Path) -> tuple[Path, str]:
    return kept, f"what has ended is in {shown(kept)}, and the same command goes on from there"


@contextlib.contextmanager
def command(parser: argparse.ArgumentParser, given: argparse.Namespace) -> Iterator[tuple[Scene, str]]:
    """The work of a command with the scene and the name of its fabric, in a folder that is made that of the scene: what goes
    wrong ends it with one line."""
    with ending(parser, given):
        given.kept = goes_on(given.out / "runs.jsonl")
        scene = Scene.read(given.scene)
        apart([given.scene], [given.out / name for name in given.files])
        is_new = not given.out.exists()
        given.claimed = (given.out / SHOT_AT).exists()
        with folder(given.out):
            claim(given.out, scene, given.command)
            try:
                yield scene, scene.label
            except ValueError:
                if is_new and [path.name for path in given.out.iterdir()] == [SHOT_AT]:
                    (given.out / SHOT_AT).unlink()
                raise


@contextlib.contextmanager
def ending(parser: argparse.ArgumentParser, given: argparse.Namespace) -> Iterator[None]:
    """The work of a command: what goes wrong ends it with one line, and status 2 for what is refused. With --json the work sets
    `given.answer`, which is printed as JSON; what it prints itself goes to stderr. `given.kept`: a file, and what an interrupt
    says of what is kept once it is there."""
    warned = lambda message, *_, **__: print(f"warning: {message}", file=sys.stderr)
    given.kept, said = (), Output(sys.stdout)
    sys.stderr = sys.stderr or io.StringIO()
    log = logging.getLogger("fabric_kernel")
    log.handlers, log.level = [logging.StreamHandler()], logging.INFO
    try:
        with contextlib.redirect_stdout(sys.stderr if given.json else said), warnings.catch_warnings():
            warnings.showwarning = warned
            yield
        if given.json:
            said.write(json.dumps(plain(given.answer), indent=1) + "\n")
        said.finish()
    except BrokenPipeError:
        # Whoever read has stopped, as `head` does.
        parser.exit(141)
    except OSError as error:
        text = re.sub(r" \(os error \d+\)$", "", error.strerror or str(error.args[0]))
        name = f"{shown(error.filename)}: " if error.filename else ""
        parser.exit(1 if error is said.error or error.errno in FULL else 2, f"error: {name}{text}\n")
    except (ValueError, MemoryError, ModuleNotFoundError) as error:
        # A file that is refused as it is read names itself.
        file = str(getattr(given, "scene", "")) if isinstance(error, Refused) else ""
        file = "" if str(error).startswith(file) else file
        parser.exit(2, f"error: {shown(file)}{': ' if file else ''}{error}\n")
    except RuntimeError as error:
        parser.exit(1, f"error: {error}\n")
    except KeyboardInterrupt:
        is_kept = given.kept and given.kept[0].exists()
        parser.exit(130, f"interrupted: {given.kept[1] if is_kept else 'nothing is written'}\n")


def claim(out: Path, scene: Scene, name: str) -> None:
    """Makes a folder that of a scene and the command `fabric NAME`. Raises ValueError if it has the results of others."""
    text, path = f"# fabric {name}, scene {scene_hash(scene)}\n{scene.to_toml()}", out / SHOT_AT
    of_others(out, SHOT_AT)
    if not path.exists():
        written(path, text)
    elif path.read_bytes().partition(b"\n")[0] != text.encode().partition(b"\n")[0]:
        raise ValueError(
            f"--out: {out} has the results of another scene or command ({SHOT_AT}): give another folder, or delete this one"
        )


def positive(text: str) -> float:
    """A velocity of a command."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not (number > 0.0 and math.isfinite(number)):
        raise argparse.ArgumentTypeError(f"must be a number above 0; it is {text}")
    return number

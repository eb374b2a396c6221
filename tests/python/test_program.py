"""The program `fabric`: how a run ends and what it leaves, mistakes on the command line and in scene files, a reader that has
gone."""

import contextlib
import csv
import importlib
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tomllib

import fabric_kernel as fk
import pytest
from commands import called
from fabric_kernel import program

SCENES = pathlib.Path(__file__).parents[2] / "examples" / "scenes"
PROGRAM = [sys.executable, "-m", "fabric_kernel.program"]
SMALL = 'preset = "sheet_3in_sphere"\nsheet = { nodes_x = 31, nodes_y = 31 }\n'
FAST = "projectile.velocity = [0.0, 0.0, 300.0]"


def ran(*words, **options):
    return subprocess.run([*PROGRAM, *map(str, words)], capture_output=True, text=True, **options)


@pytest.mark.parametrize(
    ("words", "parameters", "status", "ended"),
    [
        (["--until", "exited"], FAST, 0, "exited"),
        (["--until", "through"], FAST, 0, "through"),
        (["--steps", "64"], "", 3, "TIMEOUT"),
        (["--steps", "64", "--until", "none"], "", 0, "TIMEOUT"),
        (["--until", "detached", "--steps", "300"], FAST, 3, "TIMEOUT"),
        ([], "contact_capacity = 1", 1, None),
        ([], "projectile.mass = 0.0", 2, None),
    ],
)
def test_the_exit_status_says_how_a_run_has_ended(tmp_path, words, parameters, status, ended):
    (tmp_path / "shot.toml").write_text(SMALL + parameters)
    out = tmp_path / f"out{status}{ended}"
    done = ran("run", tmp_path / "shot.toml", "--no-report", "--out", out, *words)
    assert done.returncode == status, done.stderr
    assert (out / "history.csv").exists() == (status != 2)
    if ended:
        assert json.loads((out / "summary.json").read_text())["ended_by"] == ended


def test_a_run_has_a_report_with_all_its_pictures_and_its_capsule_the_same_bits(tmp_path):
    (tmp_path / "shot.toml").write_text(SMALL + "stack = { plies = 2, gap = 1e-4 }\n" + FAST)
    words = ["--movie", "--vtk", "--capsule", "shot.capsule", "--json"]
    done = ran("run", "shot.toml", *words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    out = tmp_path / "fabric-run" / "shot"
    pictures = set(
        (
            "report.html sheet.png plies.png damage.png profile.svg history.svg movie.gif history.csv summary.json scene.toml "
            "state.gz vtk"
        ).split()
    )
    assert {path.name for path in out.iterdir()} == pictures
    summary = json.loads(done.stdout)
    assert summary == json.loads((out / "summary.json").read_text())
    row = fk.fly(fk.Scene.read(tmp_path / "shot.toml"))
    assert (summary["digest"], summary["steps"], summary["contact"]["work"]) == (row["digest"], row["steps"], row["absorbed"])
    assert sum(ply["failed_segments"] for ply in summary["plies"]) == row["failed_segments"]
    with (out / "history.csv").open() as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["contact_work_j"]) == row["absorbed"]
    replayed = ran("replay", tmp_path / "shot.capsule")
    assert row["digest"] in replayed.stdout
    cut = tmp_path / "cut.capsule"
    cut.write_bytes((tmp_path / "shot.capsule").read_bytes()[:-40])
    ended = ran("replay", cut)
    assert "cut off" in ended.stdout and ended.returncode == 1
    drawn_again(out)


@pytest.mark.parametrize(
    ("words", "has"),
    [
        (["run", "shot.toml", "--steps", "64", "--until", "none", "--no-report"], "digest steps contact"),
        (["v50", "shot.toml", "--shots", "8", "--tests", "0"], "shots fit window"),
        (["v50", "shot.toml", "--at", "300", "--shots", "2"], "velocity share low high"),
        (["residual", "shot.toml", "--velocities", "150", "200", "250", "300"], "answer curves shots"),
        (["fragments", "shot.toml", "--velocities", "200", "300"], "answer cells below"),
        (["scene", "shot.toml"], "projectile.mass seed"),
        (["scene", "shot.toml", "--features"], "drawn detachment"),
        (["fabrics", "kevlar_km2_s706"], "title areal_density"),
        (["replay", "shot.capsule"], "same digest step"),
    ],
    ids=lambda given: given if isinstance(given, str) else " ".join(given),
)
def test_with_json_one_object_is_all_that_is_printed(tmp_path, words, has):
    (tmp_path / "shot.toml").write_text(SMALL + FAST)
    fk.Simulation(fk.Scene(), capsule=tmp_path / "shot.capsule").step(8)
    done = ran(*words, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout, parse_constant=lambda name: pytest.fail(name))
    assert set(has.split()) <= set(answer)
    if (tmp_path / words[0] / "report.html").exists():
        drawn_again(tmp_path / words[0])


def drawn_again(folder):
    """`fabric report` of a folder gives what was there, byte by byte, and of nothing else but what was saved."""
    kinds = (".html", ".svg", ".png")
    before = {path: path.read_bytes() for path in folder.iterdir() if path.suffix in kinds}
    for path in before:
        path.unlink()
    done = ran("report", folder)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert {path: path.read_bytes() for path in folder.iterdir() if path.suffix in kinds} == before


TABLE = "projectile.velocity[2],seed,sheet.nodes_x\n300,1,\n250,2,33\n"


def test_a_batch_flies_each_row_as_the_scene_that_it_says(tmp_path):
    (tmp_path / "shot.toml").write_text(SMALL)
    (tmp_path / "rows.csv").write_text(TABLE)
    words = ["run", "shot.toml", "--batch", "rows.csv", "--out", "many"]
    said, done = ran(*words, cwd=tmp_path), ran(*words, "--json", cwd=tmp_path)
    assert (said.returncode, done.returncode) == (0, 0), said.stderr + done.stderr
    assert max(map(len, said.stdout.splitlines())) <= 100
    scene = fk.Scene.read(tmp_path / "shot.toml")
    flown = [
        fk.fly(scene.replace(seed=1, projectile={"velocity": [0.0, 0.0, 300.0]})),
        fk.fly(scene.replace(seed=2, projectile={"velocity": [0.0, 0.0, 250.0]}, sheet={"nodes_x": 33})),
    ]
    assert [row["digest"] for row in json.loads(done.stdout)] == [row["digest"] for row in flown]
    with (tmp_path / "many" / "batch.csv").open() as file:
        assert [row["digest"] for row in csv.DictReader(file)] == [row["digest"] for row in flown]


@pytest.mark.parametrize(
    ("table", "reason"),
    [
        ("seed\n", "has no row"),
        ("seed,seed\n1,2\n", "twice"),
        ("seed,sheet.nodes_x\n1,33\n2\n", "row 2: 2 cells"),
        ("colour\nred\n", "row 1: unknown key `colour`"),
        ("projectile.mass\n1e-3\n-1\n", "row 2: projectile.mass"),
        ("projectile.mass\nheavy\n", "row 1: projectile.mass"),
        ("projectile.velocity[3]\n1\n", "3 elements"),
    ],
)
def test_a_row_of_a_batch_that_is_refused_is_named_and_nothing_is_written(tmp_path, table, reason):
    (tmp_path / "shot.toml").write_text(SMALL)
    (tmp_path / "rows.csv").write_text(table)
    done = ran("run", "shot.toml", "--batch", "rows.csv", "--out", "many", cwd=tmp_path)
    assert done.returncode == 2
    assert reason in done.stderr
    assert not (tmp_path / "many").exists()


def test_a_run_that_is_stopped_leaves_nothing(tmp_path):
    (tmp_path / "shot.toml").write_text(SMALL + "projectile.velocity = [0.0, 0.0, 0.0]")
    # What takes its time to load is there before the alarm.
    importlib.import_module("fabric_kernel.run")
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.5)
    main = lambda words: program.main(["run", *words])
    _, errors, code = called(tmp_path, main, str(tmp_path / "shot.toml"), "--steps", "1000000000")
    signal.signal(signal.SIGALRM, before)
    assert (code, errors) == (130, "interrupted: nothing is written\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["rough_sphere", "turned_plies", "hybrid_pack"])
def test_balances_of_scenes_with_friction_and_plies_close(name):
    row = fk.fly(fk.Scene.read(SCENES / f"{name}.toml"))
    assert row["outcome"] == "exited"
    assert abs(row["energy_residual"]) < 0.01 * row["initial_kinetic"], name


@pytest.mark.parametrize(("file", "name"), [("..toml", "scene"), ("...toml", "scene"), ("a.b.toml", "a.b")])
def test_results_stay_in_their_folder_whatever_the_scene_is_called(tmp_path, file, name):
    (tmp_path / file).write_text(SMALL)
    done = ran("run", file, "--steps", "64", "--until", "none", "--no-report", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert os.listdir(tmp_path / "fabric-run") == [name]


MISTAKES = tomllib.loads(pathlib.Path(__file__).with_name("mistakes.toml").read_text())["mistake"]


def test_there_are_mistakes():
    assert len(MISTAKES) >= 30


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake["file"])
def test_a_mistake_in_a_scene_file_gets_an_answer_that_helps(tmp_path, mistake):
    code, said = answer(tmp_path, mistake["file"])
    assert (code == 2 and said.startswith(f"error: {tmp_path / 'mistake'}")) or "warning: " in said, said
    assert "textile." not in said
    for part in mistake["gets"]:
        assert part in said
    if "mended" in mistake:
        code, said = answer(tmp_path, mistake["mended"])
        assert code != 2, said


def answer(tmp_path, text):
    file = tmp_path / "mistake.toml"
    file.write_text(f'preset = "sheet_3in_sphere"\n{text}')
    _, said, code = called(tmp_path, lambda words: program.main(["run", *words]), str(file), "--steps", "1", "--no-report")
    return code, said


MISTYPED = (
    "fly; run; run no_preset; run none.toml; run .; run shot.toml --steps 0; run shot.toml --steps many; "
    "run shot.toml --sample -1; run shot.toml --until stopped; run shot.toml --until=; run shot.toml another.toml; "
    "run shot.toml --out locked/out; run shot.toml --steps 1000000000 --out /proc/x; "
    "run shot.toml --capsule no/folder/capsule; run shot.toml --colour; run shot.toml --steps 64 --steps=65; "
    "run shot.toml --batch none.csv; run shot.toml --batch none.csv --movie; v50 shot.toml --confidence 1.5; "
    "v50 shot.toml --shots 0; v50 shot.toml --low fast --high 90; v50 shot.toml --low 50; v50 shot.toml --plan 90; "
    "residual shot.toml --shots 2; replay shot.toml; residual shot.toml --velocities 100 fast; "
    "residual shot.toml --out /proc/x; replay none; replay; report .; report shot.toml; fabrics denim; scene none.toml; "
    "fragments shot.toml --attitudes a=1,0,0,0 a=0,1,0,0; fragments shot.toml --shots 0; fragments shot.toml --point 0,0; "
    "fmu shot.toml --from shot.toml; fmu shot.toml -o here"
).split("; ")


@pytest.mark.parametrize("words", MISTYPED)
def test_a_mistake_on_the_command_line_gets_one_line_and_status_2_and_nothing_is_written(tmp_path, capsys, words):
    (tmp_path / "shot.toml").write_text(SMALL)
    (tmp_path / "locked").write_text("a file")
    with contextlib.chdir(tmp_path), pytest.raises(SystemExit) as left:
        program.main(words.split())
    said, errors = capsys.readouterr()
    assert (left.value.code, said, errors.count("\n")) == (2, "", 1), errors
    assert errors.startswith("error: ")
    assert not re.search("Errno|os error|None", errors)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["locked", "shot.toml"]


def test_a_warning_is_one_plain_line(tmp_path):
    graded = "nodes_y = 31, grading = { largest = 8, run = 1, half_width = [4e-3, 4e-3] }"
    (tmp_path / "shot.toml").write_text(SMALL.replace("nodes_y = 31", graded) + FAST)
    done = ran("fragments", "shot.toml", "--velocities", "300", "--shots", "1", "--points", "4e-3,0", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (0, 1), done.stderr
    assert done.stderr.startswith("warning: In 1 of 1 runs the projectile met the sheet beyond the fine part")


def test_a_reader_that_has_gone_is_no_traceback(tmp_path):
    (tmp_path / "shot.toml").write_text(SMALL)
    run = ["run", "shot.toml", "--steps", "64", "--until", "none", "--no-report"]
    for words in [run, ["fabrics"], ["fabrics", "kevlar_km2_s706"], ["scene", "sheet_3in_sphere"], ["scene"]]:
        reader, writer = os.pipe()
        os.close(reader)
        done = subprocess.run([*PROGRAM, *words], stdout=writer, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
        os.close(writer)
        assert (done.returncode, done.stderr) == (141, ""), words


def test_a_printed_scene_is_the_scene():
    for preset in fk.PRESETS:
        assert fk.Scene.parse(ran("scene", preset).stdout) == fk.Scene(preset)


def test_features_are_those_that_the_scene_asks_for():
    said = ran("scene", "--features", SCENES / "kevlar_km2_s706.toml").stdout
    scene = fk.Scene.read(SCENES / "kevlar_km2_s706.toml")
    assert "viscosity" in scene.features()
    assert all(name in said for pair in scene.features().items() for name in pair)
    assert "plies" not in said
    assert fk.Scene("sheet_3in_sphere", yarn={"stochastic": False}, track_detachment=False).features() == {}


def test_fabrics_are_listed_and_shown_with_their_sources():
    listed = ran("fabrics").stdout
    assert "kevlar_km2_s706" in listed
    assert max(map(len, listed.splitlines())) <= 100
    assert "[fabric]" in ran("fabrics", "kevlar_km2_s706").stdout


def test_former_names_work_and_say_the_new_one():
    former = pathlib.Path(sys.executable).parent / "fabric-v50"
    done = subprocess.run([former, "--help"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "fabric-v50 is now: fabric v50\n")
    assert "usage: fabric v50" in done.stdout


@pytest.mark.parametrize(
    ("typed", "offered"),
    [("fabric re", {"residual", "report", "replay"}), ("fabric v50 --conf", {"--confidence"}), ("fabric run r", {"ring_40in"})],
)
def test_a_shell_completes_commands_options_and_presets(typed, offered):
    words = typed.split()
    script = ran("--completion").stdout + f"COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; _fabric; echo ${{COMPREPLY[*]}}"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert (set(done.stdout.split()), done.stderr) == (offered, "")

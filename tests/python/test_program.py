"""The program `fabric`: how a run ends and what it leaves, mistakes on the command line and in scene files, a reader that has
gone."""

import contextlib
import csv
import importlib
import json
import os
import pathlib
import re
import resource
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
    # One number of failed segments in table and captions, whatever yields in the next step.
    failed = re.findall(r"(\d+) failed segments", (out / "report.html").read_text())
    counted = {str(summary["counters"]["failed_segments"]), str(summary["plies"][0]["failed_segments"])}
    assert len(failed) == 2 and set(failed) == counted
    row = fk.fly(fk.Scene.read(tmp_path / "shot.toml"))
    assert (summary["digest"], summary["steps"], summary["contact"]["work"]) == (row.digest, row.steps, row.absorbed)
    assert sum(ply["failed_segments"] for ply in summary["plies"]) == row.failed_segments
    with (out / "history.csv").open() as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["absorbed_j"]) == row.absorbed
    replayed = ran("replay", tmp_path / "shot.capsule")
    assert row.digest in replayed.stdout
    cut = tmp_path / "cut.capsule"
    cut.write_bytes((tmp_path / "shot.capsule").read_bytes()[:-40])
    ended = ran("replay", cut)
    assert "cut off" in ended.stdout and ended.returncode == 1
    drawn_again(out)


@pytest.mark.parametrize(
    ("words", "has"),
    [
        (["run", "shot.toml", "--steps", "64", "--until", "none", "--no-report"], "digest steps contact"),
        (["v50", "shot.toml", "--shots", "8", "--simulated", "0"], "shots fit window"),
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


FLAT = 'shape = "cylinder"\nradius = "2.5 mm"\nlength = "5 mm"\nmaterial = "steel"\n'
SHARP = f'fabric = "kevlar_km2_s706"\nsheet.width = "22 mm"\naim.speed = "300 m/s"\n[projectile]\n{FLAT}'


def test_decisive_warnings_stand_under_the_number_of_every_report_and_at_every_door(tmp_path):
    (tmp_path / "shot.toml").write_text(SHARP)
    scene = fk.Scene.read(tmp_path / "shot.toml")
    for fly in (lambda: fk.fly(scene), lambda: fk.ensemble([scene], on=1)):
        with pytest.warns(RuntimeWarning) as said:
            fly()
        texts = [str(one.message) for one in said if issubclass(one.category, RuntimeWarning)]
        assert [text[:32] for text in texts] == ["The projectile has flat faces, w", "The viscosity of the yarn takes "]
    for words in (
        ["run"],
        ["v50", "--shots", "8", "--simulated", "0"],
        ["v50", "--at", "300", "--shots", "2"],
        ["residual", "--velocities", "150", "200", "250", "300"],
        ["fragments", "--velocities", "200", "300", "--shots", "1"],
        ["accuracy", "--error", "50 %", "--shots", "2"],
    ):
        assert ran(words[0], "shot.toml", *words[1:], "--out", " ".join(words), cwd=tmp_path).returncode == 0
        page = (tmp_path / " ".join(words) / "report.html").read_text()
        number, *rest = re.findall("<p>(.*?)</p>", page[page.index('class="answer"') : page.index("</div>")])
        assert re.search("m/s|energy", number) and "flat faces" not in number
        assert any("has flat faces, whose edges are" in line for line in rest), words
        assert any("viscosity of the yarn takes more than half" in line for line in rest), words


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        ("scene.toml", "run scene.toml --no-report --out ."),
        ("rows.toml", "run rows.toml --batch batch.csv --out ."),
        ("scene.toml", "run scene.toml --no-report --capsule link.toml"),
        ("scene.toml", "run scene.toml --no-report --capsule here/../scene.toml"),
        ("rows.toml", "run rows.toml --no-report --out here --capsule here/history.csv"),
        ("shots.csv", "v50 shots.csv --out here/.."),
        ("runs.jsonl", "residual runs.jsonl --out ."),
        ("table.h", "fragments table.h --out ."),
    ],
)
def test_what_a_command_reads_is_not_written_over(tmp_path, scene, words):
    (tmp_path / scene).write_text(SMALL)
    (tmp_path / "batch.csv").write_text("seed\n1\n")
    (tmp_path / "here").mkdir()
    (tmp_path / "link.toml").symlink_to("scene.toml")
    before = sorted(tmp_path.rglob("*"))
    done = ran(*words.split(), cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert "would be written over" in done.stderr
    assert (tmp_path / scene).read_text() == SMALL
    assert sorted(tmp_path.rglob("*")) == before


def test_a_run_takes_another_speed_and_seed(tmp_path):
    words = ("run", "sheet_3in_sphere", "--speed", "70", "--seed", "9", "--steps", "100", "--until", "none", "--no-report")
    done = ran(*words, "--out", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    scene = fk.Scene.read(str(tmp_path / "out/scene.toml"))
    assert (scene["seed"], scene["projectile.velocity"]) == (9, (0.0, 0.0, 70.0))
    assert "--speed: must be a number above 0" in ran("run", "sheet_3in_sphere", "--speed", "-1").stderr


def test_a_folder_has_the_files_of_its_last_run_alone_and_a_report_is_of_one_run(tmp_path):
    for seed in (1, 2):
        (tmp_path / f"{seed}.toml").write_text(f"{SMALL}seed = {seed}\n")
    short, out = ["--steps", "128", "--until", "none"], tmp_path / "out"
    assert ran("run", "1.toml", *short, "--movie", "--vtk", "--out", "out", cwd=tmp_path).returncode == 0
    (out / "mine.txt").write_text("mine")
    assert ran("run", "2.toml", *short, "--no-report", "--out", "out", cwd=tmp_path).returncode == 0
    files = {"history.csv", "scene.toml", "state.gz", "summary.json"}
    assert {path.name for path in out.rglob("*") if path.is_file()} == files | {"mine.txt"}
    assert ran("run", "1.toml", *short, "--no-report", "--out", "other", cwd=tmp_path).returncode == 0
    assert ran("run", "1.toml", "--steps", "64", "--until", "none", "--no-report", "--out", "less", cwd=tmp_path).returncode == 0
    for name in files:
        whole = (out / name).read_bytes()
        others = [(tmp_path / "other" / name).read_bytes()] if name == "state.gz" else []
        others += [(tmp_path / "less" / name).read_bytes()] if name == "history.csv" else []
        # In the middle of a value, or what is left of a scene is one.
        cut = whole.find(b" = ", len(whole) // 2) + 3 if name == "scene.toml" else len(whole) // 2
        others += [whole[:-9]] if name == "history.csv" else []
        for other in (whole[:cut], b'{"a": 1}', b"\xff", *others):
            (out / name).write_bytes(other)
            done = ran("report", out)
            assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
            assert any(str(out / file) in done.stderr for file in (name, "state.gz"))
        (out / name).write_bytes(whole)
    assert ran("report", out).returncode == 0
    # A run that fails leaves its history, and nothing of the run before.
    (tmp_path / "2.toml").write_text(SMALL + "contact_capacity = 1\n")
    assert ran("run", "2.toml", "--out", "out", cwd=tmp_path).returncode == 1
    assert {path.name for path in out.iterdir()} == {"history.csv", "mine.txt", "vtk"}
    # Another command has a folder of its own, and keeps there what it has not written again.
    plan = ["1.toml", "--design", "plan", "--plan", "200", "--simulated", "0", "--out", "limit"]
    assert ran("v50", *plan, cwd=tmp_path).returncode == 0
    assert ran("v50", "1.toml", "--at", "200", "--shots", "1", "--out", "limit", cwd=tmp_path).returncode == 0
    limit = {path.name for path in (tmp_path / "limit").iterdir()}
    assert limit == {"report.html", "at.json", "runs.jsonl", "shot_at.toml"}
    for words in (
        ["run", "1.toml", "--out", "limit"],
        ["residual", "1.toml", "--out", "limit"],
        ["v50", "1.toml", "--out", "other"],
        ["compare", "1.toml", "2.toml", "--out", "other"],
        ["compare", "1.toml", "2.toml", "--out", "limit"],
        ["tests", "1.toml", "--out", "limit"],
    ):
        assert "has the results of another" in ran(*words, cwd=tmp_path).stderr


def drawn_again(folder):
    """`fabric report` of a folder gives what was there, byte by byte, and of nothing else but what was saved."""
    kinds = (".html", ".svg", ".png")
    before = {path: path.read_bytes() for path in folder.iterdir() if path.suffix in kinds}
    for path in before:
        path.unlink()
    done = ran("report", folder)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert {path: path.read_bytes() for path in folder.iterdir() if path.suffix in kinds} == before


# As a spreadsheet writes it, with a mark of its encoding and empty rows.
TABLE = "\ufeffprojectile.velocity[2],seed,sheet.nodes_x,yarn.stochastic,\r\n300,1,,TRUE,\r\n250,2, 33,true,\r\n,,,,\r\n,\r\n"


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
    assert [row["digest"] for row in json.loads(done.stdout)] == [row.digest for row in flown]
    with (tmp_path / "many" / "batch.csv").open() as file:
        assert [row["digest"] for row in csv.DictReader(file)] == [row.digest for row in flown]


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
        ('seed,projectile.mass\n1,"16 g\n2,3\n', "rows.csv: no CSV: unexpected end of data"),
        ('seed\n"1\nseed = 7"\n', "row 1: seed = "),
        ("seed\n1 # 2\n", 'row 1: seed = "1 # 2"'),
        ('projectile.velocity[2],projectile.velocity\n300,"[0, 0, 100]"\n', "or the whole of projectile.velocity"),
        ('projectile.velocity,projectile.velocity[2]\n"[0, 0, 100]",300\n', "or the whole of projectile.velocity"),
        ('sheet,sheet.nodes_x\n"{""nodes_x"": 33}",35\n', "sheet.nodes_x: give it or the whole of sheet"),
        ("seed[0]\n1\n", "row 1: unknown key `seed[0]`"),
        ("projectile.faces.planes[0][1]\n1\n", "row 1: unknown key `projectile.faces.planes[0][1]`"),
        ("seed,,\n1,x,\n", "row 1: a cell is in a column without a name"),
        ("projectile.velocity\n" + 9999 * "[" + "\n", "row 1: projectile.velocity = "),
        ("seed\n1\xb5\n", "rows.csv: no text in UTF-8"),
        ("\xff\xfes\0", "rows.csv: no text in UTF-8"),
    ],
)
def test_a_row_of_a_batch_that_is_refused_is_named_and_nothing_is_written(tmp_path, table, reason):
    (tmp_path / "shot.toml").write_text(SMALL)
    (tmp_path / "rows.csv").write_text(table, encoding="latin-1")
    done = ran("run", "shot.toml", "--batch", "rows.csv", "--out", "many", cwd=tmp_path)
    assert done.returncode == 2
    assert reason in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "many").exists()


@pytest.mark.parametrize(
    ("text", "stdin"),
    [
        ("\ufeff" + SMALL, False),
        (SMALL, True),
        (SMALL.replace("31,", "31,\n") + '# µ\nprojectile.position = [0.0, 0.0, "-6351 µm"]\n', False),
    ],
)
def test_one_parser_reads_a_scene_once_whatever_the_locale(tmp_path, text, stdin):
    """TOML 1.1 with a line break in a table; a pipe, which cannot be read twice."""
    (tmp_path / "shot.toml").write_text(text, encoding="utf-8")
    plain = {**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": ""}
    file = "/dev/stdin" if stdin else "shot.toml"
    for words in (["run", file, "--steps", "8", "--until", "none", "--no-report"], ["v50", file, "--at", "300", "--shots", "1"]):
        with (tmp_path / "shot.toml").open() as given:
            cat = subprocess.Popen(["cat"], stdin=given, stdout=subprocess.PIPE)
        done = ran(*words, cwd=tmp_path, stdin=cat.stdout, env=plain)
        cat.wait()
        assert (done.returncode, done.stderr) == (0, ""), done.stderr
    scene = fk.Scene.read(tmp_path / "shot.toml")
    assert scene == fk.Scene.parse(text)
    assert scene.label == scene.replace(seed=3).label == "sheet_3in_sphere"
    assert fk.Scene(fabric={"name": "kevlar_km2_s706"}).label == "kevlar_km2_s706"


@pytest.mark.parametrize("name", [b"a$x$b.toml", rb"a$\fracx$_{.toml", b"b\xff.toml"])
def test_a_name_of_any_bytes_has_its_report(tmp_path, name):
    file = os.fsdecode(name)
    (tmp_path / file).write_text(SMALL + FAST)
    attitudes = ["--attitudes", f"{file} */=1,0,0,0", "--velocities", "200", "300", "--shots", "1", "--table"]
    for words in (["run", file], ["v50", file, "--design", "plan", "--plan", "300"], ["fragments", file, *attitudes]):
        done = ran(*words, "--out", words[0], cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert (tmp_path / words[0] / "report.html").exists()
    assert (tmp_path / "fragments" / "table.h").read_text().count("*/") == 4


@pytest.mark.parametrize("stdout", ["/dev/full", "closed"])
def test_files_come_first_where_nothing_can_be_printed_and_a_full_disk_is_a_failure(tmp_path, stdout):
    (tmp_path / "shot.toml").write_text(SMALL + FAST)
    for words, file in (
        (["run", "shot.toml", "--no-report", "--steps", "8", "--until", "none"], "summary.json"),
        (["run", "shot.toml", "--no-report", "--steps", "8", "--until", "none", "--json"], "summary.json"),
        (["v50", "shot.toml", "--at", "300", "--shots", "1"], "report.html"),
        (["--completion"], ""),
    ):
        command = [*PROGRAM, *words, *(["--out", f"out{len(words)}"] if file else [])]
        to = ">&-" if stdout == "closed" else f">{stdout}"
        done = subprocess.run(["sh", "-c", f'"$@" {to}', "sh", *command], stderr=subprocess.PIPE, text=True, cwd=tmp_path)
        assert done.returncode == 1, done.stderr
        assert done.stderr.splitlines()[-1].startswith("error: standard output: ")
        assert not file or (tmp_path / f"out{len(words)}" / file).exists()
    done = ran("run", "shot.toml", "--no-report", "--steps", "8", "--out", "out", "--capsule", "/dev/full", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "error: capsule: the file cannot be written\n")
    # A file may not be larger than a sheet, as on a disk that is full.
    small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))
    done = ran("run", "shot.toml", "--vtk", "--steps", "8", "--out", "out", cwd=tmp_path, preexec_fn=small)
    assert done.returncode == 1
    assert re.fullmatch(r"error: out/vtk/sheet_\w+\.vtp: File too large\n", done.stderr)


def test_a_run_that_is_stopped_leaves_nothing(tmp_path):
    (tmp_path / "shot.toml").write_text(SMALL + "projectile.velocity = [0.0, 0.0, 0.0]")
    # What takes its time to load is there before the alarm.
    importlib.import_module("fabric_kernel.run")
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.5)
    main = lambda words: program.main(["run", *words])
    _, errors, code = called(tmp_path, main, str(tmp_path / "shot.toml"), "--steps", "1000000000")
    assert (code, errors) == (130, "interrupted: nothing is written\n")
    assert not (tmp_path / "out").exists()
    signal.setitimer(signal.ITIMER_REAL, 0.5)
    capsule = str(tmp_path / "capsule")
    _, errors, code = called(tmp_path, main, str(tmp_path / "shot.toml"), "--steps", "1000000000", "--capsule", capsule)
    signal.signal(signal.SIGALRM, before)
    assert (code, errors) == (130, f"interrupted: what there was until then is in {capsule}\n")


@pytest.mark.parametrize("name", ["rough_sphere", "turned_plies", "hybrid_pack"])
def test_balances_of_scenes_with_friction_and_plies_close(name):
    row = fk.fly(fk.Scene.read(SCENES / f"{name}.toml"))
    assert row.outcome == "exited"
    assert abs(row.energy_residual) < 0.01 * row.impact_energy, name


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


@pytest.mark.parametrize("words", ["run", "v50", "v50 --at 90", "residual", "fragments", "fragments --velocities 90", "scene"])
def test_a_scene_that_is_refused_is_named_by_every_command(tmp_path, words):
    for text in ("projectile.mass = 0.0", "projectile.weight = 1"):
        (tmp_path / "shot.toml").write_text(SMALL + text)
        command, *others = words.split()
        done = ran(command, "shot.toml", *others, cwd=tmp_path)
        assert re.match(r"error: shot.toml: (projectile.mass|unknown key)", done.stderr) or (done.returncode, command) == (
            0,
            "scene",
        )


MISTYPED = (
    "fly; run; run no_preset; run none.toml; run .; run shot.toml --steps 0; run shot.toml --steps many; run shot.toml "
    "--sample -1; run shot.toml --until stopped; run shot.toml --until=; run shot.toml another.toml; run shot.toml --out "
    "locked/out; run shot.toml --steps 1000000000 --out /proc/x; run shot.toml --capsule no/folder/capsule; run shot.toml "
    "--colour; run shot.toml --steps 64 --steps=65; run shot.toml --batch none.csv; run shot.toml --batch none.csv --movie; "
    "v50 shot.toml --confidence 1.5; v50 shot.toml --shots 0; v50 shot.toml --low fast --high 90; v50 shot.toml --low 50; v50 "
    "shot.toml --plan 90; residual shot.toml --shots 2; replay shot.toml; residual shot.toml --velocities 100 fast; residual "
    "shot.toml --out /proc/x; replay none; replay; report .; report shot.toml; fabrics denim; scene none.toml; fragments "
    "shot.toml --attitudes a=1,0,0,0 a=0,1,0,0; fragments shot.toml --shots 0; fragments shot.toml --point 0,0; fmu shot.toml "
    "--from shot.toml; fmu shot.toml -o here"
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
    assert done.stderr.startswith("warning: The projectile met the sheet beyond the fine part")


def test_a_reader_that_has_gone_is_no_traceback(tmp_path):
    (tmp_path / "shot.toml").write_text(SMALL)
    run = ["run", "shot.toml", "--steps", "64", "--until", "none", "--no-report"]
    fragments = ["fragments", "shot.toml", "--velocities", "90", "--shots", "1"]
    for words in [run, fragments, ["fabrics"], ["fabrics", "kevlar_km2_s706"], ["scene", "sheet_3in_sphere"], ["scene"]]:
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


@pytest.mark.parametrize(
    ("typed", "offered"),
    [("fabric re", {"residual", "report", "replay"}), ("fabric v50 --conf", {"--confidence"}), ("fabric run r", {"ring_40in"})],
)
def test_a_shell_completes_commands_options_and_presets(typed, offered):
    words = typed.split()
    script = ran("--completion").stdout + f"COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; _fabric; echo ${{COMPREPLY[*]}}"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert (set(done.stdout.split()), done.stderr) == (offered, "")

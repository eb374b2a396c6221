"""FMUs of one's own scenes: `fabric fmu` puts a scene into the FMUs of a release."""

import contextlib
import io
import json
import os
import pathlib
import re
import struct
import tomllib
import zipfile

import fabric_kernel as fk
import fmpy
import pytest
from component import FILE
from fabric_kernel import fmu
from fmpy.ssp.ssd import read_ssd
from fmpy.validation import validate_fmu
from host import ARCHIVES, EXAMPLES, TARGET, WARNING, Host, filled, opened
from lxml import etree
from test_platforms import HERE, Loader

CRIMPED = """
fabric = { name = "kevlar_km2_s706", warp.crimp = 0.0065, weft.crimp = 0.0025 }
sheet = { nodes_x = 81, nodes_y = 81 }
contact.friction = 0.2
projectile = { mass = 8.4e-4, radius = 2.8e-3 }
aim.speed = 150
"""
RING = 'preset = "ring_40in"\nsheet.nodes_y = 41\n'
TILTED = EXAMPLES / "scenes" / "tilted_disc_sector.toml"
# Each with so many steps that the projectile touches the sheet.
SCENES = {
    "Pack": (fk.Scene.read(EXAMPLES / "scenes" / "hybrid_pack.toml"), 600),
    "Ring": (fk.Scene.parse(RING), 600),
    "TiltedDiscSector": (fk.Scene.read(TILTED), 6000),
    "Crimped": (fk.Scene.parse(CRIMPED), 600),
    "Paper": (fk.Scene("sheet_10in_cylinder"), 200),
}


def flat(value):
    return [x for row in value for x in (row if isinstance(row, tuple) else [row])] if isinstance(value, tuple) else value


def of_package(scene, steps):
    """Time, and outputs of the package by the FMU's names."""
    simulation = fk.Simulation(scene)
    simulation.step(steps)
    contact, body, support, energy = simulation.contact(), simulation.projectile(), simulation.support(), simulation.energy()
    counters = simulation.counters()
    outputs = {
        "contact.work": contact["work"],
        "contact.force_peak": contact["force_peak"],
        "state.velocity": body["velocity"],
        "state.angular_velocity": body["angular_velocity"],
        "support.impulse": support["total"],
        "support.attachment_impulse": support["attachments"],
        "energy.kinetic": energy["fabric_kinetic"],
        "energy.strain": energy["strain"],
        "energy.dissipated": energy["dissipated"],
        "energy.contact_loss": energy["contact_loss"],
        "energy.residual": energy["residual"],
        "fabric.failed_segments": counters["failed_segments"],
        "fabric.worst_penetration": counters["worst_penetration"],
    }
    return simulation.time, {name: flat(value) for name, value in outputs.items()}


def changed(archive, change, path):
    """An archive with other entries: `change` gets a name and bytes."""
    with zipfile.ZipFile(archive) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            new.writestr(name, change(name, old.read(name)))
    return path


def ran(*words):
    """What `fabric fmu` says of mistakes, and its exit status."""
    with contextlib.redirect_stderr(io.StringIO()) as errors, contextlib.redirect_stdout(io.StringIO()):
        try:
            fmu.main([str(word) for word in words])
        except SystemExit as left:
            return left.code, errors.getvalue()
    return 0, errors.getvalue()


def test_an_fmu_of_a_scene_gives_the_bits_of_the_package():
    for name, (scene, steps) in SCENES.items():
        time, package = of_package(scene, steps)
        assert package["contact.work"] > 0.0, name
        for version, component in ((2, False), (3, False), (3, True)):
            archive = filled(version, scene, name)
            if component and not pathlib.Path(opened(3, archive)[1], FILE.format(name)).exists():
                continue
            host = Host(version, {}, archive=archive, component=component)
            assert host.step(0.0, time) <= WARNING, host.log
            assert {name: host.get(name) for name in package} == package


def test_start_values_are_those_of_the_description_and_written_back_change_nothing():
    for name in ("Pack", "TiltedDiscSector", "Crimped"):
        for version in (2, 3):
            archive = filled(version, SCENES[name][0], name)
            assert validate_fmu(str(archive)) == []
            description = opened(version, archive)[0]
            assert (description.modelName, description.coSimulation.modelIdentifier) == (name, name)
            host, values = Host(version, {}, archive=archive), {}
            for variable in (v for v in description.modelVariables if v.causality == "parameter"):
                number = lambda text: {"true": 1.0, "false": 0.0}.get(text) if text in ("true", "false") else float(text)
                found = values[variable.name] = host.get(variable.name)
                said = [number(text) for text in variable.start.split()]
                assert said == (found if isinstance(found, list) else [found]), variable.name
            # All set, none set, and all set in the FMU of the release.
            others = [Host(version, values, archive=archive), Host(version, values)]
            for one in (host, *others):
                one.run(0, 5, 1e-6)
                assert one.outputs() == host.outputs(), (name, version)
            assert host.image() == others[0].image()
            assert host.image() != others[1].image()


def test_the_page_has_the_scene():
    body = tomllib.loads(TILTED.read_text())["projectile"]
    with zipfile.ZipFile(filled(2, SCENES["TiltedDiscSector"][0], "TiltedDiscSector")) as files:
        page = files.read("documentation/index.html").decode()
        assert not [name for name in files.namelist() if name.startswith("documentation/parameters")]
    for text in (
        "<h1>TiltedDiscSector</h1>",
        '"TiltedDiscSector-fmi2.fmu"',
        repr(body["sector"]["thickness"]),
        "Projectile: disc sector",
    ):
        assert text in page
    assert "FabricShield" not in page
    etree.fromstring(re.search(r'<figure id="scene">.*?</figure>', page, re.DOTALL)[0])


def test_archives_of_two_folders_are_equal_and_a_filled_one_is_filled_again(tmp_path):
    (tmp_path / "mine.toml").write_text(CRIMPED)
    here = os.getcwd()
    for folder, source in ((tmp_path / "a", TARGET / "fmu"), (tmp_path / "b" / "c", TARGET / "fmu"), (tmp_path / "d", None)):
        folder.mkdir(parents=True)
        os.chdir(folder)
        try:
            for version in (2, 3):
                source_of = source or filled(version, SCENES["Pack"][0], "Pack")
                assert ran(tmp_path / "mine.toml", "--version", version, "--from", source_of) == (0, "")
        finally:
            os.chdir(here)
    for version in (2, 3):
        a, *others = [(tmp_path / at / f"Mine-fmi{version}.fmu").read_bytes() for at in ("a", "b/c", "d")]
        assert others == [a, a]


def test_a_damaged_scene_and_one_of_another_version_are_refused_at_instantiation(version, tmp_path):
    archive = filled(version, SCENES["Crimped"][0], "Crimped")
    for place, reason in ((24, "another version"), (32, "damaged"), (40, "damaged"), (48, "damaged"), (48 + 1000, "damaged")):

        def flipped(name, data):
            at = data.find(fmu.MARK)
            return data if at < 0 else data[: at + place] + bytes([data[at + place] ^ 1]) + data[at + place + 1 :]

        log = []
        with pytest.raises(Exception):  # noqa: B017  (what FMPy raises)
            Host(version, {}, archive=changed(archive, flipped, tmp_path / f"{version}-{place}.fmu"), log=log)
        assert any(reason in text for _, _, text in log), (place, log)


def test_a_package_of_ssp_follows_the_schema_and_has_the_scene(tmp_path):
    (tmp_path / "mine.toml").write_text(CRIMPED)
    words = [tmp_path / "mine.toml", "--from", TARGET / "fmu", "--out", tmp_path, "--ssp"]
    assert ran(*words) == (0, "")
    with zipfile.ZipFile(tmp_path / "Mine.ssp") as package:
        for name, schema in (("SystemStructure.ssd", "Description"), ("resources/Mine.ssv", "ParameterValues")):
            path = pathlib.Path(fmpy.__file__).parent / f"ssp/schema/SystemStructure{schema}.xsd"
            root = etree.fromstring(package.read(name))
            etree.XMLSchema(etree.parse(str(path))).assertValid(root)
        values = {one.get("name"): one[0].get("value") for one in root.iter("{*}Parameter")}
        assert package.read("resources/Mine.fmu") == (tmp_path / "Mine-fmi2.fmu").read_bytes()
    with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.redirect_stderr(io.StringIO()):
        fmu.main([*map(str, words), "--json"])
    assert json.loads(said.getvalue()) == {str(path): path.stat().st_size for path in tmp_path.glob("Mine[-.]*[up]")}
    assert (values["sheet.nodes_x"], values["contact.friction"], values["yarn.stochastic"]) == ("81", "0.2", "false")
    assert read_ssd(str(tmp_path / "Mine.ssp")).system.elements[0].name == "shield"
    assert ran(*words, "--version", 3)[0] == 2


def test_mistakes_are_refused_and_nothing_is_written(tmp_path):
    scene, out, source = tmp_path / "mine.toml", tmp_path / "out", ["--from", ARCHIVES[2]]
    scene.write_text(CRIMPED)
    bad = tmp_path / "bad.toml"
    bad.write_text(CRIMPED + "seed = 3000000000\n")
    heavy = tmp_path / "heavy.toml"
    heavy.write_text(CRIMPED.replace("mass = 8.4e-4", "mass = 0.0"))
    other = changed(
        ARCHIVES[2],
        lambda name, data: data.replace(f' version="{fk.VERSION}"'.encode(), b' version="0.0.9"'),
        tmp_path / "other.fmu",
    )
    layout = struct.pack("<II", len(fk.Scene().words()), 1)
    older = changed(ARCHIVES[2], lambda name, data: data.replace(fmu.MARK + layout, fmu.MARK + bytes(8)), tmp_path / "older.fmu")
    none = changed(ARCHIVES[2], lambda name, data: data.replace(fmu.MARK, bytes(16)), tmp_path / "none.fmu")
    swap = lambda data: re.sub(
        rb'"sheet.nodes_([xy])" v', lambda found: b'"sheet.nodes_%s" v' % {b"x": b"y", b"y": b"x"}[found[1]], data
    )
    order = changed(
        ARCHIVES[2], lambda name, data: swap(data) if name == "modelDescription.xml" else data, tmp_path / "order.fmu"
    )
    foreign = tmp_path / "foreign.fmu"
    with zipfile.ZipFile(foreign, "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription/>")
    flipped, mine = tmp_path / "flipped.fmu", tmp_path / "Mine-fmi2.fmu"
    mine.write_bytes(ARCHIVES[2].read_bytes())
    flipped.write_bytes(order.read_bytes().replace(b"<fmiModelDescription ", b"<fmiModelDescriptiom "))
    cut = {
        "modelDescription.xml": lambda data: data[:3000],
        "documentation/index.html": lambda data: data[:3000] + b"\xff",
        "binaries/": lambda data: data[: data.index(fmu.MARK) + 40],
    }
    parts = [
        changed(
            ARCHIVES[2],
            lambda name, data, begin=begin, of=of: of(data) if name.startswith(begin) else data,
            tmp_path / f"cut{begin[:3]}.fmu",
        )
        for begin, of in cut.items()
    ]
    file = tmp_path / "file"
    file.write_text("")
    for words, reason in [
        ([tmp_path / "missing.toml", *source], "missing.toml"),
        ([heavy, *source], "projectile.mass"),
        ([bad, *source], "seed: 3000000000"),
        ([scene, "--from", other], "version 0.0.9"),
        ([scene, "--from", older], "another version"),
        ([scene, "--from", none], "takes no scene"),
        ([scene, "--from", order], "another order"),
        ([scene, "--from", foreign], "no FMU of fabric: it has no documentation/index.html"),
        ([scene, "--from", scene], "damaged, or no FMU: File is not a zip file"),
        ([scene, "--from", flipped], "damaged, or no FMU: Bad CRC-32 for file 'm"),
        ([scene, "--from", parts[0]], "modelDescription.xml is damaged"),
        ([scene, "--from", parts[1]], "documentation/index.html is damaged: 'utf-8'"),
        ([scene, "--from", parts[2]], "is cut off"),
        ([scene, "--from", mine, "--out", tmp_path], "would be written over"),
        ([scene, "--from", tmp_path], "FabricShield-fmi2.fmu"),
        ([scene, *source, "--version", 3], "FMI 2.0"),
        ([scene, *source, "--name", "my shield"], "my shield"),
        ([scene, *source, "--name", "while"], "word of C"),
        ([scene, *source, "--name", "FabricShield"], "not FabricShield"),
        ([scene, *source, "--out", file / "below"], "below"),
    ]:
        status, said = ran(*words, *([] if "--out" in words else ["--out", out]))
        assert status == 2, words
        assert reason in said
        assert not out.exists(), words


def test_the_libraries_of_other_platforms_take_the_scene(tmp_path):
    left = []
    archives = {version: filled(version, SCENES["TiltedDiscSector"][0], "TiltedDiscSector") for version in (2, 3)}
    here = Loader(HERE, tmp_path)
    for platform in ("linux64", "win64", "aarch64-linux"):
        try:
            there = Loader(platform, tmp_path)
        except pytest.skip.Exception as reason:
            left.append(str(reason))
            continue
        for version, archive in archives.items():
            lines = [loader.run(version, "save", tmp_path / "state", archive) for loader in (here, there)]
            assert lines[0] == lines[1], (platform, version)
    print(*[f"\n  left out: {reason}" for reason in left], end="")

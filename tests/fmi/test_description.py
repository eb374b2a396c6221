"""Both model descriptions: a second checker, and what neither it nor FMPy's validator (test_archive.py) with the official schemas
sees."""

import logging
import zipfile

from host import ARCHIVES, ERROR, OK, SMALL, WARNING, Host, hosts, opened
from lxml import etree


def tree(version):
    with zipfile.ZipFile(ARCHIVES[version]) as packed:
        return etree.fromstring(packed.read("modelDescription.xml"))


def variables(version):
    return list(tree(version).find("ModelVariables"))


def stated(root, version, part):
    """What each unknown is said to depend on: names by name; None for all."""
    structure = root.find("ModelStructure")
    if version == 2:
        unknowns, key = structure.find(part), "index"
        names = {str(k + 1): v.get("name") for k, v in enumerate(root.find("ModelVariables"))}
    else:
        unknowns, key = structure.findall(part.removesuffix("s")), "valueReference"
        names = {v.get("valueReference"): v.get("name") for v in root.find("ModelVariables")}
    lists = {names[unknown.get(key)]: unknown.get("dependencies") for unknown in unknowns}
    return {name: None if text is None else {names[word] for word in text.split()} for name, text in lists.items()}


def test_the_second_checker_finds_nothing():
    from fmu_manipulation_toolbox.checker import OperationGenericCheck, OperationSemanticCheck
    from fmu_manipulation_toolbox.operations import FMU

    logging.getLogger("fmu_manipulation_toolbox").setLevel(logging.CRITICAL)
    for version, archive in ARCHIVES.items():
        fmu, schema, rules = FMU(str(archive)), OperationGenericCheck(), OperationSemanticCheck()
        fmu.apply_operation(schema)
        fmu.apply_operation(rules)
        assert schema.compliant_with_version == f"{version}.0"
        assert rules.errors == []
    print("\nfigure 25: fmu-manipulation-toolbox: 0 errors", flush=True)


def test_the_model_structure_lists_the_outputs_each_once():
    two = tree(2)
    indices = [str(k + 1) for k, v in enumerate(variables(2)) if v.get("causality") == "output"]
    for name in ("Outputs", "InitialUnknowns"):
        assert [u.get("index") for u in two.find("ModelStructure").find(name)] == indices
    three = tree(3)
    references = [v.get("valueReference") for v in variables(3) if v.get("causality") == "output"]
    for name in ("Output", "InitialUnknown"):
        assert [u.get("valueReference") for u in three.find("ModelStructure").findall(name)] == references


def test_both_versions_have_one_token_which_the_library_takes():
    assert tree(2).get("guid") == tree(3).get("instantiationToken")
    list(hosts())


def test_every_real_has_a_unit_of_known_dimension():
    for version, real in ((2, "Real"), (3, "Float64")):
        root = tree(version)
        units = {unit.get("name"): unit for unit in root.find("UnitDefinitions")}
        for unit in units.values():
            assert unit.find("BaseUnit") is not None
        types = {t.get("name"): t[0] if version == 2 else t for t in root.find("TypeDefinitions")}
        for variable in variables(version):
            typed = variable[0] if version == 2 else variable
            if typed.tag == real:
                declared = types[typed.get("declaredType")]
                assert declared.get("unit") == typed.get("unit")
                assert typed.get("unit") in units
                shown = declared.get("displayUnit")
                assert shown in [None] + [d.get("name") for d in units[typed.get("unit")].findall("DisplayUnit")]
                assert float(typed.get("nominal") or declared.get("nominal")) > 0.0


def test_choices_are_integers_with_a_range_in_2_and_enumerations_in_3():
    """libcosim and ecos pass over enumerations of FMI 2.0."""
    two, three = ({v.get("name"): v for v in variables(version)} for version in (2, 3))
    choices = [name for name, v in three.items() if v.tag == "Enumeration"]
    assert len(choices) > 8
    for name in choices:
        assert two[name][0].tag == "Integer"
        items = next(t for t in tree(3).find("TypeDefinitions") if t.get("name") == three[name].get("declaredType"))
        assert (two[name][0].get("min"), two[name][0].get("max")) == ("0", str(len(items) - 1))
        for item in items:
            assert f"{item.get('value')} {item.get('name')} (" in two[name].get("description")
    assert "Enumeration" not in {v[0].tag for v in two.values()}


def test_log_categories_and_default_experiment(version):
    root, host = tree(version), Host(version)
    names = [category.get("name") for category in root.find("LogCategories")]
    assert host.attempt(host.fmu.setDebugLogging, True, names) == OK
    for name in names:
        assert host.attempt(host.fmu.setDebugLogging, True, [name]) == OK
    experiment = root.find("DefaultExperiment")
    assert [experiment.get(k) for k in ("startTime", "stopTime", "stepSize")] == ["0.0", "0.0006", "1e-6"]


def test_what_lies_outside_min_and_max_is_refused():
    """Whether the scene reads the parameter or not."""
    tried = 0
    for variable in opened(2)[0].modelVariables:
        if variable.causality != "parameter" or variable.type != "Real":
            continue
        least = variable.min or variable.declaredType.min
        greatest = variable.max or variable.declaredType.max
        outside = [float("nan")]
        outside += [float(least) - 0.5] if least is not None else []
        outside += [float(greatest) + 0.5] if greatest is not None else []
        for value in outside:
            host = Host(2)
            status = host.begin({**SMALL, variable.name: value})
            status = max(status, host.attempt(host.fmu.exitInitializationMode) if status <= WARNING else OK)
            assert status == ERROR, (variable.name, value)
            assert variable.name.split("[")[0] in host.log[-1][2]
            tried += 1
    assert tried > 40

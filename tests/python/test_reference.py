"""`help` is the reference: every public name has a docstring with its arguments, and no signature has Any."""

import dataclasses
import inspect
import re

import fabric_kernel as fk
import pytest
from fabric_kernel import extras, runs

PUBLIC = {name: value for name in fk.__all__ if callable(value := getattr(fk, name))}
"""Functions and classes of the package."""
CALLED = {name: value for name, value in PUBLIC.items() if inspect.isfunction(value) or name in ("Flight", "Neyer", "Shooter")}


def named(doc, argument):
    """Whether a section of parameters or fields has this argument."""
    return re.search(rf"^(\w+, )*{argument}(, \w+)*( :|$)", doc, re.MULTILINE)


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_a_docstring(name):
    assert inspect.getdoc(PUBLIC[name])


@pytest.mark.parametrize("name", CALLED)
def test_each_argument_is_documented_and_none_is_any(name):
    if PUBLIC[name].__module__ == "fabric_kernel.runs" and dataclasses.is_dataclass(PUBLIC[name]):
        assert all(field.type.__metadata__[0] for field in dataclasses.fields(PUBLIC[name]))
    doc, signature = inspect.getdoc(PUBLIC[name]), inspect.signature(PUBLIC[name])
    for argument in signature.parameters.values():
        assert named(doc, argument.name), argument
        assert "Any" not in str(argument.annotation), argument
    assert "Any" not in str(signature.return_annotation)


def test_results_are_frozen_and_every_field_has_a_meaning():
    row = fk.fly(fk.Scene("sheet_3in_sphere", sheet={"nodes_x": 11, "nodes_y": 11}), steps=5)
    with pytest.raises(dataclasses.FrozenInstanceError):
        row.speed = 0.0
    assert runs.with_attrs(extras.pandas.DataFrame([row])).attrs["units"]["absorbed"] == "J"
    for field in dataclasses.fields(row):
        assert re.search(rf"^{field.name}\n    \S", fk.Flight.__doc__, re.MULTILINE), field.name


def test_a_missing_library_names_its_extra(monkeypatch):
    for library, extra in extras.EXTRAS.items():
        monkeypatch.setitem(__import__("sys").modules, library, None)
        with pytest.raises(ModuleNotFoundError, match=rf"^{library} is missing: pip install 'fabric-kernel\[{extra}\]'$"):
            getattr(extras, library)


def test_a_warning_has_a_kind():
    with pytest.warns(fk.ModelWarning) as said:
        fk.fly(fk.Scene("sheet_3in_sphere", step_check="none", sheet={"nodes_x": 11, "nodes_y": 11}), steps=2)
    assert "step_unchecked" in [one.message.kind for one in said]


def test_fields_have_names_and_units():
    pytest.importorskip("xarray")
    simulation = fk.Simulation(fk.Scene("sheet_3in_sphere", sheet={"nodes_x": 13, "nodes_y": 11}))
    simulation.step(4)
    fields = simulation.to_xarray()
    assert dict(fields.sizes) == {"ply": 1, "row": 11, "column": 13, "axis": 3, "segment_x": 12, "segment_y": 10}
    assert (fields.position.sel(axis="z").values[0] == simulation.positions()[..., 2]).all()
    assert (fields.position.units, fields.attrs["time"]) == ("m", simulation.time)

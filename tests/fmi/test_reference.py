"""The reference results in examples/reference: their first rows here, the whole run in `cargo xtask verify`."""

import reference

ROWS = 5  # 40 us; the 10 in sheet takes a while


def test_both_fmus_begin_as_the_files_say():
    header, *expected = reference.read("FabricShield_ref.csv")
    assert header == ["time", *reference.columns(reference.OUTPUTS)]
    assert len(expected) == 101
    assert float(expected[4][header.index("contact.work")]) > 0.1
    # Without inputs, and with those of the input file: the same.
    for version, values in ((2, {}), (3, reference.start_values())):
        assert reference.rows(version, ROWS, values) == expected[:ROWS]


def test_inputs_and_options_are_those_of_the_default_run():
    assert reference.read("FabricShield_in.csv") == reference.inputs()
    assert (reference.FOLDER / "FabricShield_ref.opt").read_text() == reference.options()

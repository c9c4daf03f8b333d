"""Every quirk of a simulated drive has a source or is a guess, in its table and on its page."""

from __future__ import annotations

import pytest
from pages import page

from armdrive.errors import BadRequest
from armdrive.sim.bus.node import Quirk, options_of
from armdrive.sim.cia402 import QUIRKS as CIA402
from armdrive.sim.device import Options
from armdrive.sim.mks import QUIRKS as MKS

PAGE = page("simulating")
EACH = [*(("mks", quirk) for quirk in MKS), *(("cia402", quirk) for quirk in CIA402)]
LIMITED = Quirk("answer_ms", 0.2, "milliseconds", "nobody", above_zero=True, most=50.0)


@pytest.mark.parametrize(("kind", "quirk"), EACH, ids=lambda each: getattr(each, "name", each))
def test_a_quirk_is_on_its_page_as_it_is_in_its_table(kind, quirk):
    section = PAGE.split("## CiA 402 drives")[kind == "cia402"]
    (row,) = [line for line in section.splitlines() if line.startswith(f"| `{quirk.name}` |")]
    assert quirk.does in row
    assert quirk.source
    says = f"**guess**: {quirk.source}" if quirk.guess else quirk.source
    assert row.endswith(f"| {says} |")
    assert ("| always |" in row) is (quirk.default is None)


@pytest.mark.parametrize("table", [MKS, CIA402])
def test_names_are_unique_and_what_is_always_so_is_no_setting(table):
    assert len({quirk.name for quirk in table}) == len(table)
    settings = {option.name for option in options_of(table)}
    assert settings == {quirk.name for quirk in table if quirk.default is not None}


@pytest.mark.parametrize(
    ("value", "fits"), [(0.2, True), (50.0, True), (0.0, False), (51.0, False)]
)
def test_a_number_has_bounds(value, fits):
    (option,) = options_of([LIMITED])
    if fits:
        assert Options([option], {"answer_ms": value}).number("answer_ms") == value
    else:
        with pytest.raises(BadRequest, match="answer_ms is above 0 and at most 50"):
            Options([option], {"answer_ms": value})

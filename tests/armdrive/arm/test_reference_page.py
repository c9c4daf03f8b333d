"""The reference of the calls is what the docstrings say, and names every public call."""

import inspect
import sys
from pathlib import Path

import pytest

import armdrive

DOCS = Path(__file__).parents[3] / "docs"
sys.path.append(str(DOCS))
import reference  # noqa: E402

sys.path.remove(str(DOCS))


def test_the_page_is_as_the_docstrings_are():
    kept = reference.PAGE.read_text(encoding="utf-8")
    assert kept == reference.page(), "write it anew: python docs/reference.py"


CALLS = sorted(
    name
    for name in set(dir(armdrive.Arm)) - reference.INNER
    if not name.startswith("_") and inspect.isfunction(inspect.getattr_static(armdrive.Arm, name))
)


@pytest.mark.parametrize("name", CALLS)
def test_every_public_call_is_told(name):
    assert f".{name}(" in reference.page()


def test_no_name_is_left_out_that_is_none_any_more():
    assert set(dir(armdrive.Arm)) >= reference.INNER

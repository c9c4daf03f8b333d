"""The reference of the calls names every public call."""

import inspect
import sys

import pytest
from pages import DOCS

import armdrive

sys.path.append(str(DOCS))
import reference

sys.path.remove(str(DOCS))

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

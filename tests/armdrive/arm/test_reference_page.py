"""The reference of the calls names every public call."""

import inspect
import sys

from pages import DOCS

import armdrive

sys.path.append(str(DOCS))
import reference

sys.path.remove(str(DOCS))


def test_every_public_call_is_told_and_no_name_is_left_out_that_is_none_any_more():
    names = set(dir(armdrive.Arm))
    calls = {name for name in names - reference.INNER if not name.startswith("_")}
    page = reference.page()
    for name in sorted(calls):
        if inspect.isfunction(inspect.getattr_static(armdrive.Arm, name)):
            assert f".{name}(" in page, name
    assert names >= reference.INNER

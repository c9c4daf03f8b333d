"""Every public name of the room is there, and what is heavy is loaded when it is first used."""

import subprocess
import sys

import pytest

import kinematics


@pytest.mark.parametrize("name", kinematics.__all__)
def test_a_public_name_leads_to_something(name):
    assert getattr(kinematics, name) is not None
    assert name in dir(kinematics)


def test_the_textbook_is_among_the_public_names():
    textbook = [name for names in kinematics._TEXTBOOK.values() for name in names]
    assert len(set(textbook)) == len(textbook)
    assert set(textbook) <= set(kinematics.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="'kinematics' has no attribute 'rot_w'"):
        kinematics.rot_w  # noqa: B018


def test_importing_the_room_loads_neither_numpy_nor_the_named_systems():
    code = (
        "import sys, kinematics\n"
        "late = {'numpy', 'kinematics.textbook.systems', 'kinematics.frames.graph'}\n"
        "assert late <= {'numpy', *kinematics._TEXTBOOK}\n"
        "print(sorted(late & sys.modules.keys()))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"

"""Every public name of the room is there, and what is heavy is loaded when it is first used."""

import ast
import inspect
import subprocess
import sys

import pytest

import kinematics
from kinematics import exports


def test_every_public_name_leads_to_something():
    for name in kinematics.__all__:
        assert getattr(kinematics, name) is not None
        assert name in dir(kinematics)


def test_the_imports_the_list_and_the_types_agree():
    """Type checkers read the imports under TYPE_CHECKING, Python what they import."""
    tree = ast.parse(inspect.getsource(kinematics))
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    typed = {
        (node.module, alias.name)
        for node in block.body
        if isinstance(node, ast.ImportFrom) and node.module.startswith("kinematics.")
        for alias in node.names
    }
    assert typed == {("kinematics.exports", "*")}
    listed = ast.parse(inspect.getsource(exports)).body
    imports = [node for node in listed if isinstance(node, ast.ImportFrom)]
    aliases = [alias for node in imports for alias in node.names]
    assert all(alias.name == alias.asname for alias in aliases)  # what makes them public
    assert sorted(alias.name for alias in aliases) == sorted(kinematics.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="'kinematics' has no attribute 'rot_w'"):
        kinematics.rot_w  # noqa: B018


def test_importing_the_room_loads_no_list_of_names_and_what_drives_an_arm_loads_no_numpy():
    code = (
        "import sys, kinematics\n"
        "late = {'numpy', 'kinematics.exports', 'kinematics.textbook.systems'}\n"
        "getattr(kinematics, '__warningregistry__', None)\n"  # as unittest asks every module
        "print(sorted(late & sys.modules.keys()))\n"
        "kinematics.Pose\n"
        "print(sorted(late & sys.modules.keys()))\n"
        "from kinematics import MotionLimits, SYSTEMS, frame_goal, solve_goal, timed\n"
        "puma = SYSTEMS['puma'].chain()\n"
        "goal = frame_goal(puma.fk((0.1, -0.4, 0.8, 0.2, 0.6, 0.1)))\n"
        "timed([(0.0,), (1.0,)], MotionLimits((1.0,)))\n"
        "print(solve_goal(puma, goal).ok, 'numpy' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        "[]",
        "['kinematics.exports', 'kinematics.textbook.systems']",
        "True False",
    ]

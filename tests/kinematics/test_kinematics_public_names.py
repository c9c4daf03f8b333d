"""Every public name of the room is there, and what is heavy is loaded when it is first used."""

import ast
import inspect
import subprocess
import sys

import pytest

import kinematics


@pytest.mark.parametrize("name", kinematics.__all__)
def test_a_public_name_leads_to_something(name):
    assert getattr(kinematics, name) is not None
    assert name in dir(kinematics)


def imported(nodes):
    return {
        (node.module, alias.name)
        for node in nodes
        if isinstance(node, ast.ImportFrom) and node.module.startswith("kinematics.")
        for alias in node.names
    }


def test_the_table_of_homes_the_list_and_the_types_agree():
    """Tools read the imports under TYPE_CHECKING, Python reads the table."""
    tree = ast.parse(inspect.getsource(kinematics))
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    homes = {(module, name) for module, names in kinematics._HOMES.items() for name in names}
    assert imported(block.body) == homes
    everything = [name for _, name in [*homes, *imported(tree.body)]]
    assert sorted(everything) == sorted(kinematics.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="'kinematics' has no attribute 'rot_w'"):
        kinematics.rot_w  # noqa: B018


def test_importing_the_room_loads_neither_numpy_nor_the_named_systems():
    code = (
        "import sys, kinematics\n"
        "late = {'numpy', 'kinematics.textbook.systems', 'kinematics.frames.graph'}\n"
        "assert late <= {'numpy', *kinematics._HOMES}\n"
        "print(sorted(late & sys.modules.keys()))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"

"""What `from armdrive import ...` gives, and that naming it costs nothing before it is used."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys

import pytest

import armdrive


@pytest.mark.parametrize("name", armdrive.__all__)
def test_every_public_name_can_be_imported_and_is_described(name):
    found = getattr(armdrive, name)
    assert inspect.getdoc(found)
    assert name in dir(armdrive)


def test_the_table_of_homes_the_list_and_the_types_agree():
    """Type checkers read the imports under TYPE_CHECKING, Python reads the table."""
    tree = ast.parse(inspect.getsource(armdrive))
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    typed = {
        (node.module, alias.name)
        for node in block.body
        if isinstance(node, ast.ImportFrom) and node.module not in ("typing", "collections.abc")
        for alias in node.names
    }
    homes = {(module, name) for module, names in armdrive._HOMES.items() for name in names}
    assert typed == homes
    assert sorted(name for _, name in homes) == sorted(armdrive.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'Robot'"):
        armdrive.Robot  # noqa: B018 - the look-up is the test


def test_importing_the_package_imports_nothing_heavy():
    program = "import armdrive, sys; print(*sys.modules)"
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    loaded = set(ended.stdout.split())
    assert "armdrive" in loaded
    assert not loaded & {"numpy", "can", "serial", "textual", "kinematics", "armdrive.arm"}


def test_an_arm_on_simulated_time_needs_no_port_library():
    program = (
        "import sys\nfrom armdrive import Arm\n"
        "with Arm.connect('sim:teachmover') as arm:\n    arm.home()\n"
        "print(*sys.modules)"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    loaded = set(ended.stdout.split())
    assert "armdrive.sim.simulated_arm" in loaded
    assert not loaded & {"numpy", "can", "serial", "textual"}

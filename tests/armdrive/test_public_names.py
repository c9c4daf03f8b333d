"""What `from armdrive import ...` gives, and that naming it costs nothing before it is used."""

import ast
import inspect
import subprocess
import sys

import pytest
from amounts import every_row

import armdrive
from armdrive import exports


@every_row("name", armdrive.__all__)
def test_every_public_name_can_be_imported_and_is_described(name):
    found = getattr(armdrive, name)
    assert inspect.getdoc(found)
    assert name in dir(armdrive)


def test_the_imports_the_list_and_the_types_agree():
    """Type checkers read the import under TYPE_CHECKING, Python what it imports."""
    tree = ast.parse(inspect.getsource(armdrive))
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    typed = {
        (node.module, alias.name)
        for node in block.body
        if isinstance(node, ast.ImportFrom) and node.module != "typing"
        for alias in node.names
    }
    assert typed == {("armdrive.exports", "*")}
    imported = [name for name in vars(exports) if not name.startswith("_")]
    assert sorted(imported) == sorted(armdrive.__all__)


def test_a_star_gives_every_public_name():
    names = {}
    exec("from armdrive import *", names)
    assert set(names) - {"__builtins__"} == set(armdrive.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'Robot'"):
        armdrive.Robot  # noqa: B018 - the look-up is the test


def test_importing_the_package_imports_nothing_heavy():
    asked = "getattr(armdrive, '__warningregistry__', None)"  # as unittest asks every module
    program = f"import armdrive, sys; {asked}; print(*sys.modules)"
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

"""The pytest plugin: fixtures `arm_world` and `sim_arm`, and the mark and options that choose arms.

pytest loads the plugin wherever armdrive is installed, so the plugin imports the driver only when a
test uses an arm.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from armdrive import testing

if TYPE_CHECKING:
    from armdrive.arm import Arm
    from armdrive.testing.arm_world import ArmWorld

MARK = "armdrive"
KEYS = ("dialect", "file")  # the mark's keywords, of which a test gives one


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add command-line options that choose the arm of tests without a mark."""
    group = parser.getgroup("armdrive", "simulated robot arms")
    group.addoption(
        "--armdrive-dialect",
        metavar="NAME",
        help="the simulated arm of tests without a mark: teachmover, grbl, ...",
    )
    group.addoption(
        "--armdrive-file",
        metavar="FILE",
        help="the arm file for tests without a mark, relative to pytest's root directory",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Register the mark."""
    config.addinivalue_line(
        "markers", f'{MARK}(dialect="grbl" | file="arms/bench.toml"): the simulated arm of a test'
    )


@pytest.fixture
def arm_world(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[ArmWorld]:
    """A table for blocks, and a simulated arm to which every `Arm.connect` of the test leads.

    The test cannot open a real port, and armdrive stores its files in `tmp_path`.
    """
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path / "armdrive"))
    with testing.ArmWorld(_target(request)) as world:
        yield world


@pytest.fixture
def sim_arm(arm_world: ArmWorld) -> Iterator[Arm]:
    """A connected, enabled and referenced arm in the `arm_world`."""
    with arm_world.connect() as arm:
        arm.home()
        yield arm


def _target(request: pytest.FixtureRequest) -> str | None:
    """Return the target of the test's arm; None if neither the mark nor an option chooses one."""
    mark = request.node.get_closest_marker(MARK)
    options = {key: request.config.getoption(f"--armdrive-{key}") for key in KEYS}
    chosen = options if mark is None else mark.kwargs
    given = {key: value for key, value in chosen.items() if value is not None}
    if len(given) > 1 or not given.keys() <= set(KEYS) or (mark is not None and mark.args):
        raise pytest.UsageError(
            f"choose the simulated arm by its dialect or by a file, as @pytest.mark.{MARK}"
            '(dialect="grbl") or (file="bench.toml")'
        )
    if "file" in given:
        return str(request.config.rootpath / given["file"])
    return f"sim:{given['dialect']}" if given else None

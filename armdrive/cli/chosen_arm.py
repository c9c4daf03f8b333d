"""A connection to the arm that the options of a command name.

Simulated arms of the command line are remembered from one command to the next.
"""

from __future__ import annotations

import argparse
import contextlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.holders import ask
from armdrive.cli.options import names_arm
from armdrive.cli.presenter import tell
from armdrive.config.arm import ArmConfig
from armdrive.connect import parts
from armdrive.connect.control_socket import serve
from armdrive.connect.target import find, state_file
from armdrive.errors import StateFileError
from armdrive.registry import simulate
from armdrive.runtime.clock import PaceChoice
from armdrive.storage import files as places
from armdrive.storage.arm_lock import hold
from armdrive.storage.files import replace_file
from armdrive.storage.record import RecordFile
from armdrive.text.reading import is_there, read_json
from armdrive.trace.recorder import FlightRecorder

# Bytes. A world with a full program memory and thousands of blocks is smaller.
LARGEST_BYTES = 8_000_000


def connect_chosen(
    options: argparse.Namespace,
    *,
    pace: PaceChoice = None,
    reconnect: bool | None = None,
    reads: bool = False,
) -> Arm:
    """Connect to the arm that the options name. A simulated arm continues in its remembered world.

    With `reconnect` a real one's lost wire is looked for; None leaves that to its arm file. An arm
    that a command only `reads` need not be within reach of other programs, as on a full disk.
    """
    target = chosen_target(options)
    allow_restored = getattr(options, "allow_restored", False)
    if target.simulated:
        return connect_remembered(
            target.config, fresh=options.fresh, pace=pace, allow_restored=allow_restored
        )
    wanted = parts.ConnectOptions(allow_restored=allow_restored, reconnect=reconnect)
    real = parts.connect_real(target.config, wanted)
    if not reads or real.lock is None:
        return Arm(real)
    arm = Arm(replace(real, lock=None))
    with contextlib.suppress(StateFileError):
        serve(real.lock, real.connection)
    return arm


@contextlib.contextmanager
def opened_arm(options: argparse.Namespace) -> Iterator[Arm]:
    """Connect to the arm that the options name, say which it is, and close it at the end."""
    with contextlib.closing(connect_chosen(options)) as arm:
        tell(options, arm.status.which)
        yield arm


def enable_if_settled(arm: Arm) -> None:
    """Enable an arm if it is settled where the arm stands; else leave its motors alone."""
    if arm.parts.core.position_known:
        arm.enable()


def world_file(arm: str) -> Path:
    """Return the file in which a simulated arm's world is remembered."""
    return places.states() / f"{places.file_name(arm)}.world.json"


def connect_remembered(
    config: ArmConfig,
    *,
    fresh: bool = False,
    pace: PaceChoice = None,
    allow_restored: bool = False,
) -> Arm:
    """Connect to a simulated arm as the last command left it; remember it at the end."""
    holding = hold(config.name)
    try:
        if fresh:
            _forget(config.name)
        try:
            twin = simulate(config, _load(config.name))
        except StateFileError as error:
            raise StateFileError(
                f"the remembered world {world_file(config.name)} cannot be used: {error}; "
                "--fresh starts over"
            ) from None
        simulated = parts.connect_simulated(
            config,
            twin=twin,
            pace=pace,
            record_store=RecordFile(state_file(config.name)),
            allow_restored=allow_restored,
            tracer=FlightRecorder(places.recordings()),
        )
        # in this order: once the lock is released, another command may read the world
        closers = (lambda: _save(config.name, twin.save()), holding.release)
        simulated.connection.closers.extend(closers)
        return Arm(replace(simulated, lock=holding))
    except BaseException:
        holding.release()
        raise


def held_config(options: argparse.Namespace, name: str) -> ArmConfig:
    """Return the arm of this name, which a program is driving.

    Where the options do not name it, it may be named by its port, and have no file: that program
    says which dialect it speaks.
    """
    if names_arm(options):
        return chosen_target(options).config
    return find(name, dialect_name=str(ask(name, "status")["dialect"])).config


def _load(arm: str) -> object:
    path = world_file(arm)
    if not is_there(path):
        return None
    return read_json(path, "the file", StateFileError, most_bytes=LARGEST_BYTES)


def _save(arm: str, world: Mapping[str, object]) -> None:
    replace_file(world_file(arm), json.dumps(world))


def _forget(arm: str) -> None:
    for path in (world_file(arm), state_file(arm)):
        path.unlink(missing_ok=True)

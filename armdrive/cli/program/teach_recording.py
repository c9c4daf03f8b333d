"""`armdrive teach record`: write down what an arm does that another program drives."""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Iterator, Mapping
from typing import Any

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.drive.control_requests import one_holder
from armdrive.cli.presenter import emit, say
from armdrive.connect.target import find
from armdrive.errors import ArmError, BadRequest, Refused
from armdrive.programs.teaching.record import Choices, StepRecorder, seen_in
from armdrive.storage.lock_client import watch_holder
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import Step, check_name

LOOK_EVERY_S = 0.1


def record(options: argparse.Namespace) -> int:
    """Record until Ctrl-C, or until the arm is given back."""
    name = one_holder(options)
    named = options.arm or options.sim or options.port
    config = (chosen_target(options) if named else find(name)).config
    book = points_of(config.name, config.model.arm)
    _require_free(book, options)
    how = "line" if options.line else "joint"
    recorder = StepRecorder(options.name, Choices(how, options.speed, options.waits, options.rest))
    if not options.json:
        say(f"recording {name} as {options.name}: a step wherever it comes to rest; Ctrl-C ends it")
    kept = _Kept(options, book, recorder)
    try:
        _follow(recorder, watch_holder(name, LOOK_EVERY_S), config.model.arm.joint_names, kept)
    except KeyboardInterrupt:  # how a recording ends
        pass
    finally:
        kept.take(recorder.end(time.monotonic()))
    if not recorder.steps:
        raise Refused("nothing was recorded: the arm was never seen at rest")
    if not options.json:
        count = len(recorder.steps)
        say(f"{options.name}: {count} steps over {len(recorder.points)} points, in {book.path}")
    return 0


def _follow(
    recorder: StepRecorder, views: Iterator[Mapping[str, Any]], names: tuple[str, ...], kept: _Kept
) -> None:
    """Take up what is seen of an arm, until it is given back."""
    for view in views:
        if "state" not in view:
            raise ArmError(str(view.get("error", "the holder does not let itself be watched")))
        if view["state"] == "disconnected":
            return
        now_s = time.monotonic()
        kept.take(recorder.see(seen_in(view, names), now_s))


class _Kept:
    """Prints steps as they come, and writes them down at once: no way to end loses any."""

    def __init__(self, options: argparse.Namespace, book: Points, recorder: StepRecorder) -> None:
        self._json, self._again = options.json, options.again
        self._book = book
        self._recorder = recorder

    def take(self, made: tuple[Step, ...]) -> None:
        """Take the steps that were made last."""
        if not made:
            return
        recorder = self._recorder
        sequences = {recorder.name: recorder.sequence}
        self._book.put_all(recorder.points, sequences, again=self._again)
        self._again = True  # what stands there from now on is this recording
        for number, step in enumerate(made, len(recorder.steps) - len(made) + 1):
            if self._json:
                emit({"step": number, "text": str(step)})
            else:
                say(f"{number:>3}  {step}")


def _require_free(book: Points, options: argparse.Namespace) -> None:
    """Refuse a name that is taken before anything is recorded, not after it."""
    taught = book.read()
    check_name(options.name)
    numbered = re.compile(f"{options.name}-[0-9]+")
    mine = [name for name in taught.points if numbered.fullmatch(name)]
    if not options.again and (options.name in taught.sequences or mine):
        taken = ", ".join([*mine, *[options.name] * (options.name in taught.sequences)])
        raise BadRequest(f"there is {taken} already: take another name, or say --again")

"""`armdrive teach record`: write down what an arm does that another program drives."""

from __future__ import annotations

import re
import time
from typing import TYPE_CHECKING

from armdrive.cli.choosing import chosen_target
from armdrive.cli.holders import one_holder
from armdrive.cli.output import emit, say
from armdrive.errors import ArmError, BadRequest, Refused
from armdrive.pointbook import Points, points_of
from armdrive.points import check_name
from armdrive.teaching.recording import Choices, Recorder, seen_in

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator, Mapping
    from typing import Any

LOOK_EVERY_S = 0.1


def record(options: argparse.Namespace) -> int:
    """Record until Ctrl-C, or until the arm is given back; then write the sequence down."""
    from armdrive.connecting import find
    from armdrive.holder import watch_holder

    name = one_holder(options)
    named = options.arm or options.sim or options.port
    config = (chosen_target(options) if named else find(name)).config
    book = points_of(config)
    _require_free(book, options)
    how = "line" if options.line else "joint"
    recorder = Recorder(options.name, Choices(how, options.speed, options.waits, options.rest))
    if not options.json:
        say(f"recording {name} as {options.name}: a step wherever it comes to rest; Ctrl-C ends it")
    trouble: ArmError | None = None
    try:
        _follow(recorder, watch_holder(name, LOOK_EVERY_S), config.model.arm.joint_names, options)
    except KeyboardInterrupt:  # how a recording ends
        pass
    except ArmError as error:  # what was recorded until then is kept
        trouble = error
    _tell(options, recorder, recorder.end(time.monotonic()))
    if trouble is not None and not recorder.steps:
        raise trouble
    return _kept(options, book, recorder, trouble)


def _follow(
    recorder: Recorder,
    views: Iterator[Mapping[str, Any]],
    names: tuple[str, ...],
    options: argparse.Namespace,
) -> None:
    """Take up what is seen of an arm, until it is given back."""
    for view in views:
        if "state" not in view:
            raise ArmError(str(view.get("error", "the holder does not let itself be watched")))
        if view["state"] == "disconnected":
            return
        now_s = time.monotonic()
        _tell(options, recorder, recorder.see(seen_in(view, names), now_s))


def _kept(
    options: argparse.Namespace, book: Points, recorder: Recorder, trouble: ArmError | None
) -> int:
    if not recorder.steps:
        raise Refused("nothing was recorded: the arm was never seen at rest")
    sequences = {options.name: recorder.sequence}
    book.put_all(recorder.points, sequences, again=options.again)
    if not options.json:
        count = len(recorder.steps)
        say(f"{options.name}: {count} steps over {len(recorder.points)} points, in {book.path}")
    if trouble is not None:
        raise trouble
    return 0


def _tell(options: argparse.Namespace, recorder: Recorder, made: tuple[object, ...]) -> None:
    first = len(recorder.steps) - len(made) + 1
    for number, step in enumerate(made, first):
        if options.json:
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

"""Makes and completes arm files with the user: interview, directions of motors, limit switches.

The interview asks its questions, shows the arm file, and writes it if the user agrees. `?` explains
a question, `back` returns to the one before, an empty line takes the default in brackets, and
Ctrl-C leaves without writing. For scripts: `--answers FILE`, or `--yes` for every default.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from armdrive.arm import Arm
from armdrive.cli.arm_files import read
from armdrive.cli.presenter import Result, as_json, say, tell
from armdrive.cli.questions import Back, TerminalPerson, agree, ask
from armdrive.cli.terminal_operator import posture_pictures
from armdrive.config.arm import ArmConfig, limit_remarks
from armdrive.connect import parts
from armdrive.connect.target import simulation_forced
from armdrive.dialog import Dialog, DialogPerson, Question, WrongAnswer
from armdrive.errors import ArmError, BadRequest, OperatorNeeded
from armdrive.registry.arm_files import arm_path, load_arm
from armdrive.setup.arm_checks import (
    SawSwitch,
    all_work,
    check_switches,
    find_signs,
    make_ready,
    record,
    switches_of,
)
from armdrive.setup.directions import Signs
from armdrive.setup.draft import Draft, flattened
from armdrive.setup.filing import FileProposal, after_writing, checked, files_of, propose, write
from armdrive.setup.interview import Interview, surroundings
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.sim.world.body import found_posture
from armdrive.storage.files import arm_files, require_writable
from armdrive.text.reading import is_there, read_toml
from kinematics.errors import did_you_mean

GIVEN = ("name", "template", "port")
KEYS = {"port": "connection.port"}
TYPED = {"name": ", or write `armdrive config new NAME`", "template": ", or add --template NAME"}
"""How answers without a default are typed in the command itself."""


def new(options: argparse.Namespace) -> Result:
    """Interview, show, ask, write."""
    given = _given(options)
    require_writable(arm_files())
    silent = options.yes or options.answers is not None
    if as_json(options) and not silent:
        raise BadRequest("--json asks no questions: add --answers FILE or --yes")
    if "name" in given and not options.force:
        _note_existing(given["name"], silent=silent)
    draft = _interviewed(given, silent)
    if draft.get("signs") == "find":
        draft = _with_signs(draft, simulated=options.sim, alone=silent)
    files = files_of(draft)
    config = checked(files, draft.name)
    for line in f"\n{files.shown}".split("\n"):
        tell(options, line)
    path = arm_path(draft.name)
    if not silent and not _agreed(path, force=options.force):
        return Result(None, "nothing is written", 1)
    write(files, path)
    view = {"arm": draft.name, "file": str(path), "model": config.model.key}
    return Result(view, after_writing(path, config))


def _given(options: argparse.Namespace) -> dict[str, str]:
    given: dict[str, str] = {}
    if options.answers is not None:
        given = flattened(read_toml(Path(options.answers), "the file of answers", BadRequest))
    typed = {KEYS.get(key, key): getattr(options, key) for key in GIVEN}
    return given | {key: value for key, value in typed.items() if value is not None}


def _note_existing(name: str, *, silent: bool) -> None:
    """Say at once that an arm file would be overwritten; refuse that if the user is not asked."""
    path = arm_path(name)
    if not is_there(path):
        return
    if silent:
        raise BadRequest(f"{path} exists: --force overwrites it")
    say(f"  {path} exists; it stays as it is unless you agree at the end to overwrite it")


def _interviewed(given: dict[str, str], silent: bool) -> Draft:
    interview = Interview(surroundings(given))
    while (question := interview.question) is not None:
        if silent:
            _take_default(interview, question)
            continue
        try:
            ask(question, interview.answer)
            if question.key == "name":
                _note_existing(interview.draft.name, silent=silent)
        except Back:
            if interview.back() is None:
                say("  this is the first question")
    unused = [key for key in given if key not in interview.draft.answers]
    if unused:
        asked = list(interview.draft.answers)
        hint = did_you_mean(unused[0], asked, f"the questions were {', '.join(asked)}")
        raise BadRequest(f"no question takes the answer {unused[0]!r}; {hint}")
    return interview.draft


def _take_default(interview: Interview, question: Question) -> None:
    if question.default is None:
        words = ", ".join(word for word, _ in question.choices)
        raise BadRequest(
            f"{question.words!r} has no default{f' ({words})' if words else ''}: put the answer "
            f"{question.key!r} into the file of --answers{TYPED.get(question.key, '')}"
        )
    try:
        interview.answer("")
    except WrongAnswer as wrong:
        raise BadRequest(f"the answer {question.key}: {wrong}") from None


def _with_signs(draft: Draft, *, simulated: bool, alone: bool) -> Draft:
    """Return the draft with the directions that were seen; an error leaves them for later."""
    config = checked(files_of(draft), draft.name)
    try:
        with _connected(config, simulated=simulated, alone=alone, wanted=WATCHED) as arm:
            signs = _found_signs(arm, alone=alone)
    except ArmError as error:
        if alone:
            raise
        say(f"the directions are left for later: {error}")
        return draft
    found: dict[str, Any] = {"reversed.motors": signs.motors, "reversed.joints": signs.joints}
    if signs.unclear and not alone:
        say(f"unclear: {', '.join(signs.unclear)}")
    return Draft({**draft.answers, **found}, draft.around)


def _agreed(path: Path, *, force: bool) -> bool:
    if path.exists() and not force:
        return agree(f"{path} exists. Overwrite it?", "Its contents will be lost.")
    return agree(f"Write this to {path}?", "no writes nothing.", "yes")


# Trials on the arm itself: the directions of its motors, and its limit switches.

WATCHED = "watch a real arm while its motors turn"
PRESSED = "press the switches of a real arm"


@contextlib.contextmanager
def _connected(config: ArmConfig, *, simulated: bool, alone: bool, wanted: str) -> Iterator[Arm]:
    """Open an arm for a trial, with its motors as they are.

    Raises `OperatorNeeded` for a real arm if no user is at a terminal to do what is `wanted`.
    """
    simulated = simulated or simulation_forced()
    if not simulated and (alone or not sys.stdin.isatty()):
        raise OperatorNeeded(f"you have to {wanted}: run this in a terminal, or give --sim")
    open_arm = parts.connect_simulated if simulated else parts.connect_real
    with contextlib.closing(Arm(open_arm(config))) as arm:
        yield arm


def _person(arm: Arm, *, alone: bool) -> DialogPerson:
    """Return the person who handles and watches an arm; with `alone` the user is not asked."""
    terminal = TerminalPerson()
    if arm.twin is None or not arm.simulated:
        return terminal
    if alone:
        return SimulatedPerson(arm.twin, lambda _line: None)
    return SimulatedPerson(arm.twin, terminal.tell, terminal.answer)


def _found_signs(arm: Arm, *, alone: bool) -> Signs:
    picture = [] if alone else posture_pictures(arm, found_posture(arm.model.arm), 30.0)
    return find_signs(Dialog(_person(arm, alone=alone)), arm, picture)


def signs(options: argparse.Namespace) -> Iterator[Result]:
    """Find which way the motors count, and write that to the arm file if the user agrees."""
    path = read(options.name).path
    config = load_arm(path)
    alone = options.yes or as_json(options)
    if not options.sim:
        require_writable(path.parent)  # before a person and the motors work for nothing
    with _connected(config, simulated=options.sim, alone=alone, wanted=WATCHED) as arm:
        found = _found_signs(arm, alone=alone)
        simulated = arm.simulated
    proposal = propose(path, config.model.transmission, found)
    view = {
        "reversed_motors": list(found.motors),
        "reversed_joints": list(found.joints),
        "unclear": list(found.unclear),
        "lines": list(proposal.difference),
    }
    right = () if proposal.differs or proposal.remarks else ("every direction is correct",)
    lines = (*proposal.difference, *proposal.remarks, *right)
    yield Result(view, lines, 1 if found.unclear else 0)
    _write_down(proposal, options, simulated=simulated)


UNHEEDED = (
    "A switch that closes in motion would stop nothing: the board's firmware ignores hard limits, "
    "as the default build of grbl-Mega-5X for RAMPS boards does. Use another build "
    "(docs/controllers/grbl.md), or write hard_limits = false."
)


def limits(options: argparse.Namespace) -> Iterator[Result]:
    """Check each limit switch, and write the day to the arm file if all work."""
    path = read(options.name).path
    config = load_arm(path)
    switches = switches_of(config)
    alone = options.yes or as_json(options)
    if not options.sim:
        require_writable(path.parent)  # before a person and the motors work for nothing
    with _connected(config, simulated=options.sim, alone=alone, wanted=PRESSED) as arm:
        make_ready(arm)
        seen = check_switches(Dialog(_person(arm, alone=alone)), arm, switches)
        simulated = arm.simulated
    works = all_work(seen)
    view = {"switches": {name: saw.name.lower() for name, saw in seen.items()}, "works": works}
    lines = [f"{name}: {saw.value}" for name, saw in seen.items()]
    if not works:
        unheeded = SawSwitch.PIN_ALONE in seen.values()
        lines.append(UNHEEDED if unheeded else "Check the switches and their wires.")
        lines += limit_remarks(config)
    elif simulated:
        lines.append("every switch works; for a simulated arm nothing is written")
    if not works:
        yield Result(view, lines, 1)
        return
    proposal = record(path, config, datetime.now(UTC).astimezone().date())
    yield Result(view, (*lines, *proposal.difference) if not simulated else lines)
    _write_down(proposal, options, simulated=simulated)


def _write_down(proposal: FileProposal, options: argparse.Namespace, *, simulated: bool) -> None:
    """Write a change that was shown, if the user agrees; for a simulated arm nothing is written."""
    if simulated or as_json(options) or not proposal.differs:
        return
    if agree(f"Write this to {proposal.path}?", "no leaves the file unchanged.", "yes"):
        proposal.write()
        say(f"written: {proposal.path}")

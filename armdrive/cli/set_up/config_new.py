"""Makes an arm file with the user.

An interview asks its questions, shows the arm file, and writes it if the user agrees. `?` explains
a question, `back` returns to the one before, an empty line takes the default in brackets, and
Ctrl-C leaves without writing. For scripts: `--answers FILE`, or `--yes` for every default.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from armdrive.cli.presenter import Result, as_json, say, tell
from armdrive.cli.questions import Back, ask, ask_yes_no
from armdrive.dialog import Question, WrongAnswer
from armdrive.errors import BadRequest
from armdrive.registry.arm_files import arm_path
from armdrive.setup.draft import Draft, flattened
from armdrive.setup.filing import after_writing, checked, files_of, write
from armdrive.setup.interview import Interview, surroundings
from armdrive.storage.files import arm_files, require_writable
from armdrive.text.reading import is_there, read_toml
from kinematics.errors import did_you_mean

GIVEN = ("name", "template", "port")
KEYS = {"port": "connection.port"}
# How answers without a default are typed in the command itself.
TYPED = {"name": ", or write `armdrive config new NAME`", "template": ", or add --template NAME"}


def new(options: argparse.Namespace) -> Result:
    """Interview, show, ask, write."""
    given = _given(options)
    require_writable(arm_files())  # before forty questions, and not after them
    silent = options.yes or options.answers is not None
    if as_json(options) and not silent:
        raise BadRequest("--json asks no questions: add --answers FILE or --yes")
    if "name" in given and not options.force:
        _note_existing(given["name"], silent=silent)
    draft = _interviewed(given, silent)
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


def _agreed(path: Path, *, force: bool) -> bool:
    if path.exists() and not force:
        return ask_yes_no(f"{path} exists. Overwrite it?", "Its contents will be lost.")
    return ask_yes_no(f"Write this to {path}?", "no writes nothing.", "yes")

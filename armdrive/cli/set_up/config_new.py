"""Ask questions, show the arm file that they make, and write it once you have agreed.

`?` explains a question, `back` goes back to the one before, an empty line takes what stands in
brackets, and Ctrl-C leaves nothing behind. For scripts: `--answers FILE`, or `--yes` for every
default.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from armdrive.cli.presenter import emit, say, say_lines
from armdrive.cli.questions import Back, agree, ask
from armdrive.cli.set_up.config_signs import connected, find_signs
from armdrive.config.arm import ArmConfig
from armdrive.dialog.conversation import WrongAnswer
from armdrive.errors import ArmError, BadRequest
from armdrive.setup.arm_text import files_of
from armdrive.setup.draft import Draft, flattened
from armdrive.setup.filing import checked, write
from armdrive.setup.finding import surroundings
from armdrive.setup.interview import Interview
from armdrive.storage import files as places
from armdrive.text.reading import read_toml
from kinematics.errors import did_you_mean

GIVEN = ("name", "template", "port")
KEYS = {"port": "connection.port"}


def run(options: argparse.Namespace) -> int:
    """Interview, show, ask, write."""
    given = _given(options)
    silent = options.yes or options.answers is not None
    if options.json and not silent:
        raise BadRequest("--json asks nothing: give --answers FILE or --yes beside it")
    if silent and not options.force and "name" in given:
        _refuse_overwriting(given["name"])
    draft = _interviewed(given, silent)
    if draft.get("signs") == "find":
        draft = _with_signs(draft, simulated=options.sim, alone=silent)
    files = files_of(draft)
    config = checked(files, draft.name)
    if not options.json:
        say_lines(f"\n{files.shown}")
    path = places.arm_files() / f"{draft.name}.toml"
    if not silent and not _agreed(path, force=options.force):
        say("nothing is written")
        return 1
    write(files, path)
    if options.json:
        emit({"arm": draft.name, "file": str(path), "model": config.model.key})
    else:
        _say_next(path, config)
    return 0


def _given(options: argparse.Namespace) -> dict[str, str]:
    given: dict[str, str] = {}
    if options.answers is not None:
        given = flattened(read_toml(Path(options.answers), "the file of answers", BadRequest))
    typed = {KEYS.get(key, key): getattr(options, key) for key in GIVEN}
    return given | {key: value for key, value in typed.items() if value is not None}


def _refuse_overwriting(name: str) -> None:
    path = places.arm_files() / f"{name}.toml"
    if path.exists():
        raise BadRequest(f"{path} exists: --force overwrites it")


def _interviewed(given: dict[str, str], silent: bool) -> Draft:
    interview = Interview(surroundings(given))
    while (question := interview.question) is not None:
        if silent:
            _take_default(interview, question.key)
            continue
        try:
            ask(question, interview.answer)
        except Back:
            if interview.back() is None:
                say("  this is the first question")
    unused = [key for key in given if key not in interview.draft.answers]
    if unused:
        asked = list(interview.draft.answers)
        hint = did_you_mean(unused[0], asked, f"asked were {', '.join(asked)}")
        raise BadRequest(f"nobody asked for the answer {unused[0]!r}; {hint}")
    return interview.draft


def _take_default(interview: Interview, key: str) -> None:
    try:
        interview.answer("")
    except WrongAnswer as wrong:
        raise BadRequest(f"the answer {key}: {wrong}") from None


def _with_signs(draft: Draft, *, simulated: bool, alone: bool) -> Draft:
    """Return the draft with the directions that were seen; a trouble leaves them for later."""
    config = checked(files_of(draft), draft.name)
    try:
        with connected(config, simulated=simulated, alone=alone) as arm:
            signs = find_signs(arm, alone=alone)
    except ArmError as error:
        if alone:
            raise
        say(f"the directions are left for later: {error}")
        return draft
    found: dict[str, Any] = {"reversed.motors": signs.motors, "reversed.joints": signs.joints}
    if signs.unclear and not alone:
        say(f"not told: {', '.join(signs.unclear)}")
    return Draft({**draft.answers, **found}, draft.around)


def _agreed(path: Path, *, force: bool) -> bool:
    if path.exists() and not force:
        return agree(f"{path} exists. Overwrite it?", "Its present text is lost.")
    return agree(f"Write this to {path}?", "no leaves everything as it was.", "yes")


def _say_next(path: Path, config: ArmConfig) -> None:
    name = config.name
    say(f"written: {path}")
    say("next, from the safest on:")
    lines = [
        (f"armdrive config check {name}", "anything wrong or worth knowing; opens nothing"),
        (f"ARMDRIVE_FORCE_SIM=1 armdrive home --arm {name}", "its simulated twin"),
    ]
    if config.connection.port:
        lines += [
            (f"armdrive status --arm {name}", "connects; moves nothing"),
            (f"armdrive config signs {name}", "each motor a little, to see its direction"),
            (f"armdrive jog --arm {name}", "slowly, by hand; space stops"),
        ]
    lines.append((f"armdrive config set-default {name}", "use it where no arm is named"))
    width = max(len(command) for command, _ in lines)
    for command, words in lines:
        say(f"  {command:<{width}}  {words}")

"""What the program screen says: the list, the checks, the rehearsal, the run and its waits."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from armdrive.programs.problems import ProgramError
from armdrive.programs.progress import RunView, duration
from armdrive.programs.rehearsal import Rehearsal, RehearsedSoFar
from tui.keys.keyboard import Keyboard
from tui.move.text import progress_bar
from tui.painting import Span

WARN = "$warning"
WRONG = "$error"


def file_name(path: Path, folder: Path) -> str:
    """Return the name of a file, with its folder if that is another one."""
    return path.name if path.parent == folder else str(path)


def mistakes(error: str, path: Path) -> str:
    """Return what is wrong with a program, without the name of its file in each line."""
    return error.replace(f"{path}: ", "")


def none_found(folder: Path) -> str:
    """Say that there is no program, and how one is named."""
    return f"no program (.arm) in {folder}: `armdrive jog --program FILE` names one"


def reason(error: Exception) -> str:
    """Return what went wrong, without the lines of the program, which the screen shows."""
    problems = error.problems if isinstance(error, ProgramError) else ()
    return problems[0].text if problems else str(error)


def checked_lines(keys: Keyboard) -> Iterator[Span]:
    """Say what can be done with a program that was read and has no mistakes."""
    yield "checked: no mistakes", "$success"
    yield f"{keys.label('program-rehearse')} rehearses it: nothing moves", ""


def rehearsing_lines(far: RehearsedSoFar | None) -> Iterator[Span]:
    """Say how far a rehearsal has come."""
    yield "REHEARSING: nothing moves", "$primary"
    if far is not None:
        yield f"line {far.mark.line}, {far.acts} acts, {duration(far.took_s)} of the arm's time", ""


def rehearsed_lines(found: Rehearsal, keys: Keyboard, *, half: bool) -> Iterator[Span]:
    """Say what a rehearsal found; `half` means that one press of two has been made."""
    if found.refusal is not None:
        where = "" if found.at is None else f" IN LINE {found.at.line}"
        yield f"REFUSED{where}: {reason(found.refusal)}", WRONG
    else:
        acts = sum(map(len, found.loops))
        yield f"rehearsed: {duration(found.took_s)}, {acts} acts{found.end_words}", "$success"
        go = keys.label("program-go")
        if half:
            yield f"{go} AGAIN RUNS IT; a change takes that back", WARN
        else:
            yield f"{go} twice runs it: THE ARM MOVES", ""
    for each in found.assumptions:
        yield f"assumed: {each}", "dim"


def running_lines(
    run: RunView, asks: str, keys: Keyboard, *, paused: bool, stepping: bool
) -> Iterator[Span]:
    """Say where a running program is, what it waits for, and how it is stopped."""
    view = run.view()
    percent, left_s = view.get("percent"), view.get("left_s")
    if percent is not None:
        left = "" if left_s is None else f", {duration(left_s)} left"
        yield f"{progress_bar(percent / 100)}{left}", "$primary"
    forward, pause, stop = (
        keys.label(name) for name in ("program-forward", "program-pause", "stop")
    )
    if asks:
        yield f"WAITS FOR YOU: {asks}", WARN
        yield f"{forward} or {pause} lets it go on, {stop} ends it", ""
        return
    if view.get("waiting"):
        yield f"{view['waiting']} ({duration(run.under_way_s)} so far)", WARN
    yield f"{'PAUSED: ' * paused}{pause} pauses or goes on, {stop} stops", WARN if paused else ""
    if stepping:
        yield "STEPPING: waits for you before the next motion", ""


def ended_lines(outcome: str, file: str, *, failed: bool) -> Iterator[Span]:
    """Say how the last run ended, and how to resume one that ended early."""
    yield outcome, WRONG if failed else "$success"
    if failed:
        yield f"`armdrive run {file} --resume`, on the same arm, goes on from there", ""

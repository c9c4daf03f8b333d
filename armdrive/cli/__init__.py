"""The command line: one table of commands, whose modules are loaded only when they are called.

Nothing heavy is imported on the way to `armdrive --help`.
"""

from __future__ import annotations

import sys
from types import MappingProxyType

TYPE_CHECKING = False  # as typing's, which is slow to import
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from armdrive.cli.runner import CliCommand

# Commands that need the same libraries are loaded together; where one would wait for libraries of
# another, they are not. A module's own imports stand at its top.


def _arm_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.drive import disable, enable, home, move, reset, verify

    return {
        "disable": disable,
        "enable": enable,
        "home": home,
        "move": move,
        "reset": reset,
        "verify": verify,
    }


def _point_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.drive import pendant, points

    return {"pendant": pendant, "points": points}


def _jog_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.drive import jog

    return {"jog": jog}


def _requests_to_other_programs() -> Mapping[str, CliCommand]:
    from armdrive.cli.drive import pause, resume, slow, stop

    return {"pause": pause, "resume": resume, "slow": slow, "stop": stop}


def _run_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.program import run

    return {"run": run}


def _shell_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.program import shell

    return {"shell": shell}


def _teaching_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.program import demo, teach

    return {"demo": demo, "teach": teach}


def _status_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.look import status, watch

    return {"status": status, "watch": watch}


def _recording_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.look import record, replay

    return {"record": record, "replay": replay}


def _log_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.look import log

    return {"log": log}


def _arm_file_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.set_up import config

    return {"config": config}


def _can_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.set_up import can

    return {"can": can}


def _diagnosis_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.set_up import doctor

    return {"doctor": doctor}


def _port_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.set_up import ports

    return {"ports": ports}


def _sim_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.set_up import sim

    return {"sim": sim}


def _pose_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.learn import fk, ik

    return {"fk": fk, "ik": ik}


def _textbook_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.learn import explain, plot

    return {"explain": explain, "plot": plot}


def _error_commands() -> Mapping[str, CliCommand]:
    from armdrive.cli.learn import errors

    return {"errors": errors}


_COMMANDS: Mapping[str, tuple[Callable[[], Mapping[str, CliCommand]], str]] = MappingProxyType(
    {
        "demo": (_teaching_commands, "watch the simulated arm pick and place blocks"),
        "jog": (_jog_commands, "drive an arm from the keyboard"),
        "move": (_arm_commands, "move an arm to joint angles or to a pose"),
        "run": (_run_commands, "run a program, or rehearse it: a program file or a Python script"),
        "shell": (
            _shell_commands,
            "type the words of a program at a prompt, each carried out at once",
        ),
        "points": (
            _point_commands,
            "name places of an arm, and go to them; step through sequences of them",
        ),
        "teach": (
            _teaching_commands,
            "record sequences as the arm is moved, and edit them step by step",
        ),
        "pendant": (_point_commands, "the program in an arm's own memory: into a file, and back"),
        "home": (_arm_commands, "reference an arm in its reference posture"),
        "verify": (_arm_commands, "measure at the reference mark how far an arm has drifted"),
        "enable": (_arm_commands, "switch the motors on, where the controller can"),
        "reset": (_arm_commands, "leave an error, after looking at the arm; moves nothing"),
        "disable": (_arm_commands, "switch the motors off, which lets the arm sag: parks it first"),
        "stop": (_requests_to_other_programs, "stop an arm that another program drives"),
        "pause": (_requests_to_other_programs, "have an arm wait that another program drives"),
        "resume": (_requests_to_other_programs, "let a paused arm go on"),
        "slow": (
            _requests_to_other_programs,
            "have an arm go slower than the program that drives it asks for",
        ),
        "watch": (_status_commands, "watch an arm that another program drives"),
        "status": (_status_commands, "show where an arm is, and whether that can be trusted"),
        "record": (
            _recording_commands,
            "write down what has passed between an arm and the program that drives it",
        ),
        "log": (
            _log_commands,
            "read a recording in words: bytes, requests, intents, states, errors",
        ),
        "replay": (
            _recording_commands,
            "replay a recording against a simulated twin, and show where they part",
        ),
        "fk": (_pose_commands, "joint angles to the pose of the finger tips"),
        "ik": (_pose_commands, "a pose to joint angles, every solution"),
        "explain": (
            _textbook_commands,
            "an arm worked out: link table, A matrices, forward, every inverse",
        ),
        "plot": (_textbook_commands, "draw what an arm can reach"),
        "config": (
            _arm_file_commands,
            "arm files: write one by an interview, list, show, check them",
        ),
        "ports": (
            _port_commands,
            "list the serial ports, who has them, and which arm files name them",
        ),
        "can": (_can_commands, "set up drives on a CAN bus, and watch what passes there"),
        "doctor": (
            _diagnosis_commands,
            "find out what a port leads to, and what is wrong with it; moves nothing",
        ),
        "sim": (_sim_commands, "run a simulated arm that speaks the real bytes"),
        "errors": (_error_commands, "what an error means for the arm, and what to do, by its code"),
    }
)
"""Every command: what loads it, and its line of help."""

COMMANDS: Mapping[str, str] = MappingProxyType({name: row[1] for name, row in _COMMANDS.items()})
"""Every command with its line of help."""

EXIT_CODES: Mapping[int, str] = MappingProxyType(
    {
        0: "done",
        1: "something went wrong, or a check at the end failed",
        2: "the command itself is wrong: an option, a number, an arm file",
        3: "refused: out of reach, beyond a limit, not referenced; nothing moved",
        4: "the port or its holder: cannot be opened, lost, in use",
        5: "stopped before the end",
        6: "the controller answered something else than it should have",
        70: "a fault of armdrive itself; the sentence names the file with the details",
        129: "ended by SIGHUP, a closed terminal; the arm was stopped",
        130: "interrupted by Ctrl-C; the arm was stopped",
        143: "ended by SIGTERM; the arm was stopped",
    }
)
"""What the command line ends with."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    word = words[0] if words else "--help"
    if word in ("-h", "--help"):
        sys.stdout.write(_help())
        return 0
    if word == "--version":
        from importlib.metadata import version

        sys.stdout.write(f"armdrive {version('armdrive')}\n")
        return 0
    from armdrive.cli.runner import refuse, run_command

    if word not in COMMANDS:
        return refuse(word, COMMANDS)
    load, summary = _COMMANDS[word]
    return run_command(word, summary, load, words[1:])


def _help() -> str:
    """Return the help of the whole, made from the tables above.

    Written out here because argparse alone would take longer than everything else on this path.
    """
    width = max(map(len, (*COMMANDS, "--version"))) + 2
    commands = "".join(f"  {name:<{width}}{text}\n" for name, text in COMMANDS.items())
    codes = "".join(f"  {code:<{width}}{text}\n" for code, text in EXIT_CODES.items())
    return (
        "usage: armdrive COMMAND [options]      (armdrive COMMAND --help tells more)\n\n"
        "Drive Mini-mover-style robot arms, real or simulated.\n\n"
        f"commands:\n{commands}\n"
        f"options:\n  {'--help':<{width}}print this\n  {'--version':<{width}}print the version\n\n"
        f"exit codes:\n{codes}\n"
        "With no arm named, the simulated TeachMover is used, and every output says so.\n"
    )

"""The command line: one table of commands, whose modules are loaded only when they are called.

Nothing heavy is imported on the way to `armdrive --help`.
"""

from __future__ import annotations

import sys
from types import MappingProxyType

TYPE_CHECKING = False  # as typing's, which is slow to import
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from armdrive.cli.options import Arguments, Command

    CommandRow = tuple[
        Callable[[], Mapping[str, Arguments]], Callable[[], Mapping[str, Command]], str
    ]

# What may be typed after the commands of a group is light to load: `--help` needs no more.


def _driving_arguments() -> Mapping[str, Arguments]:
    from armdrive.cli.drive.arguments import ARGUMENTS

    return ARGUMENTS


def _program_arguments() -> Mapping[str, Arguments]:
    from armdrive.cli.program.arguments import ARGUMENTS

    return ARGUMENTS


def _looking_arguments() -> Mapping[str, Arguments]:
    from armdrive.cli.look.arguments import ARGUMENTS

    return ARGUMENTS


def _learning_arguments() -> Mapping[str, Arguments]:
    from armdrive.cli.learn.arguments import ARGUMENTS

    return ARGUMENTS


def _set_up_arguments() -> Mapping[str, Arguments]:
    from armdrive.cli.set_up.arguments import ARGUMENTS

    return ARGUMENTS


# Commands that need the same libraries are loaded together; where one would wait for libraries of
# another, they are not. A module's own imports stand at its top.


def _arm_commands() -> Mapping[str, Command]:
    from armdrive.cli.drive import disable, enable, home, move, reset, verify

    return {
        "disable": disable.run,
        "enable": enable.run,
        "home": home.run,
        "move": move.run,
        "reset": reset.run,
        "verify": verify.run,
    }


def _point_commands() -> Mapping[str, Command]:
    from armdrive.cli.drive import points

    return {"points": points.run}


def _jog_commands() -> Mapping[str, Command]:
    from armdrive.cli.drive import jog

    return {"jog": jog.run}


def _requests_to_other_programs() -> Mapping[str, Command]:
    from armdrive.cli.control_requests import pause, record, resume, slow, stop

    return {"record": record, "pause": pause, "resume": resume, "slow": slow, "stop": stop}


def _run_commands() -> Mapping[str, Command]:
    from armdrive.cli.program import run

    return {"run": run.run}


def _shell_commands() -> Mapping[str, Command]:
    from armdrive.cli.program import shell

    return {"shell": shell.run}


def _teaching_commands() -> Mapping[str, Command]:
    from armdrive.cli.program import demo, pendant, teach

    return {"demo": demo.run, "pendant": pendant.run, "teach": teach.run}


def _status_commands() -> Mapping[str, Command]:
    from armdrive.cli.look import status, watch

    return {"status": status.run, "watch": watch.run}


def _recording_commands() -> Mapping[str, Command]:
    from armdrive.cli.look import log, replay

    return {"log": log.run, "replay": replay.run}


def _arm_file_commands() -> Mapping[str, Command]:
    from armdrive.cli.set_up import config, ports

    return {"config": config.run, "ports": ports.run}


def _can_commands() -> Mapping[str, Command]:
    from armdrive.cli.set_up import can

    return {"can": can.run}


def _diagnosis_commands() -> Mapping[str, Command]:
    from armdrive.cli.set_up import doctor

    return {"doctor": doctor.run}


def _sim_commands() -> Mapping[str, Command]:
    from armdrive.cli.set_up import sim

    return {"sim": sim.run}


def _pose_commands() -> Mapping[str, Command]:
    from armdrive.cli.learn.poses import fk, ik

    return {"fk": fk, "ik": ik}


def _textbook_commands() -> Mapping[str, Command]:
    from armdrive.cli.learn import explain

    return {"explain": explain.run}


def _drawing_commands() -> Mapping[str, Command]:
    from armdrive.cli.learn import plot

    return {"plot": plot.run}


def _error_commands() -> Mapping[str, Command]:
    from armdrive.cli.learn import errors

    return {"errors": errors.run}


_COMMANDS: Mapping[str, CommandRow] = MappingProxyType(
    {
        "demo": (
            _program_arguments,
            _teaching_commands,
            "watch the simulated arm pick and place blocks",
        ),
        "jog": (_driving_arguments, _jog_commands, "drive an arm from the keyboard"),
        "move": (_driving_arguments, _arm_commands, "move an arm to joint angles or to a pose"),
        "run": (
            _program_arguments,
            _run_commands,
            "run a program, or rehearse it: a program file or a Python script",
        ),
        "shell": (
            _program_arguments,
            _shell_commands,
            "type the words of a program at a prompt, each carried out at once",
        ),
        "points": (
            _driving_arguments,
            _point_commands,
            "name places of an arm, and go to them; step through sequences of them",
        ),
        "teach": (
            _program_arguments,
            _teaching_commands,
            "record sequences as the arm is moved, and edit them step by step",
        ),
        "pendant": (
            _driving_arguments,
            _teaching_commands,
            "the program in an arm's own memory: into a file, and back",
        ),
        "home": (_driving_arguments, _arm_commands, "reference an arm in its reference posture"),
        "verify": (
            _driving_arguments,
            _arm_commands,
            "measure at the reference mark how far an arm has drifted",
        ),
        "enable": (
            _driving_arguments,
            _arm_commands,
            "switch the motors on, where the controller can",
        ),
        "reset": (
            _driving_arguments,
            _arm_commands,
            "leave an error, after looking at the arm; moves nothing",
        ),
        "disable": (
            _driving_arguments,
            _arm_commands,
            "switch the motors off, which lets the arm sag: parks it first",
        ),
        "stop": (
            _driving_arguments,
            _requests_to_other_programs,
            "stop an arm that another program drives",
        ),
        "pause": (
            _driving_arguments,
            _requests_to_other_programs,
            "have an arm wait that another program drives",
        ),
        "resume": (_driving_arguments, _requests_to_other_programs, "let a paused arm go on"),
        "slow": (
            _driving_arguments,
            _requests_to_other_programs,
            "have an arm go slower than the program that drives it asks for",
        ),
        "watch": (_looking_arguments, _status_commands, "watch an arm that another program drives"),
        "status": (
            _looking_arguments,
            _status_commands,
            "show where an arm is, and whether that can be trusted",
        ),
        "record": (
            _looking_arguments,
            _requests_to_other_programs,
            "write down what has passed between an arm and the program that drives it",
        ),
        "log": (
            _looking_arguments,
            _recording_commands,
            "read a recording in words: bytes, requests, intents, states, errors",
        ),
        "replay": (
            _looking_arguments,
            _recording_commands,
            "replay a recording against a simulated twin, and show where they part",
        ),
        "fk": (_learning_arguments, _pose_commands, "joint angles to the pose of the finger tips"),
        "ik": (_learning_arguments, _pose_commands, "a pose to joint angles, every solution"),
        "explain": (
            _learning_arguments,
            _textbook_commands,
            "an arm worked out: link table, A matrices, forward, every inverse",
        ),
        "plot": (_learning_arguments, _drawing_commands, "draw what an arm can reach"),
        "config": (
            _set_up_arguments,
            _arm_file_commands,
            "arm files: write one by an interview, list, show, check them",
        ),
        "ports": (
            _set_up_arguments,
            _arm_file_commands,
            "list the serial ports, who has them, and which arm files name them",
        ),
        "can": (
            _set_up_arguments,
            _can_commands,
            "set up drives on a CAN bus, and watch what passes there",
        ),
        "doctor": (
            _set_up_arguments,
            _diagnosis_commands,
            "find out what a port leads to, and what is wrong with it; moves nothing",
        ),
        "sim": (_set_up_arguments, _sim_commands, "run a simulated arm that speaks the real bytes"),
        "errors": (
            _learning_arguments,
            _error_commands,
            "what an error means for the arm, and what to do, by its code",
        ),
    }
)
"""Every command: what loads its options, what loads it, and its line of help."""

COMMANDS: Mapping[str, str] = MappingProxyType({name: row[2] for name, row in _COMMANDS.items()})
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
    arguments, load, summary = _COMMANDS[word]
    return run_command(word, summary, arguments()[word], load, words[1:])


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

"""The options of the commands that set an arm up, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.options import (
    Action,
    Declare,
    add_actions,
    add_json_option,
    add_options,
    count,
    name,
)
from armdrive.errors import BadRequest
from armdrive.registry import LANGUAGES
from armdrive.setup.templates import TEMPLATES

# --- completion


SHELLS = ("bash", "zsh", "fish")


def _completion(parser: argparse.ArgumentParser) -> None:
    r"""Print a script that makes your shell complete armdrive's words on Tab.

    Put the script where your shell looks for it. In every terminal opened after that, Tab completes
    commands, options, dialects, models, error codes and files:

      armdrive completion bash \
          > ~/.local/share/bash-completion/completions/armdrive
      armdrive completion zsh > ~/.zfunc/_armdrive       with fpath+=~/.zfunc before compinit
      armdrive completion fish > ~/.config/fish/completions/armdrive.fish
    """
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help=", ".join(SHELLS))


# --- config


def _config_new(parser: argparse.ArgumentParser) -> None:
    """Declare what `config new` takes.

    Operands:
      [NAME]  name of the arm

    Options:
      --template TEMPLATE  template: %(choices)s
      --port PORT          its port
      --answers ANSWERS    file of answers in TOML; the rest: defaults
      --yes                every default, without asking
      --force              overwrite an arm file of that name
    """
    add_options(parser, _config_new, {"[NAME]": str, "PORT": str, "TEMPLATE": TEMPLATES})
    add_json_option(parser)


def _config_signs(parser: argparse.ArgumentParser) -> None:
    """Declare what `config signs` and `config limits` take.

    Operands:
      NAME  an arm file, by name or path

    Options:
      --sim  on its simulated twin; writes nothing
      --yes  a simulated arm: no questions
    """
    add_options(parser, _config_signs)
    add_json_option(parser)


def _config_show(parser: argparse.ArgumentParser) -> None:
    """Declare what `config show` takes.

    Operands:
      NAME  an arm file, by name or path
    """
    add_options(parser, _config_show)
    add_json_option(parser)


def _config_check(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("arms", nargs="*", metavar="NAME", help="names or paths; none: all")
    add_json_option(parser)


def _config_default(parser: argparse.ArgumentParser) -> None:
    """Declare what `config set-default` takes.

    Operands:
      [NAME]  an arm file's name, or sim:DIALECT

    Options:
      --none  instead: remove the default
    """
    add_options(parser, _config_default, {"[NAME]": str, "NAME": str})
    add_json_option(parser)


# Every action of `config`.
CONFIG_ACTIONS: Mapping[str, Action] = MappingProxyType({
    "new": Action("ask questions and write an arm file",
                  "set_up.config_new:new", _config_new),
    "signs": Action("turn each motor a little to find its direction",
                    "set_up.arm_trials:signs", _config_signs),
    "limits": Action("check that each limit switch raises an alarm",
                     "set_up.arm_trials:limits", _config_signs),
    "list": Action("list the arm files",
                   "set_up.config:list_arms", add_json_option),
    "show": Action("print an arm file with every key, and how the arm stops",
                   "set_up.config:show", _config_show),
    "check": Action("report every problem of an arm file",
                    "set_up.config:check", _config_check),
    "set-default": Action("choose the arm that is used if none is named",
                          "set_up.config:set_default", _config_default),
})  # fmt: skip


def _config(parser: argparse.ArgumentParser) -> None:
    """Write arm files by answering questions; list, show and check them.

    Examples:
      armdrive config new                                 questions, line by line
      armdrive config new bench --template printed-six --yes
      armdrive config signs bench                         which way the motors turn
      armdrive config limits bench                        do the limit switches stop the arm?
      armdrive config show bench                          every key with its value
      armdrive config check bench
      armdrive config set-default bench

    Every action prints JSON with --json.

    """
    add_actions(parser, CONFIG_ACTIONS)


# --- can


def _can_monitor(parser: argparse.ArgumentParser) -> None:
    """Declare what `can monitor` takes.

    Each line has the time in seconds, the frame as candump writes it, and > for a request, < for an
    answer or ? for a frame of another protocol. A wrong check byte is marked. Frames of other
    devices are shown unchanged.

    The arm file says which protocol the drives speak. For a bus that is named, --protocol does:
    mks (the default) or canopen. With CANopen, --id is the number of a node, and all of its
    services are shown.

    On socketcan any number of programs can listen at the same time. An slcan adapter is a serial
    port, which only one program can open. If that program is an armdrive of yours, this command
    asks it for the frames of its own drives, by the arm's name or by the port as the arm file has
    it. To see all frames, put a second adapter on the bus, or listen while no program drives the
    arm. `armdrive record --arm NAME` saves the frames so far.

      armdrive can monitor can:socketcan:can0 --id 3
      armdrive can monitor can:socketcan:can0 --protocol canopen
      armdrive can monitor --arm bench --seconds 10 --json

    Operands:
      [PORT]  can:INTERFACE:CHANNEL?...

    Options:
      --arm NAME           instead: the adapter of an arm file
      --id ID              only this id; may be repeated
      --protocol PROTOCOL  protocol of the drives (default: as the arm file says, else mks)
      --seconds SECONDS    end after this time
      --count N            end after N frames
    """
    add_options(
        parser, _can_monitor, {"[PORT]": name, "ID": _node, "PROTOCOL": LANGUAGES, "N": count}
    )
    add_json_option(parser)


def _node(word: str) -> int:
    try:
        found = int(word, 0)
    except ValueError:
        found = -1
    if found < 0:
        raise BadRequest(f"an id is a number such as 3 or 0x1F, not {word!r}")
    return found


def _can_setup(parser: argparse.ArgumentParser) -> None:
    """Declare what `can setup` takes.

    Each question says what will happen; nothing is written and nothing turns without a yes. `?`
    explains, and Ctrl-C leaves: the same command continues from there. At the end it writes the arm
    file. If there is an arm file of that name, its model and ids are used; otherwise the arm is
    taken for a Mini-mover on MKS drives. Of CiA 402 drives, the units of speed and ramps are
    measured by slow turns.

    The adapter, exactly:

      can:slcan:/dev/ttyACM0?bitrate=500000     a CANable with slcan firmware: it is a serial port
      can:socketcan:can0                        candleLight firmware, on Linux, interface up
      can:gs_usb:0?bitrate=500000               the same on Windows and macOS

    `armdrive ports` lists the adapters that are there, each with its line.

    Operands:
      NAME  the arm: an arm file's name, or that of a new one

    Options:
      --port PORT  the adapter, if the arm file does not name it
      --again      repeat the steps of drives that are ready
      --sim        practise on simulated new drives
      --yes        with --sim: no questions
    """
    add_options(parser, _can_setup, {"NAME": str})
    add_json_option(parser)


# Every action of `can`.
CAN_ACTIONS: Mapping[str, Action] = MappingProxyType({
    "setup": Action("commission new drives, or measure their units, and write the arm file",
                    "set_up.can_setup:set_up", _can_setup),
    "monitor": Action("show what passes on a bus in words; sends nothing",
                      "set_up.can_monitor:monitor", _can_monitor),
})  # fmt: skip


def _can(parser: argparse.ArgumentParser) -> None:
    """Set up drives on a CAN bus, and show its traffic.

    Examples:
      armdrive can setup bench --port 'can:slcan:/dev/ttyACM0?bitrate=500000'
      armdrive can setup bench --sim                      practise on simulated new drives
      armdrive can monitor can:socketcan:can0             what passes, in words; sends nothing
      armdrive can monitor --arm bench --seconds 5 --json

    `armdrive doctor --can` lists the drives on a bus, and checks the bus. The page
    docs/controllers/can.md goes from the box to the first motion.

    """
    add_actions(parser, CAN_ACTIONS)


# --- doctor


def _doctor(parser: argparse.ArgumentParser) -> None:
    """Find out what is connected to a port and what is wrong with it; moves nothing.

    Opening a port can restart the board behind it: motors then lose their current, and a raised
    arm sags. So this command asks first, unless --yes is given.

    With --arm or --dialect it connects, once the right dialect has answered, and compares the
    controller's settings with the arm file; --fix writes those that differ, after asking.

      armdrive doctor /dev/ttyUSB0
      armdrive doctor --arm bench --fix
      armdrive doctor socket://192.168.4.1:23 --yes --json
      armdrive doctor --can                 list the nodes on a CAN bus and check it; only reads
      armdrive doctor --keyboard            will holding a key jog the arm here? touches no port

    Exit codes: 0 all is well, 1 there is a problem, 3 you did not agree to open the port, 4 the
    port cannot be opened, 6 no arm was recognised.

    Operands:
      [PORT]  a serial port or an address

    Options:
      --arm NAME                 instead: the port of an arm file
      --dialect DIALECT          the expected dialect
      --baud RATE                try only this baud rate
      --keyboard                 instead: examine the keyboard of this terminal
      --can [INTERFACE:CHANNEL]  instead: survey a CAN bus
      --ids 1-16,20              with --can: ask these ids
      --fix                      write the settings that differ
      --yes                      do not ask before opening or writing
    """
    add_options(parser, _doctor)
    add_json_option(parser)


# --- ports


def _ports(parser: argparse.ArgumentParser) -> None:
    """List the serial ports, which program has each open, and which arm file names it.

    No port is opened: `armdrive doctor PORT` does that, and asks first.
    """
    add_json_option(parser)


# --- sim


def _sim(parser: argparse.ArgumentParser) -> None:
    r"""Run a simulated arm that any program can connect to.

    Operands:
      [DIALECT]  its dialect: %(choices)s

    Options:
      --arm NAME        instead: the arm of an arm file, by name or path
      --listener PATH   with --slcan: a second adapter on the bus, to listen with
      --baud RATE       transfer bytes as fast as a line of this rate
      --set NAME=VALUE  a setting of the device; may be repeated
      --play STEPS      backlash of every motor: this many steps move nothing after a reversal
      --fault NAME[:ARGUMENTS][@SECONDS]
                        inject a fault, at once or later; may be repeated

    One of:
      --pty PATH       a new serial port, linked from PATH
      --slcan PATH     a new CAN adapter on a serial port
      --tcp HOST:PORT  a TCP port (the way on Windows)
      --udp HOST:PORT  a UDP port, unpaced
      --list           list settings and faults, and end

    Examples:
      armdrive sim teachmover --pty /tmp/arm
      armdrive jog --port /tmp/arm --dialect teachmover   in another terminal
      armdrive sim teachmover --tcp 127.0.0.1:4001        as socket://127.0.0.1:4001
      armdrive sim mks --slcan /tmp/can0                  as can:slcan:/tmp/can0?bitrate=500000
      armdrive sim --arm bench --pty /tmp/arm             the arm of a file
      armdrive sim teachmover --pty /tmp/arm \
          --fault drop:0.01,from=host --fault unplug@20
      armdrive sim --list                                 every dialect, its settings and its faults

    Commands on standard input control the device, one per line (`help` lists them). Ctrl-C ends
    it; the end of the input does not.

    """
    add_options(parser, _sim, {"STEPS": count})


ARGUMENTS: Mapping[str, Declare] = MappingProxyType(
    {
        "can": _can,
        "completion": _completion,
        "config": _config,
        "doctor": _doctor,
        "ports": _ports,
        "sim": _sim,
    }
)

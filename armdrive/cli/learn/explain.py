"""Print the lecture's worked example of an arm, for the reader's own numbers."""

from __future__ import annotations

import argparse

from armdrive.cli.presenter import emit, say
from kinematics.presets import PRESETS
from kinematics.textbook.systems import SYSTEMS


def run(options: argparse.Namespace) -> int:
    """Print it."""
    if options.list or options.system is None:
        _list(as_json=options.json)
        return 0
    # solvers, symbols and the studies of systems, which their list does without
    from armdrive.cli.learn.explain_worked import explain_system

    explain_system(options)
    return 0


def _list(*, as_json: bool) -> None:
    if as_json:
        emit(
            {
                "systems": [
                    {
                        "name": each.name,
                        "title": each.title,
                        "source": each.source,
                        "joints": list(each.joint_names),
                        "goal": list(each.coordinates),
                    }
                    for each in SYSTEMS.values()
                ]
            }
        )
        return
    width = max(map(len, SYSTEMS)) + 2
    for name, each in SYSTEMS.items():
        say(f"{name:<{width}}{each.title}")
        say(f"{'':<{width}}{each.source}")
    say("")
    others = ", ".join(key for key in PRESETS if key not in SYSTEMS)
    say(f"or an arm of the Mini-mover's build: {others}")
    say("or a link table of your own: armdrive explain FILE.toml")
    say("what computing them costs:   armdrive explain efficiency")
    say("how exact an arm is:         armdrive explain accuracy")

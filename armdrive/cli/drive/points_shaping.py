"""`armdrive points copy`, `mirror` and `offset`: new points and sequences from old ones."""

from __future__ import annotations

import argparse
import math

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.presenter import emit, say
from armdrive.config.arm import ArmConfig
from armdrive.programs.teaching.shape import Offset, Shape, mirrored, offset, shaped
from armdrive.storage.point_file import points_of
from armdrive.storage.points import check_name


def shape(options: argparse.Namespace) -> int:
    """Make the new from the old, look at every point, and write them all or none."""
    config = chosen_target(options).config
    book = points_of(config.name, config.model.arm)
    taught = book.read()
    points, sequences = shaped(
        config,
        options.name,
        check_name(options.new),
        (taught.points, taught.sequences),
        _change(options, config),
    )
    book.put_all(points, sequences, again=options.again)
    if options.json:
        emit({"name": options.new, "points": list(points), "sequences": list(sequences)})
    else:
        for name, point in points.items():
            say(f"{name}: {point.joints}")
        for name, steps in sequences.items():
            say(f"{name}: sequence of {len(steps.steps)} steps")
    return 0


def _change(options: argparse.Namespace, config: ArmConfig) -> tuple[Shape, str]:
    """Return how postures change, and the words for the notes."""
    if options.action == "copy":
        return (lambda joints: joints), ""
    if options.action == "mirror":
        return (lambda joints: mirrored(config, joints)), f"{options.name} mirrored"
    by = Offset(options.x, options.y, options.z, math.radians(options.turn))
    return (lambda joints: offset(config, joints, by)), f"{options.name} offset by {by}"

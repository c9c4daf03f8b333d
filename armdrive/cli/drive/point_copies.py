"""Points made from others: copy, mirror and offset. The new one is checked; no arm is connected."""

from __future__ import annotations

import argparse
import math
from functools import partial

from armdrive.cli.arm_files import chosen_points
from armdrive.cli.presenter import Result
from armdrive.config.arm import ArmConfig
from armdrive.motion.shape import Offset, Shape, derived, mirrored, offset
from armdrive.storage.points import check_name, point_view


def derive(options: argparse.Namespace) -> Result:
    """Copy, mirror or offset a point; the new one is checked before it is written."""
    config, book = chosen_points(options)
    new = check_name(options.new)
    shape, note = _shape(options, config)
    made = derived(config, options.name, book[options.name], shape, note)
    book.put_all({new: made}, again=options.again)
    return Result({"name": new, **point_view(made)}, f"{new}: {made.joints}")


def _shape(options: argparse.Namespace, config: ArmConfig) -> tuple[Shape, str]:
    """Return what an action makes of a posture, and the note about it."""
    if options.action == "copy":
        return lambda joints: joints, ""
    if options.action == "mirror":
        return partial(mirrored, config), f"{options.name} mirrored"
    by = Offset(options.x, options.y, options.z, math.radians(options.turn))
    return partial(offset, config, by=by), f"{options.name} offset by {by}"

"""The file of an arm's saved points: list, show, rename, delete, copy, mirror and offset them."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

from armdrive.cli.arm_files import chosen_points
from armdrive.cli.presenter import Result
from armdrive.config.arm import ArmConfig
from armdrive.motion.shape import Offset, Shape, derived, mirrored, offset
from armdrive.status import pose_view
from armdrive.storage.points import Point, check_name, point_view
from kinematics.text import mm_text


def list_points(options: argparse.Namespace) -> Result:
    """List the points, and where their file is."""
    _, book = chosen_points(options)
    points = book.read()
    view = {"file": str(book.path), "points": {n: point_view(each) for n, each in points.items()}}
    return Result(view, _listed(book.path, points))


def _listed(path: Path, points: Mapping[str, Point]) -> Iterator[str]:
    yield str(path)
    width = max(map(len, points), default=0) + 2
    for name, point in points.items():
        yield f"  {name:<{width}}{point.joints}{f'   {point.note}' * bool(point.note)}"
    if not points:
        yield "  no points yet: `armdrive points save NAME` saves the place where the arm is"


def show(options: argparse.Namespace) -> Result:
    """Show a point."""
    config, book = chosen_points(options)
    point = book[options.name]
    pose = config.model.arm.fk(point.joints)
    lines = [f"joints {point.joints}", f"tip {pose}"]
    if point.opening_mm is not None:
        lines.append(f"gripper {mm_text(point.opening_mm)}")
    if point.taught is not None:
        lines.append(f"taught {point.taught:%Y-%m-%d %H:%M}")
    if point.note:
        lines += point.note.split("\n")
    return Result({"name": options.name, **point_view(point), "pose": pose_view(pose)}, lines)


def rename(options: argparse.Namespace) -> Result:
    """Rename a point."""
    _, book = chosen_points(options)
    book.rename(options.name, options.new)
    return _done(f"{options.name} is now {options.new}")


def delete(options: argparse.Namespace) -> Result:
    """Delete a point."""
    _, book = chosen_points(options)
    del book[options.name]
    return _done(f"{options.name} is deleted")


def _done(text: str) -> Result:
    return Result({"done": text}, text)


# Points made from others. No arm is connected.


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

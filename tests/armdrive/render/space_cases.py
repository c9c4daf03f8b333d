"""Arms, scenes and strategies for the tests of drawings in space; run it to renew the pictures.

`PYTHONPATH=. python tests/armdrive/render/space_cases.py` writes the pictures
as they are drawn now: look at them first.
"""

from dataclasses import replace
from pathlib import Path

from hypothesis import strategies as st

from armdrive.render.camera import VIEWS, Camera
from armdrive.render.scene import ArmDrawing, Moment, Studio
from kinematics import Joints, preset
from kinematics.chains.arm import ChainArm
from kinematics.frames.transforms import translation
from kinematics.guards import Guards
from kinematics.guards.shapes import Box
from kinematics.textbook.systems import system

PICTURES = Path(__file__).parent / "pictures"

HERE = Joints.of(20.0, 60.0, -80.0, -60.0, 15.0)
GOAL = Joints.of(-30.0, 40.0, -60.0, -60.0, 15.0)
PLANNED = tuple((x, 10.0, 200.0) for x in range(200, 301, 20))

SIZES = st.tuples(st.integers(0, 90), st.integers(0, 40))
CAMERAS = st.builds(
    Camera,
    st.integers(0, 359),
    st.integers(-90, 90),
    st.integers(-4, 14),
    st.none() | st.tuples(*(st.floats(-500.0, 500.0) for _ in "xyz")),
)


def guarded(**more):
    """A TeachMover's model with a base column and a tray to keep out of."""
    model = preset("teachmover")
    tray = Box("tray", (200.0, -150.0, 0.0), (320.0, -60.0, 60.0))
    more = {"boxes": (tray,), "radii_mm": (20.0, 20.0, 15.0), "base_radius_mm": 70.0} | more
    return replace(model, guards=replace(model.guards, **more))


def six_axes():
    """A Puma on a column as a model: six joints, no guards."""
    chain = replace(system("puma").chain(), base=translation(0.0, 0.0, 660.0))
    return replace(preset("teachmover"), arm=ChainArm(chain), guards=Guards())


def driven(model):
    """A scene whose arm has come a little way, with its outline worked out."""
    scene = ArmDrawing(model)
    for step in range(60, -1, -1):
        scene.space(Moment(Joints.of(20.0 - step * 0.8, 60.0 - step * 0.2, -80.0, -60.0, 15.0)))
    scene.keep(scene.missing, scene.work_out(scene.missing))
    return scene


def picture(view, *, braille, width=100, height=34):
    """The rows of a picture with everything in it."""
    scene = driven(guarded())
    moment = Moment(HERE, 38.0, goal=GOAL, planned=PLANNED)
    studio = Studio(scene.dome, braille=braille)
    return studio.draw(scene.space(moment), VIEWS[view], width, height).rows()


def picture_file(view, *, braille):
    return PICTURES / f"{view}-{'braille' if braille else 'ascii'}.txt"


def main():
    PICTURES.mkdir(exist_ok=True)
    for view in VIEWS:
        for braille in (True, False):
            text = "\n".join(row.rstrip() for row in picture(view, braille=braille))
            picture_file(view, braille=braille).write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

"""The systems of the lecture notes by name: models with figure, link table, FK and every IK branch.

`system("puma")` gives one, `SYSTEMS` all of them. Lengths in mm, angles in rad.
"""

from kinematics.textbook.systems.mini_movers import Alpha2, MiniBuild, MiniMover
from kinematics.textbook.systems.named import Miss, NamedBranch, NamedStep, Quantity, System
from kinematics.textbook.systems.puma import Puma
from kinematics.textbook.systems.registry import SYSTEMS, system
from kinematics.textbook.systems.three_link import ThreeLink
from kinematics.textbook.systems.transporters import (
    CartesianTransporter,
    CylindricalTransporter,
    RevoluteTransporter,
    SphericalTransporter,
    Transporter,
)
from kinematics.textbook.systems.two_link import (
    TwoLink,
    TwoLinkType1,
    TwoLinkType2,
    TwoLinkType3,
    TwoLinkType4,
    TwoLinkType5,
    Workspace,
)
from kinematics.textbook.systems.wrist import WristArm

__all__ = [
    "SYSTEMS",
    "Alpha2",
    "CartesianTransporter",
    "CylindricalTransporter",
    "MiniBuild",
    "MiniMover",
    "Miss",
    "NamedBranch",
    "NamedStep",
    "Puma",
    "Quantity",
    "RevoluteTransporter",
    "SphericalTransporter",
    "System",
    "ThreeLink",
    "Transporter",
    "TwoLink",
    "TwoLinkType1",
    "TwoLinkType2",
    "TwoLinkType3",
    "TwoLinkType4",
    "TwoLinkType5",
    "Workspace",
    "WristArm",
    "system",
]

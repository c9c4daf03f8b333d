"""The systems of the lecture notes by name: models with figure, link table, FK and every IK branch.

`system("puma")` gives one, `SYSTEMS` all of them. Lengths in mm, angles in rad.
"""

from kinematics.systems.alpha2 import Alpha2
from kinematics.systems.mini_build import MiniBuild
from kinematics.systems.minimover import MiniMover
from kinematics.systems.named_system import Miss, NamedBranch, Quantity, Step, System
from kinematics.systems.puma import Puma
from kinematics.systems.registry import SYSTEMS, system
from kinematics.systems.revolute_transporter import RevoluteTransporter
from kinematics.systems.spherical_wrist import WristArm
from kinematics.systems.three_link import ThreeLink
from kinematics.systems.transporters import (
    CartesianTransporter,
    CylindricalTransporter,
    SphericalTransporter,
    Transporter,
)
from kinematics.systems.two_link import TwoLink, Workspace
from kinematics.systems.two_link_lifting import TwoLinkType4, TwoLinkType5
from kinematics.systems.two_link_sliding import TwoLinkType3
from kinematics.systems.two_link_turning import TwoLinkType1, TwoLinkType2

__all__ = [
    "SYSTEMS",
    "Alpha2",
    "CartesianTransporter",
    "CylindricalTransporter",
    "MiniBuild",
    "MiniMover",
    "Miss",
    "NamedBranch",
    "Puma",
    "Quantity",
    "RevoluteTransporter",
    "SphericalTransporter",
    "Step",
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

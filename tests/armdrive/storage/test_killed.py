"""A program that is really killed at chosen moments of a move, and what the next one believes."""

from __future__ import annotations

import os

import pytest

from armdrive.status import Trust

STILL_S = 0.2

ORDERS = (
    ({"disk": 0}, Trust.RESTORED),  # before anything of the mark is written
    ({"disk": 5}, Trust.RESTORED),  # before the mark is renamed into its place
    ({"disk": 6}, Trust.SUSPECT),  # the mark is in its place, nothing has moved
    ({"wire": 1, "bytes": 9}, Trust.SUSPECT),  # half of a motion's message is out
    ({"moving": True}, Trust.SUSPECT),  # in mid-motion
    ({"disk": 13}, Trust.RESTORED),  # the mark was cleared
    ({}, Trust.RESTORED),  # not killed at all
)


@pytest.mark.skipif(os.name != "posix", reason="a pseudo-terminal and SIGKILL are POSIX")
def test_nothing_wrong_is_believed_of_an_arm_whose_program_was_killed(tmp_path):
    from killing_ground import KillingGround

    with KillingGround(tmp_path) as ground:
        found = [ground.kill(**order, still_s=STILL_S) for order, _ in ORDERS]
    assert [str(each) for each in found if each.wrong] == []
    assert [each.killed for each in found] == [bool(order) for order, _ in ORDERS]
    assert [each.trust for each in found] == [trust for _, trust in ORDERS]

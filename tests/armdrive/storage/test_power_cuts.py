"""A program, a computer or the house loses its power at every moment of a move: what is believed.

The law: nothing is believed that is not true. A position that is restored is where the motors
physically stood, and an arm that was in motion is never restored.
"""

import os

import pytest
from power_disk import End, Moments
from power_life import PATH, believed, move, recorded_life, wrong

from armdrive.runtime.persistence import Memory
from armdrive.status import Trust
from kinematics import Joints


def ended_at(moment, work=move, prepare=lambda life: None):
    """Live until a moment; None where the work is over before it."""
    life = recorded_life()
    prepare(life)
    life.disk.moments = Moments(moment)
    try:
        work(life)
    except End:
        return life
    return None


def host_cut(moment, **how):
    """The program is killed, or its computer loses the power; the arm makes the motion it has."""
    life = ended_at(moment, **how)
    if life is None:
        return None
    life.end()
    truth = life.motors
    texts = {life.disk.after_kill(PATH)} | life.disk.after_power_cut(PATH)
    return [(*believed(life, text), truth) for text in texts]


def house_cut(moment, **how):
    """Both lose their power: the arm stops dead, and its registers are zero afterwards.

    No record can know how an arm sagged that was let go; where it stood until then is the truth.
    """
    life = ended_at(moment, **how)
    if life is None:
        return None
    moving = life.twin.device.moving
    truth = None if moving else life.motors
    life.twin.device.power_off()
    life.end()
    life.twin.device.power_on()
    return [(*believed(life, text), truth) for text in life.disk.after_power_cut(PATH)]


def everywhere(cut, **how):
    """Yield (moment, trust, believed position, truth) for every moment until the work is done."""
    moment = 0
    while (found := cut(moment, **how)) is not None:
        yield from ((moment, *each) for each in found)
        moment += 1


@pytest.mark.parametrize("cut", [host_cut, house_cut])
def test_nothing_wrong_is_believed_after_an_end_at_any_moment(cut):
    found = list(everywhere(cut))
    assert list(wrong(found)) == []
    assert {trust for _, trust, *_ in found} == {Trust.RESTORED, Trust.SUSPECT}
    assert found[0][1] is Trust.RESTORED
    after_the_last = {trust for moment, trust, *_ in found if moment == found[-1][0]}
    assert (Trust.RESTORED in after_the_last) is (cut is not house_cut)


def test_a_disk_that_keeps_nothing_would_be_found_out():
    def forget(life):
        life.disk.forgetful = True

    assert any(wrong(everywhere(house_cut, prepare=forget)))


def test_a_driver_without_the_mark_would_be_found_out(monkeypatch):
    monkeypatch.setattr(Memory, "begin_mark", lambda memory: None)
    monkeypatch.setattr(Memory, "mark_stands", lambda memory: True)
    assert any(wrong(everywhere(house_cut)))


PUSHED = Joints.of(8.0, 40.0, -80.0, -40.0, 0.0)


def push(life):
    """A hand turns the arm, which no register shows."""
    world = life.twin.world
    world.drive_to(world.body.transmission.to_motors(PUSHED, 20.0))


def refer_anew(life):
    arm = life.connect()
    arm.reference.declare(PUSHED, opening_mm=20.0)
    life.told = True


def test_a_new_reference_is_on_the_disk_before_the_call_returns():
    lives = []

    def work(life):
        life.told = False
        lives.append(life)
        refer_anew(life)
        life.disk.moments.pass_one()

    found = list(everywhere(host_cut, prepare=push, work=work))
    told = {moment for moment, life in enumerate(lives) if life.told}
    assert told
    assert not told & set(wrong(found))
    untold = [each for each in found if each[0] not in told]
    assert {trust for _, trust, *_ in untold} == {Trust.RESTORED}, "as it was before"


def drop_current(life):
    arm = life.connect(allow_restored=True)
    arm.disable()
    arm.close()


def test_an_arm_whose_motors_were_off_is_never_restored():
    found = list(everywhere(host_cut, work=drop_current))
    assert list(wrong(found)) == []
    assert found[-1][1] is Trust.SUSPECT


def test_doubts_of_the_last_connection_outlive_it_even_if_the_registers_agree_again():
    life = recorded_life()
    life.twin.device.jog((30, 0, 0, 0, 0, 0))
    assert life.connect().status.trust is Trust.SUSPECT
    life.end()  # killed, without a word
    life.twin.device.jog((-30, 0, 0, 0, 0, 0))
    assert believed(life, life.disk.after_kill(PATH))[0] is Trust.SUSPECT


# -- a program that is really killed --------------------------------------------------------------
#
# Few moments, to see that a real file system and a real lock are what `PowerDisk` takes them for.


STILL_S = 0.2

ORDERS = (
    ({"disk": 5}, Trust.RESTORED),  # before the mark is renamed into its place
    ({"disk": 6}, Trust.SUSPECT),  # the mark is in its place, nothing has moved
    ({"moving": True}, Trust.SUSPECT),  # in mid-motion
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

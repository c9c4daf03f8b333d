"""The arithmetic of lost motion against a mechanical play, and what a record says of it."""

from dataclasses import replace

from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from armdrive.motion.deviation import lags
from armdrive.runtime.backlash import Slack, doubt_words, to_turn, turned
from armdrive.sim.world.body import Play
from armdrive.storage.record import Record, from_text, to_text
from kinematics import Motors

WIDTHS = st.integers(0, 40)
STEPS = st.integers(-90, 90)
COUNT = 3
VECTORS = st.lists(STEPS, min_size=COUNT, max_size=COUNT).map(Motors)
SLACKS = st.lists(WIDTHS, min_size=COUNT, max_size=COUNT).map(Motors)


def beside_a_play(widths, shares=(0.0, 0.5, 1.0)):
    """Return the driver's slack and a mechanical play that stands where it is taken to stand."""
    slack, play = Slack(widths), Play(widths)
    play.stand([round(share * width) for share, width in zip(shares, widths, strict=True)])
    slack.restore(play.ahead, ())
    return slack, play


@given(WIDTHS, st.lists(STEPS), st.floats(0, 1))
def test_hysteresis_is_a_pin_in_a_slot(width, steps, share):
    play = Play((width,))
    play.stand([round(share * width)])
    taken = play.ahead[0]
    for step in steps:
        (pushed,) = play.drive((step,))
        taken, driven = turned(taken, width, step)
        assert (taken, driven) == (play.ahead[0], pushed)


@given(WIDTHS, STEPS, st.floats(0, 1))
def test_a_compensated_motor_moves_its_joint_as_far_as_requested(width, steps, share):
    taken = round(share * width)
    after, driven = turned(taken, width, to_turn(taken, width, steps))
    assert driven == steps
    assert after == (taken if steps == 0 else width if steps > 0 else 0)


@given(SLACKS, st.lists(VECTORS, max_size=8))
def test_a_play_that_is_compensated_moves_by_what_was_wanted_every_time(widths, moves):
    slack, play = beside_a_play(widths)
    for steps in moves:
        sent = slack.to_send(steps)
        assert slack.sends(sent) == steps
        slack.arrive()
        assert Motors(play.drive(sent)) == steps
        assert tuple(slack.taken) == tuple(play.ahead)


@given(SLACKS, VECTORS, st.floats(0, 1))
def test_a_stop_in_the_middle_of_a_burst_is_understood_to_the_step(widths, steps, share):
    slack, play = beside_a_play(widths)
    sent = slack.to_send(steps)
    slack.sends(sent)
    made = Motors(round(count * share) for count in sent)
    assert slack.see(made) == Motors(play.drive(made))
    slack.believe()
    assert tuple(slack.taken) == tuple(play.ahead)
    assert not slack.unsure


@given(SLACKS, st.lists(VECTORS.filter(any), min_size=1, max_size=6), st.floats(0, 1), st.data())
def test_a_stop_after_reversals_is_understood_by_what_was_sent(widths, moves, share, data):
    """One that was reported in every piece, as a board that queues reports many times in each."""
    slack, play = beside_a_play(widths)
    last = data.draw(st.integers(0, len(moves) - 1))
    pieces = []
    for steps in moves:
        pieces.append(slack.to_send(steps))
        slack.sends(pieces[-1])
    made = driven = Motors([0] * COUNT)
    for piece in pieces[:last]:
        for some in (0.5, 1.0):
            slack.see(made + Motors(round(count * some) for count in piece))
        made, driven = made + piece, driven + Motors(play.drive(piece))
    part = Motors(round(count * share) for count in pieces[last])
    assert slack.see(made + part) == driven + Motors(play.drive(part))
    slack.believe()
    assert tuple(slack.taken) == tuple(play.ahead)


def test_a_stop_near_a_reversal_is_reported_as_ambiguous():
    slack, _ = beside_a_play((12, 12, 0))
    for steps in (Motors((-30, 0, 0)), Motors((10, 0, 0))):
        slack.sends(slack.to_send(steps))
    slack.see(Motors((-5, 0, 0)))
    assert not slack.vague
    slack.see(Motors((-25, 0, 0)))
    assert slack.vague
    slack.see(Motors((-30, 0, 0)))
    slack.see(Motors((-25, 0, 0)))  # it has come back, and cannot be before the reversal any more
    assert not slack.vague


def test_a_long_motion_is_remembered_as_far_as_it_can_still_be_under_way():
    slack, play = beside_a_play((7, 0, 3))
    made = driven = Motors([0, 0, 0])
    for number in range(3000):
        steps = Motors([5 if number // 40 % 2 else -5, 2, number % 3 - 1])
        piece = slack.to_send(steps)
        slack.sends(piece)
        made, driven = made + piece, driven + Motors(play.drive(piece))
        if number % 3 == 0:
            assert slack.see(made) == driven
    slack.see(made)
    slack.believe()
    assert tuple(slack.taken) == tuple(play.ahead)


@given(SLACKS, VECTORS)
def test_a_motor_turned_from_outside_has_unknown_backlash(widths, steps):
    slack, _ = beside_a_play(widths)
    slack.see(steps)
    slack.believe()
    assert bool(slack.unsure) == bool(steps.largest and any(widths))


@given(SLACKS, st.lists(VECTORS, max_size=6), st.floats(0, 1))
def test_backlash_is_called_known_only_if_it_is_right(widths, moves, share):
    """The side of the play is known if every possible beginning leads to it."""
    slack, play = Slack(widths), Play(widths)
    play.stand([round(share * width) for width in widths])
    for steps in moves:
        sent = slack.to_send(steps)
        slack.sends(sent)
        slack.arrive()
        play.drive(sent)
    slack.refer()
    for motor, (taken, ahead) in enumerate(zip(slack.taken, play.ahead, strict=True)):
        if motor not in slack.unsure:
            assert taken == ahead
        assert abs(taken - ahead) <= -(-widths[motor] // 2)


def test_a_motor_that_has_gone_further_than_its_backlash_is_sure():
    slack = Slack((10, 10, 0))
    assert slack.unsure == (0, 1)
    slack.sends(Motors((10, 9, 1)))
    slack.arrive()
    assert slack.unsure == (1,)
    assert "shoulder" in doubt_words(("base", "shoulder", "elbow"), slack)
    slack.sends(Motors((-3, 1, 1)))
    slack.arrive()
    assert slack.unsure == ()
    assert doubt_words(("base", "shoulder", "elbow"), slack) == ""


def test_without_backlash_nothing_is_changed():
    slack, steps = Slack((0, 0)), Motors((3, -4))
    assert slack.to_send(steps) is steps
    assert slack.see(steps) is steps
    assert slack.unsure == ()
    assert lags(steps, steps) == (0.0, 0.0)


@given(st.integers(1, 60), st.integers(1, 60))
def test_no_load_lags_more_than_announced(steps, width):
    play = Play((width,))
    (bound,) = lags(Motors([steps]), Motors([steps + width]))
    made = driven = 0
    for _ in range(steps + width):
        made, driven = made + 1, driven + play.drive((1,))[0]
        assert made / (steps + width) * steps - driven <= bound + 1e-9


# -- the record ------------------------------------------------------------------------------

RECORD = Record("lab", "0123", (0, 7), (-3, 5), (0.1, 20.0), "referenced", "homed")


def test_the_backlash_of_a_record_comes_back():
    for taken, unsure in (((), ()), ((4, 0), ()), ((4, 0), (1,)), ((0, 0), (0, 1))):
        record = replace(RECORD, taken=taken, unsure=unsure)
        assert from_text(to_text(record)) == record


@every_row("taken", [(), (1,), (1, 11), (-1, 0)])
def test_a_record_that_does_not_fit_the_backlash_is_refused(taken):
    slack = Slack((10, 10))
    assert not slack.restore(taken, ())
    assert slack.unsure == (0, 1)

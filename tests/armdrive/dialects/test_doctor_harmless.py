"""The doctor's probes move no arm and leave nothing half received, whoever is at the port."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from amounts import every_row
from doctor_bench import (
    AFTER_S,
    LINE_ENDS_ACT,
    PREPARED,
    PROBES,
    SPOKEN,
    WHO,
    SimPort,
    check_unmoved,
    prepared,
)
from hypothesis import given
from hypothesis import strategies as st
from uart import RECEIVERS, Receiver

from armdrive.arm import Arm
from armdrive.connect.parts import assemble
from armdrive.connect.target import simulated_config
from armdrive.dialects.recognition import Probe, Recogniser, in_safe_order
from armdrive.registry import DIALECTS
from armdrive.runtime.clock import SimulatedPace
from armdrive.status import State
from firmware_protocol.armdroid import ANSWER_TO

QUICK_BAUD, SLOW_BAUD = 115_200, 9600
MEANT = {*b"0123456789-,", *map(ord, ANSWER_TO)}
"""Every byte that an Armdroid's sketch does not ignore."""


CASES = [(dialect, state) for dialect in SPOKEN for state in PREPARED[dialect]]
STILL = [case for case in CASES if "motion" not in case[1]]


def say(port: SimPort, probe: Probe) -> None:
    port.tune(probe.baud)
    for _ in range(probe.times):
        port.write(probe.data, port.now)
        port.pass_time(probe.wait_s)


@every_row("dialect, state", CASES)
@every_row("rate", ["given", "to be found", "none: native USB"])
def test_an_examination_moves_nothing(dialect, state, rate):
    port = prepared(dialect, state, any_rate=rate.startswith("none"))
    usual_baud = WHO.own_probe(dialect).baud
    found = port.examine(usual_baud if rate == "given" else None)
    assert port.closed
    if (dialect, state) in STILL:
        assert found.identity is not None
        assert (found.identity.dialect, found.baud) == (dialect, usual_baud)
    else:
        assert found.identity is None or found.identity.dialect == dialect
    check_unmoved(port, dialect, state)


@every_row("dialect, state", [each for each in CASES if each not in LINE_ENDS_ACT])
@every_row("given_baud", [True, False])
def test_sending_every_probe_moves_nothing(dialect, state, given_baud):
    port = prepared(dialect, state)
    for probe in WHO.sequence(port.device.board.baud if given_baud else None):
        say(port, probe)
    check_unmoved(port, dialect, state)


@pytest.mark.parametrize("dialect", SPOKEN)
def test_probes_move_nothing_in_any_order_that_keeps_the_harmless_line_before_read(dialect):
    state = list(PREPARED[dialect])[:2][-1]  # what is left half sent is the harshest
    line, read = PROBES[-2:]
    for order in itertools.permutations(PROBES):
        if order.index(line) < order.index(read):
            port = prepared(dialect, state)
            for probe in order:
                port.tune(port.device.board.baud)
                port.write(probe.data, port.now)
                port.pass_time(probe.wait_s)
            check_unmoved(port, dialect, state)


def test_every_order_that_the_declared_risks_forbid_is_refused_and_would_move_an_armdroid():
    """And every order that they allow leaves it where it stands, its last motion unrepeated."""
    forbidden = 0
    for order in itertools.permutations(PROBES):
        port = prepared("armdroid", "with numbers to repeat")
        before = port.device.world.motors
        for probe in order:
            port.tune(port.device.board.baud)
            port.write(probe.data, port.now)
            port.pass_time(probe.wait_s)
        port.pass_time(AFTER_S)
        moved = port.device.world.motors != before
        try:
            in_safe_order(order)
        except ValueError:
            forbidden += 1
            assert moved, [probe.name for probe in order]
        else:
            assert not moved, [probe.name for probe in order]
    assert forbidden == 60


@given(known=st.permutations(list(WHO.known.items())))
def test_probes_are_ordered_by_their_risk_however_the_dialects_are_listed(known):
    who = Recogniser(dict(known))
    assert who.probes == PROBES
    assert who.sequence() == WHO.sequence()
    assert who.sequence(SLOW_BAUD) == WHO.sequence(SLOW_BAUD)


def test_the_order_is_that_of_the_page():
    assert [probe.name for probe in PROBES] == [
        "?",
        "ping",
        "v",
        "a line that moves no arm",
        "@READ",
    ]
    assert [probe.data for probe in PROBES] == [
        b"?",
        b"\xaa\x01\x01\x01\xab\x00",
        b"v\r",
        b"@25sd,,,,,d\r",
        b"@READ\r",
    ]
    assert [(probe.name, probe.baud) for probe in WHO.sequence()[:3]] == [
        ("?", SLOW_BAUD),
        ("v", SLOW_BAUD),
        ("?", QUICK_BAUD),
    ]
    assert [probe.name for probe in WHO.sequence(datagrams=True)] == ["ping"]


def test_a_dialect_without_the_probe_that_makes_its_own_harmless_is_refused():
    line, read = PROBES[-2:]
    alone = Recogniser({"teachmover": replace(WHO.known["teachmover"], probes=(read,))})
    with pytest.raises(ValueError, match=line.name):
        alone.sequence()


@pytest.mark.parametrize(("dialect", "state"), STILL)
def test_an_arm_connects_after_an_examination(dialect, state):
    port = prepared(dialect, state)
    port.examine(None)
    before = port.device.world.motors
    port.tune(port.device.board.baud)
    pace = SimulatedPace()
    pace.clock.now_s = port.now
    arm = Arm(assemble(simulated_config(dialect), port, pace, simulated=True))
    assert arm.status.state in (State.STANDBY, State.DISABLED)
    arm.close()
    assert port.device.world.motors == before


def test_no_byte_of_the_quick_probes_means_anything_to_an_armdroid():
    for probe in PROBES[:2]:
        assert not set(probe.data) & MEANT


def test_the_table_knows_the_baud_rates_of_the_dialects():
    for probe in PROBES:
        if probe.dialect in DIALECTS:
            assert probe.baud == DIALECTS[probe.dialect].baud
    serial = {name for name, row in DIALECTS.items() if not row.can}
    assert {probe.dialect for probe in PROBES} >= serial


# What is heard at another baud rate.


def test_a_receiver_at_the_same_rate_hears_what_was_said():
    assert Receiver(9600).hear(bytes(range(256)), 9600) == bytes(range(256))


@given(receiver=RECEIVERS, gap_bits=st.sampled_from([0.0, 0.5, 3.0]))
def test_quick_probes_are_heard_at_the_slow_rate_as_bytes_that_mean_nothing(receiver, gap_bits):
    slow = Receiver(SLOW_BAUD, receiver.error, receiver.validates, receiver.by_level)
    for probe in PROBES[:2]:
        heard = slow.hear(probe.data, QUICK_BAUD, gap_bits)
        assert not set(heard) & (MEANT | {ord("\r")})
        if not gap_bits:
            assert all(byte >= 0xF0 for byte in heard)


@given(receiver=RECEIVERS, data=st.binary(min_size=1, max_size=30), gap_bits=st.floats(0.0, 5.0))
def test_whatever_is_said_slowly_is_heard_at_the_quick_rate_as_bytes_that_mean_nothing(
    receiver, data, gap_bits
):
    quick = Receiver(QUICK_BAUD, receiver.error, receiver.validates, receiver.by_level)
    ones_on_top = {0xFF & (0xFF << shift) for shift in range(9)}
    assert set(quick.hear(data, SLOW_BAUD, gap_bits)) <= ones_on_top

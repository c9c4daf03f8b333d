"""The control socket with callers that are silent, many, slow, or send nonsense."""

import contextlib
import json
import os
import re
import socket
import struct
import threading
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from armdrive.connect.control_socket import REQUESTS, serve
from armdrive.errors import ArmError, HolderError
from armdrive.storage import arm_lock
from armdrive.storage import lock_client as holder_notice
from armdrive.storage.arm_lock import (
    MOST_CALLERS,
    MOST_REQUEST_BYTES,
    MOST_WATCHERS,
    hold,
)
from armdrive.storage.lock_client import ask_holder, called, notice_of, watch_holder

posix = pytest.mark.skipif(os.name != "posix", reason="Windows' pipes keep messages whole")
SOON_S = 20.0
LONG_S = 3600.0


@pytest.fixture
def patient(monkeypatch):
    """No caller ever times out."""
    monkeypatch.setattr(arm_lock, "PATIENCE_S", LONG_S)


@pytest.fixture
def impatient(monkeypatch):
    """Callers time out at once; to be asked for before the arm is held."""
    monkeypatch.setattr(arm_lock, "PATIENCE_S", 0.05)


@pytest.fixture
def call(holding):
    """Call the holder, as often as a test likes; all calls end with the test."""
    with contextlib.ExitStack() as calls:
        yield lambda: calls.enter_context(called(notice_of("bench")["address"]))


def answered(connection):
    """Return the answer to a call, None where it was hung up on without one."""
    assert connection.poll(SOON_S)
    try:
        return json.loads(connection.recv_bytes())
    except (EOFError, ConnectionResetError):
        return None


def ended(connection):
    """Wait until a call is hung up on."""
    assert connection.poll(SOON_S)
    with pytest.raises((EOFError, ConnectionResetError)):
        connection.recv_bytes()
    return True


def own_threads():
    return [each for each in threading.enumerate() if each.name.startswith("armdrive-")]


# -- how many -------------------------------------------------------------------------------------


def test_callers_that_are_silent_hold_up_no_stop_for_longer_than_their_time(impatient, arm, call):
    silent = [call() for _ in range(3 * MOST_CALLERS)]
    assert ask_holder("bench", "stop") == {"done": "stop"}
    assert arm.parts.engine.stop_asked
    for each in silent:
        assert set(answered(each)) >= {"error"}
        assert ended(each)
    assert ask_holder("bench", "status")["state"] == "standby"


def test_too_many_callers_are_asked_to_call_again(holding, call, patient):
    silent = [call() for _ in range(MOST_CALLERS)]
    refused = answered(call())
    assert "programs call already" in refused["error"]
    assert refused["again"]
    for each in silent:
        each.send_bytes(b'{"request": "pause"}')
        assert answered(each) == {"done": "pause"}
    assert ask_holder("bench", "status")["paused"]


@posix
def test_a_watcher_that_was_turned_away_before_it_asked_learns_why(holding, monkeypatch):
    def turned_away(_address):
        ours, theirs = socket.socketpair(socket.AF_UNIX)
        with Connection(theirs.detach()) as holder:
            holder.send_bytes(b'{"error": "64 programs call already", "again": true}')
        return Connection(ours.detach())

    monkeypatch.setattr(holder_notice, "called", turned_away)
    with pytest.raises(HolderError, match="programs call already"):
        next(watch_holder("bench", 0.05))


def test_a_silent_caller_gets_an_error_and_is_disconnected_after_its_time(impatient, call):
    connection = call()
    assert "no complete request arrived within" in answered(connection)["error"]
    assert ended(connection)


@posix
def test_a_caller_that_sends_half_a_request_is_disconnected_after_its_time(impatient, arm, call):
    connection = call()
    os.write(connection.fileno(), struct.pack("!i", 20) + b'{"request": "pause"')
    assert "no complete request arrived within" in answered(connection)["error"]
    assert not arm.status.paused


@posix
def test_a_request_may_come_in_pieces(holding, call, patient):
    connection = call()
    for byte in struct.pack("!i", 20) + b'{"request": "pause"}':
        os.write(connection.fileno(), bytes([byte]))
    assert answered(connection) == {"done": "pause"}


def test_a_stop_is_answered_while_other_answers_take_their_time(arm, holding, call):
    begun, gate = threading.Semaphore(0), threading.Event()

    def program():
        begun.release()
        gate.wait(SOON_S)
        return {}

    arm.program = program
    asked = [call() for _ in range(MOST_CALLERS // 2)]
    try:
        for each in asked:
            each.send_bytes(b'{"request": "status"}')
        for _ in asked:
            assert begun.acquire(timeout=SOON_S)
        assert ask_holder("bench", "stop") == {"done": "stop"}
        assert arm.parts.engine.stop_asked
    finally:
        gate.set()
    for each in asked:
        assert answered(each)["state"] == "standby"


def test_a_system_without_free_threads_has_callers_call_again(holding, monkeypatch):
    start, refused = threading.Thread.start, []

    def started(thread):
        if thread.name == "armdrive-answer" and len(refused) < MOST_CALLERS - 10:
            refused.append(thread)
            raise RuntimeError("can't start new thread")
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", started)
    monkeypatch.setattr(holder_notice, "CALL_AGAIN_S", 0.0)
    assert ask_holder("bench", "stop") == {"done": "stop"}
    assert len(refused) == MOST_CALLERS - 10


def test_the_number_of_watchers_is_limited_and_others_get_an_error(holding):
    watching = [watch_holder("bench", 0.05) for _ in range(MOST_WATCHERS)]
    try:
        for each in watching:
            assert next(each)["state"] == "standby"
        with pytest.raises(HolderError, match=f"{MOST_WATCHERS} programs watch this arm already"):
            next(watch_holder("bench", 0.05))
        assert ask_holder("bench", "status")["state"] == "standby"
        assert ask_holder("bench", "stop") == {"done": "stop"}
    finally:
        for each in watching:
            each.close()


def test_a_watcher_that_reads_nothing_delays_no_other_caller(holding, call):
    for _ in range(MOST_WATCHERS):
        call().send_bytes(b'{"request": "wire", "every_s": 0.0}')
    assert ask_holder("bench", "stop") == {"done": "stop"}
    assert ask_holder("bench", "status")["state"] == "standby"


@pytest.mark.parametrize("silent", [False, True])
def test_giving_back_ends_every_thread_and_every_silent_call(impatient, arm, silent):
    before = own_threads()
    holding = hold("bench")
    serve(holding, arm.parts.connection)
    begun = [each for each in own_threads() if each not in before]
    ask_holder("bench", "status")  # so that the listening thread waits for the next call
    with contextlib.ExitStack() as calls:
        connection = calls.enter_context(called(notice_of("bench")["address"])) if silent else None
        holding.release()
        if connection is not None:
            answered(connection)  # that no request came, if its thread had begun to wait for one
            assert ended(connection)
    for each in begun:
        each.join(SOON_S)
        assert not each.is_alive()


# -- what -----------------------------------------------------------------------------------------

JSON_ALONE = "a request is a JSON object in UTF-8"
BAD_SPEED = f"percent is a number from 1 to 100|{JSON_ALONE}"
HUGE = "1" + "0" * 3900
BAD_SPEEDS = [
    "NaN", "Infinity", "-Infinity", "1e999", "-1e999", "-1", "0", "0.999", "100.001", "-0.0", HUGE,
    f"-{HUGE}", '"half"', '"50"', "null", "true", "[50]", '{"a": 1}', '"' + "9" * 3900 + '"',
]  # fmt: skip
BAD_REQUESTS = [
    (b"", JSON_ALONE),
    (b"{", JSON_ALONE),
    (b"[]", JSON_ALONE),
    (b"7", JSON_ALONE),
    (b'{"request": "\xff\xfe"}', JSON_ALONE),
    ('{"request": "stop"}'.encode("utf-16"), JSON_ALONE),
    (bytes(4000), JSON_ALONE),
    (b"[" * MOST_REQUEST_BYTES, JSON_ALONE),
    (b'{"a":' * 800, JSON_ALONE),
    (b"9" * MOST_REQUEST_BYTES, JSON_ALONE),  # a number beyond all reading
    (b'{"request": "slow", "percent": ' + b"[" * 1900 + b"]" * 1900 + b"}", BAD_SPEED),
    *(
        (f'{{"request": {request}}}'.encode(), "unknown request.*known are " + ", ".join(REQUESTS))
        for request in ('"dance"', "7", "null", '["stop"]', '"' + "x" * 4000 + '"')
    ),
    *((f'{{"request": "slow", "percent": {number}}}'.encode(), BAD_SPEED) for number in BAD_SPEEDS),
    *(
        (
            f'{{"request": "{request}", "every_s": {number}}}'.encode(),
            "every_s is a number of seconds, not ",
        )
        for request in ("watch", "wire")
        for number in ("NaN", '"half"', "null", "true", "[1]")
    ),
]
"""Each message, and the beginning of the one sentence that answers it."""


def test_a_bad_request_is_answered_with_one_sentence_and_changes_nothing(arm, holding, call):
    for request, sentence in BAD_REQUESTS:
        connection = call()
        connection.send_bytes(request)
        answer = answered(connection)
        assert set(answer) == {"error"}, request
        assert re.match(sentence, answer["error"]), (request, answer)
        assert len(answer["error"]) < (250 if "unknown" in sentence else 200), request
        assert ended(connection)
    assert arm.speed_override == 1.0
    assert not arm.parts.engine.stop_asked
    assert ask_holder("bench", "status")["state"] == "standby"


@posix
def test_a_request_that_is_too_long_is_refused_before_it_has_come(holding, call):
    for length in (MOST_REQUEST_BYTES + 1, 50_000, 2**31 - 1):
        connection = call()
        os.write(connection.fileno(), struct.pack("!i", length))
        assert f"at most {MOST_REQUEST_BYTES} bytes" in answered(connection)["error"], length
        assert ended(connection)
    connection = call()
    with contextlib.suppress(OSError):  # hung up on before it has all been said
        connection.send_bytes(b'{"request": "slow", "percent": ' + b"[" * 50_000)
    assert f"at most {MOST_REQUEST_BYTES} bytes" in answered(connection)["error"]
    assert ask_holder("bench", "status")["state"] == "standby"


def test_an_interval_of_any_size_is_a_time(holding, call):
    for number in ("-1e999", "-5", HUGE, "1e999"):
        connection = call()
        connection.send_bytes(f'{{"request": "watch", "every_s": {number}}}'.encode())
        assert answered(connection)["state"] == "standby", number


def test_a_flaw_in_an_answer_ends_no_thread_in_a_traceback(arm, holding, monkeypatch):
    trouble = []
    monkeypatch.setattr(threading, "excepthook", trouble.append)
    arm.program = lambda: 1 / 0
    assert "failed to answer: ZeroDivisionError" in ask_holder("bench", "status")["error"]
    with pytest.raises(HolderError, match="failed to answer: ZeroDivisionError"):
        next(watch_holder("bench", 0.05))
    assert trouble == []


# -- the caller's side ----------------------------------------------------------------------------


@posix
def test_a_program_that_accepts_no_connection_does_not_block_callers_for_ever(
    tmp_path, monkeypatch
):
    """One that is suspended does so."""
    monkeypatch.setattr(holder_notice, "PATIENCE_S", 0.05)
    monkeypatch.setattr("armdrive.storage.lock_client.PATIENCE_S", 0.05)
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as deaf, contextlib.ExitStack() as calls:
        deaf.bind("deaf")
        deaf.listen(0)
        monkeypatch.setattr(
            "armdrive.storage.lock_client.notice_of", lambda name: {"address": str(Path("deaf"))}
        )
        for _ in range(2):  # fill what the system keeps waiting
            with contextlib.suppress(OSError):
                calls.enter_context(called("deaf"))
        with pytest.raises(ArmError, match=r"cannot be asked|does not answer"):
            ask_holder("bench", "stop")

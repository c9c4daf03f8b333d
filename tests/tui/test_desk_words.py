"""What an error asks for stands on the desk as the key that does it."""

from desk_session import Session

from armdrive.status import State


async def test_an_error_names_keys_and_no_python():
    async with Session() as session:
        session.arm.set(state=State.ERROR_STOP, error="look at the arm, then call `reset()`")
        await session.settle()
        banner = session.text("banner")
        assert "then press R" in banner
        assert "reset()" not in banner

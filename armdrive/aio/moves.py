"""The async twins of the calls whose keyword arguments or `wait=` need a signature in full."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, overload

from armdrive.aio.handle import AsyncHandle
from armdrive.aio.twins import Twin
from armdrive.arm import Arm
from armdrive.calls.teaching import Place
from armdrive.flows.jogging import Jogged
from armdrive.flows.motion import Moved
from armdrive.frames import BASE
from armdrive.handle import Handle
from armdrive.intents import BASE_FRAME
from armdrive.preview import Preview
from kinematics import Pose
from kinematics.paths.parts import Move


class AsyncMoves(Twin[Arm]):
    """The motions with `wait=`; what each does stands at its namesake of `Arm`."""

    @overload
    async def move_j(
        self, *, speed: float = 1.0, wait: Literal[True] = True, **joints_deg: float
    ) -> Moved: ...
    @overload
    async def move_j(
        self, *, speed: float = 1.0, wait: Literal[False], **joints_deg: float
    ) -> AsyncHandle[Moved]: ...
    async def move_j(
        self, *, speed: float = 1.0, wait: bool = True, **joints_deg: float
    ) -> Moved | AsyncHandle[Moved]:
        """Move the named joints; see `Arm.move_j`."""
        return await self._go(lambda: self.sync.move_j(speed=speed, wait=False, **joints_deg), wait)

    @overload
    async def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[True] = True
    ) -> Moved: ...
    @overload
    async def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move the tip to a pose by a joint motion; see `Arm.move_to`."""
        return await self._go(
            lambda: self.sync.move_to(goal, speed=speed, frame=frame, wait=False), wait
        )

    @overload
    async def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[True] = True
    ) -> Moved: ...
    @overload
    async def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move the tip to a pose along a straight line; see `Arm.move_l`."""
        return await self._go(
            lambda: self.sync.move_l(goal, speed=speed, frame=frame, wait=False), wait
        )

    @overload
    async def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    async def move_c(
        self, via: Pose, goal: Pose, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_c(
        self, via: Pose, goal: Pose, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move the tip along an arc, through `via`; see `Arm.move_c`."""
        return await self._go(
            lambda: self.sync.move_c(via, goal, speed=speed, frame=frame, wait=False), wait
        )

    @overload
    async def move_path(
        self,
        moves: Sequence[Move],
        *,
        speed: float = 1.0,
        frame: str = BASE,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    async def move_path(
        self, moves: Sequence[Move], *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_path(
        self, moves: Sequence[Move], *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move through several moves as one; see `Arm.move_path`."""
        return await self._go(
            lambda: self.sync.move_path(moves, speed=speed, frame=frame, wait=False), wait
        )

    async def jog_j(
        self, *, speed: float = 0.25, duration_s: float | None = None, **axes: float
    ) -> Jogged:
        """Jog joints, by increments or for a time; see `Arm.jog_j`."""
        return await self.carry(lambda: self.sync.jog_j(speed=speed, duration_s=duration_s, **axes))

    async def jog_l(
        self,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        frame: str = BASE_FRAME,
        **axes: float,
    ) -> Jogged:
        """Jog the tip, by increments or for a time; see `Arm.jog_l`."""
        return await self.carry(
            lambda: self.sync.jog_l(speed=speed, duration_s=duration_s, frame=frame, **axes)
        )

    async def preview(
        self,
        goal: Place | None = None,
        *,
        line: bool = False,
        frame: str = BASE,
        speed: float = 1.0,
        **joints_deg: float,
    ) -> Preview:
        """Return what a motion would be, or why it is refused; see `Arm.preview`."""
        return await self.carry(
            lambda: self.sync.preview(goal, line=line, frame=frame, speed=speed, **joints_deg)
        )

    async def _go(
        self, begin: Callable[[], Handle[Moved]], wait: bool
    ) -> Moved | AsyncHandle[Moved]:
        """Begin a motion, and wait for its end where that is wanted."""
        if wait:
            return await self.carry(lambda: begin().wait())
        return AsyncHandle(await self.carry(begin), self.carry)

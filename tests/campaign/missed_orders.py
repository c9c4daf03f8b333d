"""The faults by which some drives of an arm get their orders and others do not, as excuses.

A drive in another mode stands, and rejects the next order. Until the driver sees that, the other
drives go on, and a joint that several drives turn may leave its path and pass its limit. The same
happens if a program dies while it sends one order to each drive, and on a line that damages frames.
"""

from armdrive.dialects.bus.intervals import MAX_DELAY_S
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.dialects.mks.drive import START_WINDOW_S
from armdrive.dialects.mks.settings import MksSettings

from .excuses import MissedOrders, one_motor_rates_rad_s, shared_joints
from .stage import Stage

ORDER_PERIODS = 2.0
"""A moving MKS drive gets its next order after this many periods of steering, at the latest."""
SHOWN_PERIODS = 3.0
"""A CiA 402 drive's new mode shows at the next SYNC, and the driver reads it one SYNC later."""
APART_LOOKS = 2.0
"""An MKS drive is found off its path at this many looks once it is `MAX_DELAY_S` behind. One that
leaves everything unanswered is noticed sooner (`ObservedDrive.may_have_restarted`)."""
QUERY_S = 0.01
"""Three queries with their replies and a stop take this long on the bus."""


def orders_ignored(stage: Stage, motor: int, for_s: float) -> MissedOrders:
    """Return the excuse for a drive that ignores its orders from now on. Motors count from 0."""
    rows = zip(stage.world.joints.names, stage.world.body.transmission.inverse, strict=False)
    turned = frozenset(name for name, row in rows if row[motor])
    return MissedOrders(_rates(stage, turned), stage.now_s + for_s, _noticed_s(stage))


def orders_cut_short(stage: Stage) -> MissedOrders | None:
    """Return the excuse for a program that dies when only some drives have got their orders.

    MKS drives get one frame each, and drive each order to its end: a joint that several drives turn
    is right again only when all have got theirs. None if one frame starts all drives at once.
    """
    return orders_lost(stage, 0.0)


def excuse_cut_off(stage: Stage) -> None:
    """Excuse drives that are cut off while frames overtake each other.

    A frame that waits to be overtaken then never arrives, and its drive ends at the order before.
    """
    if stage.now_s < stage.late_orders_until_s and (excuse := orders_cut_short(stage)) is not None:
        stage.watch.missed_orders = excuse


def orders_lost(stage: Stage, for_s: float) -> MissedOrders | None:
    """Return the excuse for MKS drives each of which may miss its orders for `for_s`.

    None while no program is connected: then no drive turns. None for CiA 402 drives, which get a
    target with every SYNC: `LostTargets` is about these.
    """
    settings = stage.config.device
    if not isinstance(settings, MksSettings) or stage.arm is None:
        return None
    stands_s = for_s + stage.arm.status.silent_time_s
    stands_by_s = stage.now_s + stands_s
    rates = _rates(stage, shared_joints(stage.config))
    apart_s = MAX_DELAY_S + APART_LOOKS * settings.poll_s
    return MissedOrders(rates, stands_by_s, stands_s, stands_by_s, apart_s)


def _rates(stage: Stage, joints: frozenset[str]) -> dict[str, float]:
    rates = one_motor_rates_rad_s(stage.config)
    return {name: rates[name] for name in joints}


def _noticed_s(stage: Stage) -> float:
    """Return how long the arm goes on without one drive before all drives stand."""
    settings = stage.config.device
    if isinstance(settings, Cia402Settings):  # each drive reports its mode with every SYNC
        return SHOWN_PERIODS * settings.period_ms / 1000.0 + settings.quick_stop_s + QUERY_S
    assert isinstance(settings, MksSettings)
    notice_s = ORDER_PERIODS * settings.segment_s + START_WINDOW_S + QUERY_S
    brakes_s = 0.0 if stage.arm is None else getattr(stage.arm.parts.core.controller, "ramp_s", 0.0)
    return notice_s + brakes_s

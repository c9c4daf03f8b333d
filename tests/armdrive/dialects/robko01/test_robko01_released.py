"""A jog of a Robko 01 whose first command is lost, and which is let go of meanwhile."""

from armdrive import Arm, Jog
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry.simulate import simulate

MOVE = 0x07


def test_a_lost_jog_is_not_sent_again_once_it_is_released(monkeypatch):
    config = simulated_config("robko01")
    twin = simulate(config)
    sent, write = [], twin.link.write

    def losing(data, now_s):
        if len(data) > 8 and data[3] == MOVE and any(data[6:8]):  # not the one at speed 0
            sent.append(data)
            arm.release()
            return
        write(data, now_s)

    with Arm(connect_simulated(config, twin=twin)) as arm:
        monkeypatch.setattr(twin.link, "write", losing)
        before = twin.world.motors
        arm.hold(Jog.joint(base=1.0), speed=1.0, for_s=1.0)
        arm.sleep(2.0)
        assert len(sent) == 1
        assert twin.world.motors == before

"""The async twin of an arm: every call of `Arm` and of its gripper, awaited.

In real time each call runs in a thread of its own. On simulated time such a thread and the event
loop hand one turn to and fro: only one of them runs at any moment, and the same program gives the
same result each time.
"""

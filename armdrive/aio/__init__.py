"""The async version of an arm: the calls of `Arm` and of its gripper, as coroutines.

In simulated time everything runs on the event loop's thread, so that a program gives the same
result each time. In real time each call has a thread.
"""

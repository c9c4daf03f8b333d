"""The async twin of an arm: every call of `Arm` and of its gripper, awaited.

In simulated time the event loop resumes each call after its waits: everything runs on the loop's
thread, and the same program gives the same result each time. In real time each call has a thread.
"""

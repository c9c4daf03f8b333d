"""Connects an arm, reconnects it, and answers other programs that ask about it.

Which file decides what:

    target          which arm a name means; whether simulation is forced
    parts           the parts of an arm and how they are assembled
    runner          submitting a task, waiting for its end, requesting a stop
    connection      closing an arm: on request, at the program's end, or once the program lost it
    port            which port is opened, why a connection failed, when a lost one is tried again
    control_socket  what other programs may request of an arm: one table
"""

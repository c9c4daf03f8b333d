"""Moving an arm: goals, plans, their execution, jogging, the gripper, and tasks while it stands.

A planned move goes through these files in this order:

    frames      a goal or jog in the base frame, whichever frame it was given in
    resolve     a relative request made absolute; the goal of `park`
    plan        corners in joint space, timed; the audit that limits, guards and posture pass
    preview     the same plan shown and not sent: margins, clearances, other postures, what is near
    execute     bursts or a stream, their length, waiting in a pause, the result
    deviation   how far an uncoordinated burst may stray, and the order in which its motors turn
    context     what every task may do: requests, reading back and comparing, how long unread

Other tasks and functions:

    jog/        a held jog and an increment: speed, bounds, end
    dead_man    which key repeats count as held, and how long a hold outlives the last one
    gripper     setting an opening, grasping until the switch
    reference   home, the confirmation of a posture, drift and its verdict
    connecting  whether a saved position is trusted, current on and off, reset, idle polls,
                reconnecting
    shape       points mirrored, shifted and turned
    device      settings, stored program and outputs of the controller
"""

"""Commands that drive an arm, or send a request to the program that drives it.

Which file decides what:

    home              how an arm is referenced, with which questions; measuring its drift
    move              which move the options mean, and its preview; saving a point
    jog               the desk in a terminal, and which arm or model it is opened on
    motors            the motor current: whether `disable` parks the arm first
    points            the file of saved points; copies, mirrored and offset ones
    control_requests  stop, pause, resume, slow, record: which arm is asked
    arguments         the options of all of them, and the text of their help
"""

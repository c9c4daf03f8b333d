"""What drives on a CAN bus share, whatever protocol they speak.

Read in this order:

    paths      the planned path of all motors, and each drive's course by its orders
    ledger     the open questions to a drive, and the replies that it owes
    observer   conclusions from orders, questions and replies: the table of verdicts
    phases     what the drives of an arm do together: the table of phases and signals, and the
               stages of every dialect: the end of an earlier motion, stopping, homing
    drives     the motors of an arm, one drive each; ids, settings, missing drives
    tools      work on a bus without an arm: surveying drives and setting them up
    words      one frame described in words
    row        the registry entry of an arm with such drives

If an MKS drive falls silent in motion, its ledger counts the unanswered polls. The observer
concludes `mute` (`silent` if no drive replies), and the table of `phases` stops the others and
reports why. A CiA 402 drive reports at every SYNC, so there the missed reports are counted instead
(`cia402.leading`).
"""

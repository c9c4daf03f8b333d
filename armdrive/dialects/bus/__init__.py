"""What drives on a CAN bus have in common, whatever they speak.

Read in this order:

    way        where the drives shall be, and where each is by its orders
    ledger     which questions to a drive are open, and which it never answered
    observer   what orders, questions and readings say together: the table of verdicts
    group      what the drives of an arm do together: the table of phases and signals
    motors     the motors of an arm, one drive each; their ids
    tools      what can be done on a bus without an arm: surveys, setting drives up
    words      one frame in words
    row        what the registry says of an arm on such drives

When a drive falls silent in motion its ledger counts the looks that it leaves unanswered, the
observer says `mute` (or `silent`, where all are), and the group stops the others and explains.
"""

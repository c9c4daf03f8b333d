"""The lecture notes: systems, worked examples, symbols, efficiency and accuracy.

    systems/         the arms of the notes, by name
    study            all that follows from one posture; `pages` and `notation` print it
    worked_example   a study in the lecture's words
    thirteen_steps   frames and link parameters from joint axes
    stepping         jogging a model
    symbols          symbolic numbers
    efficiency       arithmetic counted
    accuracy         steps, rounding and wrong parameters at the tip

A system is solved by one set of formulas, which run on numbers of any kind
(`kinematics.frames.numbers`): on floats for a posture (`study`), on symbols for the formulas as the
notes print them (`symbols`, written by `notation`), and on counting numbers for what they cost
(`efficiency`). So what is printed is what is computed.

No code that drives an arm imports this package.
"""

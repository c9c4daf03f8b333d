"""The lecture notes: systems, worked examples, symbols, efficiency and accuracy.

    systems/         the arms of the notes, by name
    study            all that follows from one posture; `pages` and `notation` print it
    worked_example   a study in the lecture's words
    thirteen_steps   frames and link parameters from joint axes
    stepping         jogging a model
    symbols          symbolic numbers
    efficiency       arithmetic counted
    accuracy         steps, rounding and wrong parameters at the tip

No code that drives an arm imports this package.
"""

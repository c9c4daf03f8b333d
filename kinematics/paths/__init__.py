"""Lines, arcs, blends and the timing of motion along them.

What is decided where:

    curves     what the tip follows, the posture that is kept, and what counts as a leap
    chords     a curve cut into joint motions, as few as the tolerance allows
    routes     parts in sequence, and the blends between them
    timing     the quickest motion along chords within all limits
    profiles   one motion from rest to rest
"""

"""Lines, arcs, blends and the timing of motion along them.

Which file decides what:

    curves     the curve of the tip, its posture, and what counts as a jump of a joint
    chords     a curve as the fewest joint motions within the tolerance
    routes     parts in sequence, and the blends between them
    timing     the quickest motion along chords within all limits
    profiles   one motion from rest to rest
"""

"""Lines, arcs, blends and the timing of motion along them.

Which file decides what:

    curves     the curve of the tip, its posture, and what counts as a jump of a joint
    chords     a curve as the fewest joint motions within the tolerance
    routes     parts in sequence, and the blends between them
    timing     the quickest motion along chords within all limits
    profiles   one motion from rest to rest

How a move becomes motion:

1. `line_path` or `route_sections`: a straight line, or parts in sequence, as corners in joint
   space. Each curve is solved in the posture that it starts in, and cut where a joint motion would
   leave it or turn sharply.
2. `timed`: corners and limits as a path in time, from rest to rest.
3. `TimedPath.pieces`: that path as pieces of constant speed, which drivers send.

Guards and joint limits judge the corners in between (`armdrive.motion.plan`), never the curves.
"""

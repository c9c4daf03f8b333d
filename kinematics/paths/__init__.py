"""Lines, arcs, blends and the timing of motion along them."""

"""Files that armdrive keeps: saved positions, points, locks, and verification logs."""

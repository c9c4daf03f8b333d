"""One suite of behaviours that every dialect has, on simulated arms and on real ones."""

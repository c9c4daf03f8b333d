"""One suite of behaviours that every dialect keeps, on simulated arms and on real ones."""

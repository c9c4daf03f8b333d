"""The fault campaign: thousands of seeded missions on simulated arms that things go wrong with."""

"""The fault campaign: thousands of seeded missions on simulated arms, disturbed by faults."""

"""The lecture notes: systems, worked examples, symbols, efficiency and accuracy.

No code that drives an arm imports this package.
"""

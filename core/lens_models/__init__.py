"""Approximations of a traced lens: polynomials fitted in rotation invariants."""

"""Approximations of a traced lens: fitted polynomials, and a table of rays for comparison."""

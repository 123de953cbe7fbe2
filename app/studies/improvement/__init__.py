"""Improvement of a lens by damped least squares: the merit function, the steps, and the lens that they change."""

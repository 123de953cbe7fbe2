"""Design of a lens: the merit function, and the lens that it is improved to."""

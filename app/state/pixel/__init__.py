"""What the mouse points at, followed through the lens: rays, spot and figures of one pixel."""

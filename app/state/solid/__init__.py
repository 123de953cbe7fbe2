"""The lens, its rays, its film and the scene as solids in space, for the 3-D view."""

"""The surfaces of the lens as a table that is edited."""

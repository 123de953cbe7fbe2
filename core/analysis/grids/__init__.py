"""The ray grid: fields, chief rays, the beams of fields, the open pupil, and the rays traced through it."""

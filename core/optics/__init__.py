"""One lens: glass, surfaces, prescription, iris, zoom positions, paraxial optics, ray traces, focus, depth of field."""

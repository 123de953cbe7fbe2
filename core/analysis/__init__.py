"""Image quality of a lens: aberrations, distortion, vignetting; model error and model choice."""

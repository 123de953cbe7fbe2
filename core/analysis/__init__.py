"""What a lens does to an image: aberrations, distortion, vignetting; model error and model choice."""

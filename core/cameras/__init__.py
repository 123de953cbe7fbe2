"""Every camera: weighted rays from film and pupil samples, and projection onto the film."""

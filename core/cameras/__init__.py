"""Every camera: from film and pupil samples to weighted rays, and back to the film."""

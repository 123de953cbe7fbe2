"""Recording, refocusing and inspection of light fields."""

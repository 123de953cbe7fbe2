"""Scene objects, materials and light as frozen values, a file for each kind."""

"""The film's side: film, field of view, shutter, exposure, sensor, spectrum, transforms and coordinate spaces."""

"""Settings: everything that a person can set, as one frozen value, with its table and its texts."""

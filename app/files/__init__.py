"""Reading and writing of a user's files: pictures, settings, light fields."""

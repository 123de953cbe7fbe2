"""What the library offers at a prompt and in notebooks: pictures that show themselves, names instead of objects."""

"""From settings to lens, film, camera and focus, with their read-outs and limits. No window."""

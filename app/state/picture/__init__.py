"""From a rendered picture to the shown one: exposure, tone, statistics, false colours. No window."""

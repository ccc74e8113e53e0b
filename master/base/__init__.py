"""What every room stands on: errors, settings, files, texts, streams. Knows no FMU."""

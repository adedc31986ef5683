"""What is handed in: reading, running, comparing, marking, reporting; the command line on top."""

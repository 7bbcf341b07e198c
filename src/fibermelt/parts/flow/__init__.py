"""The flow: solved or given, and the paths through it."""

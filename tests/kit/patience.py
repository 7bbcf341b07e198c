"""How long a test waits for what must come: it is judged by what comes, and never by when."""

PATIENCE = 600.0
"""Time [s] after which something hangs: ten times what the slowest process here takes on a machine
with five others at work on each core."""

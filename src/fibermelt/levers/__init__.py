"""What helps against voids: each lever of a printer moved by a step, run, and put in order."""

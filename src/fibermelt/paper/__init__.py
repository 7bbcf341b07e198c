"""What is of the paper alone: its single fibers in shear, its claims."""

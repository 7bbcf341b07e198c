"""What a single command answers without a results folder of its own."""

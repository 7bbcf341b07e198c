"""What this installation is checked against."""

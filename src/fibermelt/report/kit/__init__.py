"""What figures and pages are made with."""

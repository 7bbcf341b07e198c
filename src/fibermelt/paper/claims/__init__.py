"""The paper's claims, and the numbers that they are judged by."""

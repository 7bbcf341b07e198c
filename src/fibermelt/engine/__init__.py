"""What runs a study and keeps its results, and knows no physics."""

"""What a person looks at: figures of a finished study. matplotlib is imported here only."""
